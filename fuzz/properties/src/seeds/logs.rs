//! Logs of a link behind five bytes of options, as [`crate::logs`] reads them.

use super::{Seed, frames};
use slqg::Tick;

/// Format, gaps, kind of frame, and where the second log begins (0: there is one); then the length of a cycle in milliseconds, less one.
type Options = [u8; 5];

const RECOGNISED: Options = [0, 0, 2, 0, 9];
const WITH_LOSSES: Options = [1, 1, 2, 0, 9];

pub(super) fn seeds() -> Vec<Seed> {
    let log = |options: Options, log: &[u8]| [&options[..], log].concat();
    let table = "sequence,sent,received\n0,0.000,0.003\n1,0.010,0.031\n2,0.020,lost\n3,0.030,0.030\n7,0.070,0.0712\n7,0.07,0.08\n";
    let counted = "(1.000100) can0 123#00000000\n(1.000200) can1 123#00000000\n(1.010000) can0 123#01000000\n\
                   (1.020000) can0 123#02000000 T\n(1.030100) can1 123#02000000 R\n(1.04) can0 7FF#R\n";
    let frame = |tick| frames::control::<f32, 1>(Tick(tick), &[[1.0]]);
    let flexible = |time: &str, interface: &str, tick: u32| {
        let digits: String = frame(tick).iter().map(|byte| format!("{byte:02X}")).collect();
        format!("({time}) {interface} 18DAF110##1{digits}\n")
    };
    let framed = ["0.0", "0.01", "0.02"]
        .iter()
        .zip(0..)
        .map(|(time, tick)| flexible(time, "can0", tick) + &flexible(&format!("{time}5"), "can1", tick));
    let sent = capture([(0, 0), (10_000, 1), (20_000, 2)].map(|(time, tick)| (time, frame(tick))));
    let received = capture([(2_000, 0), (31_000, 2)].map(|(time, tick)| (time, frame(tick))));
    // Both logs in one piece, cut in parts of 256.
    let total = (sent.len() + received.len()) as u32;
    let part = (1..=255).find(|part| total * part / 256 == sent.len() as u32).unwrap_or(153);
    vec![
        ("table", log(RECOGNISED, table.as_bytes())),
        ("table_with_losses", log(WITH_LOSSES, table.replace("lost", "").as_bytes())),
        (
            "table_of_far_times",
            log(
                WITH_LOSSES,
                b"sent,received,sequence\n-4611686017,4611686017,18446744073709551615\n1e3,1e4,3\n",
            ),
        ),
        ("candump_of_a_counter", log(RECOGNISED, counted.as_bytes())),
        ("candump_of_frames", log(RECOGNISED, framed.collect::<String>().as_bytes())),
        ("two_captures", log([3, 2, 2, part as u8, 9], &[sent, received].concat())),
        ("one_capture", log(RECOGNISED, &capture([(0, frame(0))]))),
        ("no_log", log(RECOGNISED, b"\x0a\x0d\x0d\x0a and so on")),
    ]
}

/// A capture in the classic format, of raw IPv4 and UDP, with microseconds.
fn capture<const PACKETS: usize>(packets: [(u32, Vec<u8>); PACKETS]) -> Vec<u8> {
    let mut bytes =
        vec![0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 101, 0, 0, 0];
    for (microseconds, payload) in packets {
        let length = 20 + 8 + payload.len() as u32;
        bytes.extend([1, microseconds, length, length].map(u32::to_le_bytes).concat());
        // Version and length of the header, no fragment, UDP; addresses and ports do not matter.
        bytes.extend([0x45, 0, 0, 0, 0, 0, 0, 0, 64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2]);
        bytes.extend([0, 1, 0, 2, 0, 0, 0, 0]);
        bytes.extend(payload);
    }
    bytes
}
