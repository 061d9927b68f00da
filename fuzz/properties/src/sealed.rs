//! A loop whose frames are sealed, and somebody on its line who records, changes, repeats and makes up what he likes but has no key: an end
//! takes only what its peer has sealed, each once, and does then what the same end does without a guard; and once the line is
//! clean, the ends find a session again.

mod line;

use crate::script::{any_bytes, any_frame, byte, up_to, whole};
use arbitrary::{Result, Unstructured};
use line::{End, Line, Loop, Sent};
use slqg::authentication::{HELLO, HELLO_LEN, SEALED, TAG_LEN};

/// Plays a script: the first bytes say which loop it is, the others what happens on its line.
pub fn check(bytes: &[u8]) {
    let mut script = Unstructured::new(bytes);
    // A script that ends early has ended.
    let _ = Loop::played(&mut script, |looped, line, script| {
        while !script.is_empty() {
            event(looped, line, script)?;
        }
        looped.recovers();
        Ok(())
    });
}

fn event(looped: &mut Loop<'_>, line: &mut Line, script: &mut Unstructured<'_>) -> Result<()> {
    match up_to(script, 9)? {
        0 | 1 => looped.cycle(line, f32::from(script.arbitrary::<i8>()?) / 16.0),
        2 | 3 => {
            // As it was sent, now or again.
            let Some(place) = recorded(line, script)? else { return Ok(()) };
            let Sent { to, bytes, .. } = line.sent[place].clone();
            looped.deliver(line, to, &bytes);
        }
        4 => {
            // Changed, or to another end.
            let Some(place) = recorded(line, script)? else { return Ok(()) };
            let mut bytes = line.sent[place].bytes.clone();
            let (at, change) = (usize::from(byte(script)?) % bytes.len(), byte(script)?);
            bytes[at] ^= change;
            let bytes = if up_to(script, 1)? == 0 { whole(&bytes) } else { bytes };
            looped.deliver(line, end(script)?, &bytes);
        }
        5 => {
            let (to, tag) = (end(script)?, script.arbitrary::<[u8; TAG_LEN]>()?);
            let frame = any_frame(script, looped.tick())?;
            let bytes = [&[SEALED][..], &tag, &frame].concat();
            looped.deliver(line, to, &bytes);
        }
        6 => {
            let (to, first) = (end(script)?, up_to(script, 2)?);
            let bytes = [&[[SEALED, HELLO, 1][usize::from(first)]], any_bytes(script)?].concat();
            looped.deliver(line, to, &bytes);
        }
        7 => {
            let (to, mut bytes) = (end(script)?, [0; HELLO_LEN]);
            for byte in &mut bytes {
                *byte = script.arbitrary()?;
            }
            bytes[0] = HELLO;
            looped.deliver(line, to, &bytes);
        }
        8 => looped.shake(line),
        _ => {
            // A frame without its tag.
            let Some(place) = recorded(line, script)? else { return Ok(()) };
            let Sent { to, bytes, .. } = line.sent[place].clone();
            looped.deliver(line, to, bytes.get(1 + TAG_LEN..).unwrap_or_default());
        }
    }
    Ok(())
}

/// One of the newest frames on record.
fn recorded(line: &Line, script: &mut Unstructured<'_>) -> Result<Option<usize>> {
    let ago = usize::from(byte(script)?);
    Ok(line.sent.len().checked_sub(1 + ago % line.sent.len().max(1)))
}

fn end(script: &mut Unstructured<'_>) -> Result<End> {
    Ok(match up_to(script, 2)? {
        0 => End::Controller,
        1 => End::Actuator,
        _ => End::Sensor,
    })
}
