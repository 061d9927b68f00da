//! `host-sim identify` gives back the link that a table was drawn from, and says when it cannot.

mod links;

use gain_gen::design::Design;
use links::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::{fmt::Write, fs, path::Path};

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
    let text = stdout(&[&path], &[]);
    assert!(text.contains("# warning: losses are not independent"));
    // The channel is a link of a design file.
    let line =
        text.lines().find_map(|line| line.strip_prefix("# controller_to_actuator = { gilbert_elliott"));
    let channel = format!("controller_to_actuator = {{ gilbert_elliott{}", line.expect("a channel"));
    let text = fs::read_to_string(design("double_integrator_bad.toml")).expect("the design");
    let (before, rest) = text.split_once("[network]\n").expect("the network");
    let (_, after) = rest.split_once("\n[").expect("a section after it");
    let text = format!("{before}[network]\n{channel}\nsensor_to_controller = {{ delays = [1] }}\n[{after}");
    Design::parse(&text, "with a channel").unwrap_or_else(|error| panic!("{error}\n{text}"));
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
    let read = network.controller_to_actuator.delays.probabilities();
    assert!(
        read.len() == delays.len()
            && read.iter().zip(&delays).all(|(read, given)| (read - given).abs() < 1e-15)
    );
    assert_eq!(network.sensor_to_controller, network.controller_to_actuator);
    assert!(
        (network.controller_to_actuator.delays.loss() - found["loss"]["probability"].as_f64().expect("loss"))
            .abs()
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
        &["wrong.csv:1: found the columns \"seq,t0,t1\"; give a header with sequence,sent,received"],
    );
    let path = written(&folder, "lost.csv", format!("{header}1,0.01,\n2,0.02,lost\n"));
    refused(&[&path], &[], &["none of 2 packets arrives"]);
    let path = written(&folder, "restart.csv", format!("{header}1,0.01,0.02\n900,0.02,0.03\n"));
    refused(&[&path], &[], &["did the sender restart?"]);
    refused(&[&folder.path().join("none.csv")], &[], &["none.csv: cannot read it"]);
    refused(&[&path], &["--offset", "0.02"], &["--offset"]);
}
