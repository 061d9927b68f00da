//! Whether a node's log tells that it is lost or has failed.
//!
//! Messages are frames in rzCOBS, a zero after each; the first two bytes of a message are the number of its format.

/// Whether a message of one of these formats is in the log.
pub(crate) fn tells(log: &[u8], formats: &[u16]) -> bool {
    log.split(|byte| *byte == 0).any(|frame| {
        let message = decoded(frame);
        matches!(message[..], [low, high, ..] if formats.contains(&u16::from_le_bytes([low, high])))
    })
}

/// What rzCOBS makes of a frame, which is read from its end; what is damaged is left out.
fn decoded(mut frame: &[u8]) -> Vec<u8> {
    let mut reversed = Vec::new();
    while let Some((code, rest)) = frame.split_last() {
        frame = rest;
        match code {
            0x00 => (),
            0x01..=0x7f => {
                for bit in (0..7).rev() {
                    if code >> bit & 1 == 0 {
                        take(&mut frame, &mut reversed, 1);
                    } else {
                        reversed.push(0);
                    }
                }
            }
            0x80..=0xfe => {
                reversed.push(0);
                take(&mut frame, &mut reversed, usize::from(code & 0x7f) + 7);
            }
            0xff => take(&mut frame, &mut reversed, 134),
        }
    }
    reversed.reverse();
    reversed
}

fn take(frame: &mut &[u8], reversed: &mut Vec<u8>, count: usize) {
    let (rest, taken) = frame.split_at(frame.len() - count.min(frame.len()));
    reversed.extend(taken.iter().rev());
    *frame = rest;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_found_by_the_number_of_its_format() {
        // Format 0x0102 and an argument 0x0003: bytes 02 01 03 00, whose zero is a bit of the last byte.
        let log = [0x02, 0x01, 0x03, 0b0100_0000, 0x00];
        assert_eq!(decoded(&log[..4]), [0x02, 0x01, 0x03, 0x00]);
        assert!(tells(&log, &[7, 0x0102]));
        assert!(!tells(&log, &[0x0103]));
    }
}
