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
        ("view_of_candump", log([4, 2, 4, 0, 9], VIEW)),
        ("vector_asc", log([5, 2, 4, 0, 9], ASC)),
        ("vector_blf", log([6, 2, 4, 0, 9], &blf())),
        ("peak_trc", log([7, 2, 4, 0, 9], TRC)),
        ("python_can_printed", log([8, 2, 4, 0, 9], PRINTED)),
        ("python_can_csv", log([9, 2, 4, 128, 9], &[PYTHON_CAN_CSV, PYTHON_CAN_CSV].concat())),
        ("irtt", log([10, 2, 2, 0, 9], IRTT)),
        ("owping", log([11, 2, 2, 0, 9], OWPING)),
        ("ping", log([12, 2, 2, 0, 9], PING)),
        ("fping", log([13, 2, 2, 0, 9], FPING)),
        ("no_log", log(RECOGNISED, b"\x0a\x0d\x0d\x0a and so on")),
    ]
}

const VIEW: &[u8] = b" (000.000000)  can0  123   [2]  00 09\n (000.002000)  can1  123   [2]  00 09\n\
 (000.010000)  can0  123   [2]  01 07\n (000.012000)  can0  20000088   [8]  00 00 08 00 00 00 00 00   ERRORFRAME\n\
 (000.020000)  can0  123   [2]  02 08\n (000.023000)  can1  123   [2]  02 08\n";

const ASC: &[u8] = b"date Tue Nov 14 22:13:20 2023\nbase hex  timestamps absolute\n   0.000000 can0  123             Rx   d 2 00 55\n\
   0.010000 1  123             Rx   d 2 01 55\n   0.020000 CANFD   1 Rx        123   1 0 2  2 02 55\n   0.03 2  ErrorFrame\n";

const TRC: &[u8] = b";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n      0         0.000 DT can0     0123 Tx -  2    00 00\n\
      1         4.700 DT can1     0123 Rx -  2    00 00\n      2        10.000 DT can0     0123 Tx -  2    01 00\n      3 11 RR can0 0123 Tx - 0\n";

const PRINTED: &[u8] =
    b"Timestamp: 1.5    ID:      123    S Tx                DL:  2    00 01     Channel: can0\n\
Timestamp: 1.51    ID:      123    S Tx                DL:  2    01 01     Channel: can0\n\
Timestamp: 1.52    ID:      123    S Rx                DL:  2    02 01     Channel: can1\n";

const PYTHON_CAN_CSV: &[u8] =
    b"timestamp,arbitration_id,extended,remote,error,dlc,data\n1.5,0x123,0,0,0,2,AAE=\n\
1.51,0x123,0,0,0,2,AQE=\n1.52,0x123,0,0,0,2,AgE=\n1.53,0x123,0,0,0,2,AwE=\n";

const IRTT: &[u8] = br#"{"round_trips":[{"seqno":0,"lost":"false","timestamps":{"client":{"receive":{"wall":30},"send":{"wall":0}},
"server":{"receive":{"wall":15},"send":{"wall":16}}}},{"seqno":1,"lost":"true_up","timestamps":{"client":{"receive":{},"send":{"wall":9}},
"server":{"receive":{},"send":{}}}}]}"#;

const OWPING: &[u8] = b"0 16788979058578197944 1 6.1e-05 16788979058594647669 1 7.3e-05 64\n\
1 16788979058621147617 1 6.1e-05 00000000000000000000 0 0 255\n";

const PING: &[u8] =
    b"PING\n[1.5] 64 bytes from a: icmp_seq=1 ttl=64 time=0.110 ms\n[1.52] no answer yet for icmp_seq=2\n\
[1.54] 64 bytes from a: icmp_seq=3 ttl=64 time=31.4 ms\n";

const FPING: &[u8] = b"[1.5] a : [0], 64 bytes, 0.035 ms (0.035 avg, 0% loss)\n[1.52] a : [1], timed out (0.043 avg, 2% loss)\n";

/// Two frames in one container that is not packed.
fn blf() -> Vec<u8> {
    let object = |of: u32, body: &[u8]| {
        let length = 16 + body.len() as u32;
        [
            &b"LOBJ"[..],
            &[if of == 10 { 16 } else { 32 }, 0, 1, 0],
            &length.to_le_bytes(),
            &of.to_le_bytes(),
            body,
        ]
        .concat()
    };
    let frame = |time: u64, channel: u8, count: u8| {
        let header = [&[2, 0, 0, 0, 0, 0, 0, 0][..], &time.to_le_bytes()].concat();
        object(86, &[&header[..], &[channel, 0, 0, 2, 0x23, 1, 0, 0], &[count, 0, 0, 0, 0, 0, 0, 0]].concat())
    };
    let inside =
        [frame(0, 1, 0), frame(1_999_990, 2, 0), frame(10_000_000, 1, 1), frame(20_000_000, 1, 2)].concat();
    let container = [&[0; 8][..], &(inside.len() as u32).to_le_bytes(), &[0; 4], &inside].concat();
    [&b"LOGG"[..], &8_u32.to_le_bytes(), &object(10, &container)].concat()
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
