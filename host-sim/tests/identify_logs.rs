//! `host-sim identify` reads logs of `candump` and captures as it reads a table, and says what is wrong with one.

mod links;

use links::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

/// The header of a control frame with `tick`, and the begin of its payload.
fn frame(tick: u32) -> Vec<u8> {
    [&[1, 2, 4][..], &tick.to_le_bytes(), &[1]].concat()
}

fn candump(time: u64, interface: &str, separator: &str, payload: &[u8]) -> String {
    let digits: String = payload.iter().map(|byte| format!("{byte:02X}")).collect();
    format!(
        "({}.{:06}) {interface} 123{separator}{digits}\n",
        time / 1_000_000_000,
        time % 1_000_000_000 / 1000
    )
}

/// Packets as both ends see them, the receiver's in the order of arrival.
fn ends(times: &[(u64, Option<u64>)]) -> [Vec<(u64, u32)>; 2] {
    // The tick wraps in the middle.
    let tick = |index: usize| (index as u32).wrapping_sub(times.len() as u32 / 2);
    let sent = times.iter().enumerate().map(|(index, time)| (time.0, tick(index))).collect();
    let received = times.iter().enumerate().filter_map(|(index, time)| Some((time.1?, tick(index))));
    let mut received: Vec<(u64, u32)> = received.collect();
    received.sort_unstable();
    [sent, received]
}

/// Times to the microsecond, of packets that all can be decided on; first and last arrive at once.
fn decidable() -> Vec<(u64, Option<u64>)> {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut fates = drawn(&network("double_integrator_bad.toml"), 2000, &mut random);
    fates[0] = Some(0);
    fates.extend([Some(0); 12]);
    let whole = |time: u64| time / 1000 * 1000;
    times(&fates, &mut random)
        .into_iter()
        .map(|(sent, received)| (whole(sent), received.map(whole)))
        .collect()
}

/// All but where the figures come from.
fn figures(mut json: Value) -> Value {
    for key in ["files", "format", "number"] {
        json[key] = Value::Null;
    }
    json["log"]["skipped"] = Value::Null;
    json
}

#[test]
fn candump_logs_say_the_same_as_a_table() {
    let folder = folder();
    let times = decidable();
    let expected = figures(json(&[&written(&folder, "t.csv", csv(&times))], &[]));
    let [sent, received] = ends(&times);
    let counter = |number: u32| [number.to_le_bytes(), [0xff; 4]].concat();
    let tx = ["--tx", "can0", "--rx", "can1", "--id", "123"];
    for (separator, payload) in [("#", &frame as &dyn Fn(u32) -> Vec<u8>), ("##1", &frame), ("#", &counter)] {
        let lines = |interface: &str, seen: &[(u64, u32)]| -> String {
            seen.iter()
                .map(|(time, number)| candump(*time, interface, separator, &payload(*number)))
                .collect()
        };
        let (sent, received) = (lines("can0", &sent), lines("can1", &received));
        let other = "(0.000001) can0 7FF#00\n(0.000002) can2 123#01020408\n(0.000003) can0 124#R\n";
        let both = written(&folder, "both.log", format!("{other}{received}{sent}"));
        assert_eq!(figures(json(&[&both], &tx)), expected, "one log");
        let (sender, receiver) = (written(&folder, "0.log", sent), written(&folder, "1.log", received));
        assert_eq!(figures(json(&[&sender, &receiver], &tx)), expected, "two logs");
    }
}

#[test]
fn packets_at_the_ends_of_the_logs_are_not_called_lost() {
    let folder = folder();
    // 0 before the receiver listens; 2 lost; 5 and 6 perhaps still under way, as 3 took 25 ms.
    let sent = [0, 1, 2, 3, 4, 5, 6]
        .map(|index: u32| candump(u64::from(index) * 10_000_000, "a", "#", &frame(index)));
    let received = [(12, 1), (42, 4), (55, 3), (58, 77)]
        .map(|(time, index)| candump(time * 1_000_000, "b", "#", &frame(index)));
    let path = written(&folder, "t.log", sent.concat() + &received.concat());
    let found = json(&[&path], &["--tx", "a", "--rx", "b"]);
    assert_eq!((&found["packets"], &found["loss"]["packets"]), (&4.into(), &1.into()));
    assert_eq!((&found["log"]["undecided"], &found["log"]["strays"]), (&3.into(), &1.into()));
}

#[test]
fn malformed_candump_logs_are_reported_with_file_and_line() {
    let folder = folder();
    let good = candump(0, "a", "#", &frame(0));
    let tx = ["--tx", "a", "--rx", "b"];
    let path = written(&folder, "t.log", format!("{good}(0.1) a 123#0\n"));
    refused(&[&path], &tx, &["t.log:2: found \"(0.1) a 123#0\"; give lines of candump -L"]);
    refused(&[&path], &[], &["--tx IFACE and --rx IFACE"]);
    let short = written(&folder, "t.log", format!("{good}(0.1) a 123#00\n"));
    refused(&[&short], &[&tx[..], &["--id", "123"]].concat(), &["t.log: found no counter", "--counter"]);
    let silent = written(&folder, "t.log", &good);
    refused(&[&silent], &tx, &["the receiver saw none of the packets"]);
    refused(&[&silent], &["--tx", "c", "--rx", "b"], &["found no frame on c"]);
    refused(
        &[&silent],
        &[&tx[..], &["--link", "sensor_to_controller"]].concat(),
        &["no frame is of the kind that --link carries"],
    );
    let table = written(&folder, "t.csv", "sequence,sent,received\n");
    refused(&[&silent, &table], &tx, &["t.csv: is of another format"]);
    let early = candump(20_000_000, "a", "#", &frame(1)) + &candump(10_000_000, "b", "#", &frame(1));
    refused(&[&written(&folder, "t.log", early)], &tx, &["clocks of the two ends are not synchronised"]);
}

/// How a capture is written.
#[derive(Clone, Copy)]
struct Capture {
    is_little: bool,
    nanoseconds: bool,
    link_type: u32,
}

impl Capture {
    fn number(self, number: u32) -> [u8; 4] {
        if self.is_little { number.to_le_bytes() } else { number.to_be_bytes() }
    }

    fn of(self, seen: &[(u64, u32)]) -> Vec<u8> {
        let magic = if self.nanoseconds { 0xa1b2_3c4d } else { 0xa1b2_c3d4 };
        let header = [magic, 0x0002_0004, 0, 0, 65535, self.link_type];
        let mut bytes = header.map(|number| self.number(number)).concat();
        let ethernet: &[u8] = &[&[0; 12][..], &[0x81, 0, 0, 7], &[8, 0]].concat();
        for (time, tick) in seen {
            // A measurement with the same tick is another packet.
            for payload in [frame(*tick), [&[1, 1, 4][..], &frame(*tick)[3..]].concat()] {
                let mut packet = if self.link_type == 1 { ethernet.to_vec() } else { Vec::new() };
                packet.extend(
                    [&[0x45, 0, 0, 36, 0, 0, 0x40, 0, 64, 17][..], &[0; 10], &[0; 8], &payload].concat(),
                );
                let below = time % 1_000_000_000 / if self.nanoseconds { 1 } else { 1000 };
                let length = packet.len() as u32;
                let record = [(time / 1_000_000_000) as u32, below as u32, length, length];
                bytes.extend(record.map(|number| self.number(number)).concat());
                bytes.extend(packet);
            }
        }
        bytes
    }
}

#[test]
fn captures_say_the_same_as_a_table() {
    let folder = folder();
    let times = decidable();
    let expected = figures(json(&[&written(&folder, "t.csv", csv(&times))], &[]));
    let [sent, received] = ends(&times);
    for (is_little, nanoseconds, link_type) in
        [(true, false, 1), (true, true, 101), (false, false, 101), (false, true, 1)]
    {
        let capture = Capture { is_little, nanoseconds, link_type };
        let sender = written(&folder, "sender.pcap", capture.of(&sent));
        let receiver = written(&folder, "receiver.pcap", capture.of(&received));
        assert_eq!(figures(json(&[&sender, &receiver], &[])), expected);
        refused(&[&sender], &[], &["found packets on 1 interface; give two captures"]);
    }
}

#[test]
fn captures_that_were_cut_are_read_and_others_refused() {
    let folder = folder();
    let capture = Capture { is_little: true, nanoseconds: false, link_type: 101 };
    let bytes = capture.of(&[(1_000_000_000, 1)]);
    let good = written(&folder, "good.pcap", &bytes);
    let cut = written(&folder, "cut.pcap", &bytes[..bytes.len() - 1]);
    let found = json(&[&good, &cut], &[]);
    assert_eq!((&found["packets"], &found["log"]["skipped"]["cut_off"]), (&1.into(), &1.into()), "{found}");
    let next = written(&folder, "next.pcap", [0x0a, 0x0d, 0x0d, 0x0a, 0, 0]);
    refused(&[&next, &good], &[], &["next.pcap: found no header of a capture"]);
    let other = written(&folder, "other.pcap", Capture { link_type: 147, ..capture }.of(&[]));
    refused(&[&other, &good], &[], &["other.pcap: found link type 147"]);
    let later = written(&folder, "later.pcap", capture.of(&[(1_100_000_000, 1)]));
    refused(&[&good, &later], &["--link", "acknowledgement"], &["no frame is of the kind"]);
}
