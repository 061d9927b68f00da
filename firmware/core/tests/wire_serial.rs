//! Frames come off a serial line as they went onto it, whatever else is on the line.

use proptest::collection::vec;
use proptest::prelude::*;
use slqg::wire::serial::{Unstuffer, stuff, stuffed_len};

fn on_the_line(frame: &[u8]) -> Vec<u8> {
    let mut buffer = vec![0; stuffed_len(frame.len())];
    stuff(frame, &mut buffer).expect("it is as long as it says").to_vec()
}

fn taken<const C: usize>(unstuffer: &mut Unstuffer<C>, bytes: &[u8]) -> Vec<Vec<u8>> {
    bytes.iter().filter_map(|&byte| unstuffer.take(byte).map(<[u8]>::to_vec)).collect()
}

#[test]
fn a_frame_is_stuffed_as_the_page_says() {
    assert_eq!(on_the_line(&[1, 0, 0, 2, 3]), [2, 1, 1, 3, 2, 3, 0]);
    assert!(stuff(&[1, 2, 3], &mut [0; 4]).is_err(), "five bytes are needed");
}

#[test]
fn a_frame_longer_than_the_receiver_holds_is_dropped_whole() {
    let mut unstuffer = Unstuffer::<4>::default();
    assert!(taken(&mut unstuffer, &on_the_line(&[7; 5])).is_empty());
    assert_eq!(unstuffer.lost(), 1);
    assert_eq!(taken(&mut unstuffer, &on_the_line(&[7; 4])), [[7; 4]]);
}

proptest! {
    #[test]
    fn frames_come_off_as_they_went_on(frames in vec(vec(any::<u8>(), 1..300), 1..5)) {
        let mut unstuffer = Unstuffer::<300>::default();
        let line: Vec<u8> = frames.iter().flat_map(|frame| on_the_line(frame)).collect();
        prop_assert_eq!(taken(&mut unstuffer, &line), frames);
        prop_assert_eq!(unstuffer.lost(), 0);
    }

    /// What follows a zero does not depend on what came before it.
    #[test]
    fn a_receiver_is_in_step_after_the_next_zero(noise in vec(any::<u8>(), 0..50), frame in vec(any::<u8>(), 1..30)) {
        let mut unstuffer = Unstuffer::<32>::default();
        taken(&mut unstuffer, &noise);
        taken(&mut unstuffer, &[0]);
        prop_assert_eq!(taken(&mut unstuffer, &on_the_line(&frame)), [frame]);
    }
}
