//! A serial line: what is stuffed comes out as it was, and whatever was on the line before, the next frame gets through.

use slqg::wire::serial::{Unstuffer, stuff, stuffed_len};

/// Bytes of the longest frame that the receiver has room for.
const ROOM: usize = 48;

/// Takes the bytes for a frame, and for what is on the line.
pub fn check(bytes: &[u8]) {
    as_frame(bytes);
    on_the_line(bytes);
}

fn as_frame(frame: &[u8]) {
    let mut buffer = vec![0xa5; stuffed_len(frame.len())];
    let line = stuff(frame, &mut buffer).expect("there is room").to_vec();
    let (end, stuffed) = line.split_last().expect("a zero at least");
    assert!(*end == 0 && !stuffed.contains(&0), "one zero, at the end");
    assert_eq!(unstuffed(stuffed).as_deref(), Some(frame), "read by hand");
    assert!(stuff(frame, &mut buffer[..line.len() - 1]).is_err(), "no shorter buffer holds it");
    // A frame of no byte is nothing on the line.
    let is_taken = (1..=ROOM).contains(&frame.len());
    let expected: Vec<_> = is_taken.then(|| frame.to_vec()).into_iter().collect();
    assert_eq!(taken(&line), (expected, u32::from(frame.len() > ROOM)));
}

fn on_the_line(line: &[u8]) {
    // A zero ends what was there, and the frame behind it is whole.
    let last = [1, 0, 2];
    let mut buffer = [0; 8];
    let line = [line, &[0], stuff(&last, &mut buffer).expect("there is room")].concat();
    let (frames, lost) = taken(&line);
    assert_eq!(frames.last().map(Vec::as_slice), Some(&last[..]), "in step again");
    // Between two zeros in a row there is nothing.
    let pieces: Vec<&[u8]> = line.split(|byte| *byte == 0).filter(|piece| !piece.is_empty()).collect();
    let expected: Vec<Vec<u8>> =
        pieces.iter().filter_map(|piece| unstuffed(piece)).filter(|frame| frame.len() <= ROOM).collect();
    assert_eq!(frames, expected, "the frames between zeros, read by hand");
    assert_eq!(usize::try_from(lost), Ok(pieces.len() - expected.len()), "the others are counted");
}

/// What a receiver takes from the line, and how many frames it has lost.
fn taken(line: &[u8]) -> (Vec<Vec<u8>>, u32) {
    let mut unstuffer = Unstuffer::<ROOM>::default();
    let frames = line.iter().filter_map(|byte| unstuffer.take(*byte).map(<[u8]>::to_vec)).collect();
    (frames, unstuffer.lost())
}

/// Consistent overhead byte stuffing, undone as its authors write it (Cheshire and Baker 1999); `None` if it is none.
fn unstuffed(mut stuffed: &[u8]) -> Option<Vec<u8>> {
    let mut frame = Vec::new();
    while let Some((code, rest)) = stuffed.split_first() {
        let (block, rest) = rest.split_at_checked(usize::from(*code).checked_sub(1)?)?;
        frame.extend(block);
        if *code < u8::MAX && !rest.is_empty() {
            frame.push(0);
        }
        stuffed = rest;
    }
    Some(frame)
}
