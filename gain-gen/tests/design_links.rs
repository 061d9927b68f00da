//! A link may be given by its delays, as a channel that comes and goes, or by a log of it.

use gain_gen::design::{Behaviour, Design, Link};
use std::fs;

const MOTOR: &str = include_str!("data/motor.toml");

fn with_link(link: &str) -> String {
    MOTOR.replace(
        "controller_to_actuator = { delays = [0.5, 0.25] }",
        &format!("controller_to_actuator = {link}"),
    )
}

fn link(link: &str) -> Link {
    Design::parse(&with_link(link), "motor.toml").unwrap().network.controller_to_actuator
}

#[test]
fn a_gilbert_elliott_channel_is_a_markov_channel_of_two_states() {
    let two =
        link("{ gilbert_elliott = { to_bad = 0.1, to_good = 0.3, good = [0.9, 0.1], bad = [0.0, 0.2] } }");
    let any =
        link("{ markov = { transitions = [[0.9, 0.1], [0.3, 0.7]], delays = [[0.9, 0.1], [0.0, 0.2]] } }");
    assert_eq!(two, any);
    let channel = two.channel().unwrap();
    assert_eq!(channel.states(), 2);
    assert!((channel.shares()[1] - 0.25).abs() < 1e-15);
    // Three cycles in four are good.
    let average = two.delays.probabilities();
    assert!((average[0] - 0.675).abs() < 1e-15 && (average[1] - 0.125).abs() < 1e-15, "{average:?}");
}

#[test]
fn a_state_without_delays_loses_all() {
    let link = link("{ gilbert_elliott = { to_bad = 0.1, to_good = 0.3, good = [1], bad = [] } }");
    assert!(link.channel().unwrap().delays(1).is_none());
    assert!((link.delays.loss() - 0.25).abs() < 1e-15);
}

#[test]
fn duplicates_go_with_any_link() {
    assert_eq!(link("{ delays = [0.5, 0.25], duplicates = 0.125 }").duplicates, 0.125);
    assert_eq!(link("{ delays = [0.5, 0.25] }").duplicates, 0.0);
}

#[test]
fn a_trace_is_looked_for_beside_the_design_and_gives_its_delays() {
    let folder = tempfile::tempdir().unwrap();
    // Cycles of 0.01 s: at once, one late, lost, at once.
    let log = "sequence,sent,received\n0,0.000,0.001\n1,0.010,0.025\n2,0.020,\n3,0.030,0.031\n";
    fs::write(folder.path().join("link.csv"), log).unwrap();
    let path = folder.path().join("motor.toml");
    for given in ["{ trace = \"link.csv\" }", "{ trace = { files = [\"link.csv\"], offset = 0.0 } }"] {
        let text = with_link(given).replace("sample_time = 0.1", "sample_time = 0.01");
        fs::write(&path, &text).unwrap();
        let link = Design::load(&path).unwrap().network.controller_to_actuator;
        assert_eq!((link.delays.probabilities(), link.delays.loss()), ([0.5, 0.25].as_slice(), 0.25));
        let Behaviour::Recorded(recording) = &link.behaviour else { panic!("{link:?}") };
        let fates: Vec<_> = (0..4).map(|cycle| recording.fate(cycle)).collect();
        assert_eq!(fates, [Some(0), Some(1), None, Some(0)]);
    }
}

#[test]
fn gains_take_packets_of_a_channel_as_independent() {
    let channel = "{ gilbert_elliott = { to_bad = 0.5, to_good = 0.5, good = [1], bad = [0, 0.5] } }";
    let average = "{ delays = [0.5, 0.25] }";
    let report = |given: &str| {
        let design = Design::parse(&with_link(given), "motor.toml").unwrap();
        gain_gen::report::Report::new(&design, gain_gen::solve::Method::InFlight).solution.law
    };
    assert_eq!(report(channel), report(average));
}
