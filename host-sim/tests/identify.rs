//! `host-sim identify` gives back the link that a log was drawn from, and says when it cannot.

use assert_cmd::Command;
use gain_gen::design::{DelayDistribution, Design};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};
use tempfile::TempDir;

fn design(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name)
}

fn network(name: &str) -> DelayDistribution {
    Design::load(&design(name)).expect("a design").network.controller_to_actuator
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn written(folder: &TempDir, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, content).expect("written");
    path
}

fn identify(files: &[&Path], arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.arg("identify").args(files).args(["--sample-time", "0.01"]).args(arguments);
    command
}

fn stdout(files: &[&Path], arguments: &[&str]) -> String {
    let mut command = identify(files, arguments);
    String::from_utf8(command.assert().success().get_output().stdout.clone()).expect("UTF-8")
}

fn json(files: &[&Path], arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(files, &[arguments, &["--json"]].concat())).expect("one JSON object")
}

/// Fails with status 2 and says `expected`.
fn refused(files: &[&Path], arguments: &[&str], expected: &[&str]) {
    let mut command = identify(files, arguments);
    let message = String::from_utf8(command.assert().code(2).get_output().stderr.clone()).expect("UTF-8");
    for part in expected {
        assert!(message.contains(part), "{part} in {message}");
    }
}

/// A fate per packet: the delay in cycles or lost.
fn drawn(distribution: &DelayDistribution, packets: usize, random: &mut ChaCha8Rng) -> Vec<Option<usize>> {
    let draw = |_| {
        let mut left: f64 = random.random();
        distribution.probabilities().iter().position(|probability| {
            left -= probability;
            left < 0.0
        })
    };
    (0..packets).map(draw).collect()
}

/// Nanoseconds of sending and arrival: a packet per cycle of 10 ms, anywhere in the cycle it arrives in.
fn times(fates: &[Option<usize>], random: &mut ChaCha8Rng) -> Vec<(u64, Option<u64>)> {
    let cycle = 10_000_000;
    let mut time = |(index, fate): (usize, &Option<usize>)| {
        let sent = 1_000_000_000 + index as u64 * cycle;
        (sent, fate.map(|delay| sent + delay as u64 * cycle + random.random_range(0..cycle)))
    };
    fates.iter().enumerate().map(&mut time).collect()
}

fn decimal(time: u64) -> String {
    format!("{}.{:09}", time / 1_000_000_000, time % 1_000_000_000)
}

fn csv(times: &[(u64, Option<u64>)]) -> String {
    let mut text = String::from("sequence,sent,received\n");
    for (sequence, (sent, received)) in times.iter().enumerate() {
        let received = received.map(decimal).unwrap_or_default();
        writeln!(text, "{sequence},{},{received}", decimal(*sent)).expect("a string");
    }
    text
}

fn trace(fates: &[Option<usize>], random: &mut ChaCha8Rng) -> String {
    csv(&times(fates, random))
}

fn warns(json: &Value, of: &str) -> bool {
    json["warnings"]
        .as_array()
        .expect("a list")
        .iter()
        .any(|warning| warning.as_str().is_some_and(|text| text.contains(of)))
}

#[test]
fn networks_are_given_back_within_their_intervals() {
    let folder = folder();
    let packets = 100_000;
    let (mut intervals, mut held, mut tests, mut fired) = (0, 0, 0, 0);
    for (name, seeds) in [("double_integrator.toml", 1..=4), ("double_integrator_bad.toml", 5..=8)] {
        let network = network(name);
        for seed in seeds {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let fates = drawn(&network, packets, &mut random);
            let found = json(&[&written(&folder, "trace.csv", trace(&fates, &mut random))], &[]);
            assert_eq!(found["packets"], packets);
            let delays = found["delays"].as_array().expect("delays");
            assert_eq!(delays.len(), network.probabilities().len());
            let shares = delays.iter().zip(network.probabilities().iter().copied());
            for (share, truth) in shares.chain([(&found["loss"], network.loss())]) {
                let figure = |key: &str| share[key].as_f64().expect("a number");
                let error = (truth * (1.0 - truth) / packets as f64).sqrt();
                assert!((figure("probability") - truth).abs() <= 4.0 * error + 1e-12, "{truth}: {share}");
                intervals += 1;
                held += u32::from(figure("low") <= truth && truth <= figure("high"));
            }
            for test in ["independence_of_losses", "correlation_of_delays", "drift"] {
                if let Some(p_value) = found[test]["p_value"].as_f64() {
                    tests += 1;
                    fired += u32::from(p_value < 0.05);
                }
            }
            for wrong in ["not independent", "link changed"] {
                assert!(!warns(&found, wrong), "{name}, seed {seed}: {}", found["warnings"]);
            }
        }
    }
    assert!(f64::from(held) >= 0.9 * f64::from(intervals), "{held} of {intervals} intervals hold the truth");
    assert!(tests >= 20 && fired <= 4, "{fired} of {tests} tests below 5 %");
}

#[test]
fn losses_in_bursts_are_warned_of() {
    // Gilbert and Elliott: nothing is lost while the link is good, half while it is bad.
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut is_bad = false;
    let fates: Vec<Option<usize>> = (0..20_000)
        .map(|_| {
            is_bad = random.random_bool(if is_bad { 0.8 } else { 0.02 });
            (!(is_bad && random.random_bool(0.5))).then_some(0)
        })
        .collect();
    let folder = folder();
    let path = written(&folder, "bursts.csv", trace(&fates, &mut random));
    let found = json(&[&path], &[]);
    assert!(
        warns(&found, "losses are not independent") && warns(&found, "come in bursts"),
        "{}",
        found["warnings"]
    );
    assert!(found["bursts"]["mean"].as_f64() > found["bursts"]["mean_if_independent"].as_f64());
    assert!(stdout(&[&path], &[]).contains("# warning: losses are not independent"));
}

#[test]
fn few_losses_side_by_side_are_found_by_permutation() {
    let mut fates = vec![Some(0); 2000];
    (1000..1005).for_each(|index| fates[index] = None);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let folder = folder();
    let found = json(&[&written(&folder, "t.csv", trace(&fates, &mut random))], &[]);
    assert_eq!(found["independence_of_losses"]["method"], "permutation");
    assert!(warns(&found, "come in bursts") && found["bursts"]["longest"] == 5, "{found}");

    (1000..1005).for_each(|index| fates[index] = Some(0));
    (0..5).for_each(|index| fates[100 + 300 * index] = None);
    let found = json(&[&written(&folder, "t.csv", trace(&fates, &mut random))], &[]);
    assert!(!warns(&found, "not independent"), "{found}");
}

#[test]
fn delays_that_follow_each_other_and_a_link_that_changes_are_warned_of() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut delay = 0;
    let mut queue = |_| {
        if random.random_bool(0.3) {
            delay = random.random_range(0..4);
        }
        Some(delay)
    };
    let fates: Vec<Option<usize>> = (0..5000).map(&mut queue).collect();
    let folder = folder();
    let found = json(&[&written(&folder, "queue.csv", trace(&fates, &mut random))], &[]);
    assert!(warns(&found, "delays are not independent"), "{found}");

    let fates: Vec<Option<usize>> = (0..5000)
        .map(|index| Some(usize::from(random.random_bool(if index < 2500 { 0.1 } else { 0.2 }))))
        .collect();
    let found = json(&[&written(&folder, "drift.csv", trace(&fates, &mut random))], &[]);
    assert!(warns(&found, "the link changed"), "{found}");
}

#[test]
fn the_fragment_goes_into_a_design_file() {
    let network = network("double_integrator_bad.toml");
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let fates = drawn(&network, 3000, &mut random);
    let folder = folder();
    let path = written(&folder, "trace.csv", trace(&fates, &mut random));
    let links = ["controller_to_actuator", "sensor_to_controller", "acknowledgement"];
    let fragments: String = links.iter().map(|link| stdout(&[&path], &["--link", link])).collect();

    let text = fs::read_to_string(design("double_integrator_bad.toml")).expect("the design");
    let (before, rest) = text.split_once("[network]\n").expect("the network");
    let (_, after) = rest.split_once("\n[").expect("a section after it");
    let text = format!("{before}[network]\n{fragments}\n[{after}");
    let network = Design::parse(&text, "identified").expect("a design").network;
    let found = json(&[&path], &[]);
    let delays = found["delays"].as_array().expect("delays");
    let delays: Vec<f64> =
        delays.iter().map(|share| share["probability"].as_f64().expect("a number")).collect();
    let read = network.controller_to_actuator.probabilities();
    assert!(
        read.len() == delays.len()
            && read.iter().zip(&delays).all(|(read, given)| (read - given).abs() < 1e-15)
    );
    assert_eq!(network.sensor_to_controller, network.controller_to_actuator);
    assert!(
        (network.controller_to_actuator.loss() - found["loss"]["probability"].as_f64().expect("loss")).abs()
            < 1e-12
    );
}

#[test]
fn a_small_table_reads_as_documented() {
    let folder = folder();
    let mut text = String::from("sequence, sent, received, node\n# a comment\n");
    for index in 0..40_u32 {
        let received = match index % 10 {
            3 => "lost".to_string(),
            7 => format!("0.{:02}5", index + 2),
            _ => format!("0.{index:02}4"),
        };
        writeln!(text, "{index}, 0.{index:02}, {received}, a").expect("a string");
    }
    written(&folder, "small.csv", &text);
    let mut command = identify(&[Path::new("small.csv")], &[]);
    let output = command.current_dir(folder.path()).assert().success().get_output().stdout.clone();
    let expected = include_str!("identify_small.toml");
    assert_eq!(String::from_utf8(output).expect("UTF-8"), expected);
}

#[test]
fn tables_of_one_link_are_pooled_and_files_are_no_neighbours() {
    let folder = folder();
    let first = written(&folder, "1.csv", "sequence,sent,received\n1,0.01,0.011\n2,0.02,\n");
    let second = written(&folder, "2.csv", "received,sequence,sent\n,1,0.01\n0.033,2,0.02\n");
    let found = json(&[&first, &second], &[]);
    assert_eq!(
        (&found["packets"], &found["loss"]["packets"], &found["bursts"]["longest"]),
        (&4.into(), &2.into(), &1.into())
    );
    assert_eq!(found["delays"][1]["packets"], 1);
}

#[test]
fn gaps_duplicates_order_and_the_longest_delay_count_as_documented() {
    let folder = folder();
    // 3 and 4 are missing, 6 came twice, 1 after 2 and 5, 9 too late.
    let text = "sequence,sent,received\n1,0.01,0.055\n2,0.02,0.021\n5,0.05,0.051\n6,0.06,0.069\n6,0.06,0.061\n9,0.09,0.29\n";
    let path = written(&folder, "t.csv", text);
    let found = json(&[&path], &["--longest", "10", "--gaps", "lost"]);
    let log = &found["log"];
    assert_eq!((&log["missing"], &log["duplicates"], &log["reordered"]), (&4.into(), &1.into(), &1.into()));
    assert_eq!(
        (&found["packets"], &log["late"], &found["loss"]["packets"]),
        (&9.into(), &1.into(), &5.into())
    );
    assert_eq!(found, json(&[&path], &["--longest", "10"]), "without lost rows, gaps are losses");
    let found = json(&[&path], &["--gaps", "ignore"]);
    assert_eq!((&found["packets"], &found["loss"]["packets"]), (&5.into(), &0.into()));
    assert!(
        warns(&found, "numbers missing in the sequence, not counted: 4")
            && warns(&found, "the first arrival counts: 1"),
        "{found}"
    );
    // Sent 9.5 ms into its cycle, what takes 1 ms comes in the next.
    assert_eq!(json(&[&path], &["--offset", "0.0095"])["delays"][0]["packets"], 0);
}

#[test]
fn malformed_tables_are_reported_with_file_and_line() {
    let folder = folder();
    let header = "sequence,sent,received\n";
    for (rows, expected) in [
        ("1,0.01,0.02\n2,abc,0.03\n", ":3: sent: found \"abc\"; give seconds in decimal"),
        ("1,0.01,0.02\n\n# a comment\n2,0.02,soon\n", ":5: received: found \"soon\""),
        ("1,0.01,0.02\r\n\r\n2,0.02\r\n", ":4: found 2 cells"),
        ("1.5,0.01,0.02\n", ":2: sequence: found \"1.5\"; give a whole number"),
        ("1,0.01,0.02\n2,0.02\n", ":3: found 2 cells; give 3"),
        (
            "1,0.02,0.01\n",
            ":2: packet 1 arrives 1e-2 s before it is sent: the clocks of the two ends are not synchronised",
        ),
        ("", ": found no packet"),
    ] {
        refused(&[&written(&folder, "wrong.csv", format!("{header}{rows}"))], &[], &["wrong.csv", expected]);
    }
    let path = written(&folder, "wrong.csv", "seq;t0;t1\n1;2;3\n");
    refused(
        &[&path],
        &[],
        &["wrong.csv:1: found the columns \"seq;t0;t1\"; give a header with sequence,sent,received"],
    );
    let path = written(&folder, "lost.csv", format!("{header}1,0.01,\n2,0.02,lost\n"));
    refused(&[&path], &[], &["none of 2 packets arrives"]);
    let path = written(&folder, "restart.csv", format!("{header}1,0.01,0.02\n900,0.02,0.03\n"));
    refused(&[&path], &[], &["did the sender restart?"]);
    refused(&[&folder.path().join("none.csv")], &[], &["none.csv: cannot read it"]);
    refused(&[&path], &["--offset", "0.02"], &["--offset"]);
}

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
    json["files"] = Value::Null;
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
    refused(&[&short], &[&tx[..], &["--id", "123"]].concat(), &["t.log:2: found a frame of 1 bytes"]);
    let silent = written(&folder, "t.log", &good);
    refused(&[&silent], &tx, &["the receiver saw none of the packets"]);
    refused(&[&silent], &["--tx", "c", "--rx", "b"], &["found no frame on c"]);
    refused(
        &[&silent],
        &[&tx[..], &["--link", "sensor_to_controller"]].concat(),
        &["of the kind that --link carries"],
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
        refused(&[&sender], &[], &["found 1 captures; give two"]);
    }
}

#[test]
fn captures_that_cannot_be_read_are_refused() {
    let folder = folder();
    let capture = Capture { is_little: true, nanoseconds: false, link_type: 101 };
    let bytes = capture.of(&[(1_000_000_000, 1)]);
    let good = written(&folder, "good.pcap", &bytes);
    let cut = written(&folder, "cut.pcap", &bytes[..bytes.len() - 1]);
    refused(&[&good, &cut], &[], &["cut.pcap: byte 76: found part of a packet"]);
    let next = written(&folder, "next.pcap", [0x0a, 0x0d, 0x0d, 0x0a, 0, 0]);
    refused(&[&next, &good], &[], &["next.pcap: found pcapng; convert it"]);
    let other = written(&folder, "other.pcap", Capture { link_type: 147, ..capture }.of(&[]));
    refused(&[&other, &good], &[], &["other.pcap: found link type 147"]);
    refused(&[&good, &good], &["--link", "acknowledgement"], &["good.pcap: found no frame of the kind"]);
}
