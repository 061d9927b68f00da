//! The nodes as processes on this machine: they find each other by their clocks, survive each other, and say what is wrong.
//!
//! Nothing is asserted about time: only that frames get through and the state stays bounded, with a plant that many missed
//! cycles cannot drive away.

use assert_cmd::cargo::CommandCargoExt;
use serde_json::Value;
use std::{
    fs,
    net::UdpSocket,
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    thread,
    time::Duration,
};
use tempfile::TempDir;

/// A mass with friction at 200 Hz: with any input held for seconds it does not get far.
fn design(folder: &TempDir) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs/double_integrator.toml");
    let text = fs::read_to_string(path).expect("a design");
    let text = text
        .replace("sample_time = 1.0", "sample_time = 0.005")
        .replace("a = [[1, 1], [0, 1]], b = [[0], [1]]", "a = [[1, 0.1], [0, 0.9]], b = [[0], [0.1]]")
        .replace("initial_mean = [100, 0]", "initial_mean = [5, 0]");
    assert!(text.contains("0.9") && text.contains("0.005") && text.contains("[5, 0]"), "{text}");
    let path = folder.path().join("integrator.toml");
    fs::write(&path, text).expect("written");
    path
}

/// Addresses of this machine that nobody has bound; all different.
fn free_addresses<const COUNT: usize>() -> [String; COUNT] {
    let sockets = [(); COUNT].map(|()| UdpSocket::bind("127.0.0.1:0").expect("a free port"));
    sockets.map(|socket| socket.local_addr().expect("bound").to_string())
}

/// A process that does not outlive its test.
struct Node(Option<Child>);

impl Node {
    fn start(role: &str, design: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::cargo_bin("host-sim").expect("built");
        command.args(["node", role]).arg(design).args(arguments).arg("--json");
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("started");
        Self(Some(child))
    }

    /// Ends it in order, and takes what it says.
    fn terminated(self) -> Value {
        let child = self.0.as_ref().expect("runs");
        let kill = Command::new("kill").arg(child.id().to_string()).status().expect("kill");
        assert!(kill.success());
        self.ended()
    }

    /// What it says at its end.
    fn ended(mut self) -> Value {
        let output = self.0.take().expect("runs").wait_with_output().expect("waited");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        serde_json::from_slice(&output.stdout).expect("one JSON object")
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn number(statistics: &Value, section: &str, key: &str) -> f64 {
    statistics[section][key].as_f64().unwrap_or_else(|| panic!("{section}.{key} in {statistics}"))
}

/// A plant that was controlled and never got far; it begins at 5 m.
fn assert_controlled(plant: &Value, cycles: f64) {
    assert_eq!(plant["plant"]["diverged"], false);
    // Cycles that were slept through may be one too many.
    assert!(number(plant, "plant", "cycles") >= cycles, "{plant}");
    assert!(number(plant, "applied_inputs", "received") > 0.0, "{plant}");
    assert!(number(plant, "plant", "largest_state") < 1000.0, "{plant}");
}

#[test]
fn a_loop_of_processes_controls_the_plant_over_relays() {
    let folder = tempfile::tempdir().expect("a folder");
    let design = design(&folder);
    let [plant, controller, actuator, first, second] = free_addresses();
    let relay = |bind: &str, to: &str, link| {
        let arguments = ["--udp", bind, "--to", to, "--link", link, "--duplicate", "0.1"];
        Node::start("relay", &design, &arguments)
    };
    let relays = [
        relay(&first, &controller, "sensor_to_controller"),
        relay(&second, &actuator, "controller_to_actuator"),
    ];
    let arguments = ["--udp", &controller, "--actuator", &second];
    let controlling = Node::start("controller", &design, &arguments);
    let arguments = ["--udp", &actuator, "--controller", &controller, "--plant", &plant];
    let acting = Node::start("actuator", &design, &arguments);
    let arguments = ["--udp", &plant, "--controller", &first, "--actuator", &actuator, "--cycles", "200"];
    let statistics = Node::start("plant", &design, &arguments).ended();
    assert_controlled(&statistics, 200.0);
    let controlling = controlling.terminated();
    for kind in ["measurements", "acknowledgements"] {
        assert!(number(&controlling, kind, "received") > 0.0, "{controlling}");
    }
    assert!(number(&controlling, "controller", "sent") > 0.0, "{controlling}");
    assert!(number(&acting.terminated(), "control_frames", "received") > 0.0);
    for relay in relays {
        let relay = relay.terminated();
        assert!(number(&relay, "relay", "forwarded") > 0.0, "{relay}");
        assert_eq!(number(&relay, "packets", "of_strangers"), 0.0, "{relay}");
    }
}

#[test]
fn a_controller_and_an_actuator_that_are_killed_and_started_again_join_the_loop() {
    let folder = tempfile::tempdir().expect("a folder");
    let design = design(&folder);
    let [plant, controller, actuator] = free_addresses();
    let controlling = || {
        let scale = ["--initial-covariance-scale", "2"];
        let arguments = ["--udp", &controller, "--actuator", &actuator];
        Node::start("controller", &design, &[&arguments[..], &scale].concat())
    };
    let acting = || {
        let arguments = ["--udp", &actuator, "--controller", &controller, "--plant", &plant];
        Node::start("actuator", &design, &arguments)
    };
    let arguments =
        ["--udp", &plant, "--controller", &controller, "--actuator", &actuator, "--cycles", "300"];
    let running = Node::start("plant", &design, &arguments);
    let first = (controlling(), acting());
    thread::sleep(Duration::from_millis(500));
    drop(first.0);
    let _controller = controlling();
    thread::sleep(Duration::from_millis(300));
    drop(first.1);
    let _actuator = acting();
    assert_controlled(&running.ended(), 300.0);
}

/// Status 2, and what is said.
fn refused(arguments: &[&str]) -> String {
    let mut command = Command::cargo_bin("host-sim").expect("built");
    let Output { status, stderr, stdout } = command.arg("node").args(arguments).output().expect("ran");
    let said = String::from_utf8_lossy(&stderr).into_owned();
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(stdout.is_empty());
    said
}

#[test]
fn wrong_options_exit_with_2_and_say_what_to_give() {
    let folder = tempfile::tempdir().expect("a folder");
    let design = design(&folder);
    let design = design.to_str().expect("UTF-8");
    let controller = ["controller", design, "--udp", "127.0.0.1:0"];
    let actuator = ["--actuator", "127.0.0.1:9"];
    let relay = ["relay", design, "--udp", "127.0.0.1:0", "--to", "127.0.0.1:9"];
    let cases: [(&[&[&str]], &str); 12] = [
        (&[&controller, &["--actuator", "127.0.0.1"]], "give a host and a port"),
        (&[&controller, &["--actuator", "127.0.0.1:0"]], "port 0 is nobody's"),
        (&[&controller, &["--actuator", "0.0.0.0:9"]], "give the other node's host"),
        (&[&controller], "--actuator"),
        (&[&controller, &actuator, &["--controller-at", "0.7"]], "the controller must act first"),
        (&[&controller, &actuator, &["--controller-at", "1.5"]], "between 0 and 1"),
        (&[&controller, &actuator, &["--initial-covariance-scale", "0"]], "within 1 and"),
        (&[&["controller", design, "--udp", "127.0.0.1:0", "--actuator", "[::1]:9"]], "all IPv4 or all IPv6"),
        (&[&relay, &["--delay-ms", "20..3"]], "the smaller first"),
        (&[&relay, &["--loss", "1.5"]], "a probability"),
        (&[&relay, &["--loss", "0.1", "--link", "acknowledgement"]], "cannot be used with"),
        (&[&["controller", design, "--can", "nosuchcan0", "--identifiers", "1,2,2"]], "three different"),
    ];
    for (arguments, expected) in cases {
        let said = refused(&arguments.concat());
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}

#[test]
fn an_address_in_use_exits_with_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let design = design(&folder);
    let taken = UdpSocket::bind("127.0.0.1:0").expect("a free port");
    let bind = taken.local_addr().expect("bound").to_string();
    let design = design.to_str().expect("UTF-8");
    let said = refused(&["controller", design, "--udp", &bind, "--actuator", "127.0.0.1:9"]);
    assert!(said.contains(&bind) && said.contains("in use"), "{said}");
}

#[test]
fn a_trajectory_exits_with_2() {
    let design = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs/pendulum_tracking.toml");
    let design = design.to_str().expect("UTF-8");
    let said = refused(&["controller", design, "--udp", "127.0.0.1:0", "--actuator", "127.0.0.1:9"]);
    assert!(said.contains("pendulum_tracking.toml") && said.contains("trajectory"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_design_that_asks_for_sealed_frames_is_not_run_with_plain_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = design(&folder);
    let text = std::fs::read_to_string(&path).expect("readable");
    std::fs::write(&path, text + "\n[wire]\nauthentication = \"cmac\"\nformat = \"bytes\"\n")
        .expect("writable");
    let design = path.to_str().expect("UTF-8");
    let said = refused(&["controller", design, "--udp", "127.0.0.1:0", "--actuator", "127.0.0.1:9"]);
    assert!(said.contains("wire.authentication"), "{said}");
}

#[test]
fn a_missing_can_interface_exits_with_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let design = design(&folder);
    let said = refused(&["controller", design.to_str().expect("UTF-8"), "--can", "nosuchcan0"]);
    assert!(said.contains("--can nosuchcan0"), "{said}");
}
