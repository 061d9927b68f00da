//! A sweep's file is the same however it came about: interrupted, in shards, on any number of threads.

use assert_cmd::Command;
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process,
    thread::sleep,
    time::Duration,
};

fn designs() -> [PathBuf; 2] {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs");
    ["double_integrator.toml", "double_integrator_bad.toml"].map(|name| folder.join(name))
}

/// Two designs, three controllers, two lengths: 10 cases of 40 runs.
fn sweep(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.arg("sweep").args(designs()).args(["--lengths", "3,4", "--controllers", "slqg,slqg-udp,lqg"]);
    command.args(["--runs", "40", "--steps", "30"]).args(arguments);
    command
}

fn host_sim(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.args(arguments);
    command
}

fn stdout(mut command: Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).expect("UTF-8")
}

fn refused(mut command: Command) -> String {
    String::from_utf8(command.assert().code(2).get_output().stderr.clone()).expect("UTF-8")
}

fn into(path: &Path, arguments: &[&str]) -> Command {
    let mut command = sweep(arguments);
    command.arg("--output").arg(path);
    command
}

/// A folder with the file of the whole sweep in it, and its text.
fn whole() -> (tempfile::TempDir, PathBuf, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("whole.csv");
    into(&path, &[]).assert().success();
    let text = fs::read_to_string(&path).expect("the file");
    (folder, path, text)
}

#[test]
fn the_file_has_a_row_for_each_run_whatever_the_number_of_threads() {
    let (folder, _, text) = whole();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 2 + 10 * 40);
    assert!(lines[0].starts_with("# host-sim sweep {"), "{}", lines[0]);
    assert_eq!(
        lines[1],
        "design,controller,sequence_length,run,cost,total_cost,diverged,sent,age_sum,rejected,check"
    );
    assert!(lines[2].starts_with("double_integrator,slqg,3,0,"), "{}", lines[2]);
    assert!(lines[401].starts_with("double_integrator_bad,lqg,1,39,"), "{}", lines[401]);
    for threads in ["1", "3"] {
        let path = folder.path().join(threads);
        into(&path, &[]).env("RAYON_NUM_THREADS", threads).assert().success();
        assert!(fs::read_to_string(&path).expect("the file") == text, "{threads} threads");
    }
}

#[test]
fn a_sweep_that_ended_anywhere_is_continued_to_the_same_file() {
    let (folder, _, text) = whole();
    let head = text.lines().next().expect("a head").len();
    for length in [0, 10, head + 5, text.len() / 3, text.len() / 2 + 1, text.len() - 1, text.len()] {
        let path = folder.path().join(format!("{length}.csv"));
        let part = folder.path().join(format!("{length}.csv.part"));
        fs::write(&part, &text[..length]).expect("written");
        into(&path, &["--resume"]).assert().success();
        assert!(fs::read_to_string(&path).expect("the file") == text, "{length} bytes were there");
        assert!(!part.exists());
    }
}

#[test]
fn a_figure_that_was_changed_by_hand_is_noticed_in_every_column() {
    let (folder, whole, text) = whole();
    let path = folder.path().join("changed.csv");
    let part = folder.path().join("changed.csv.part");
    let row = text.lines().nth(5).expect("a row");
    let cells: Vec<_> = row.split(',').collect();
    for column in [4, 6, 7, 8, 9, 10] {
        let figure = match column {
            4 => "12345.5".to_owned(),
            10 => "17".to_owned(),
            _ => format!("{}1", cells[column]),
        };
        let mut changed = cells.clone();
        changed[column] = &figure;
        let changed = text.replacen(row, &changed.join(","), 1);
        fs::write(&part, &changed[..changed.len() / 2]).expect("written");
        let message = refused(into(&path, &["--resume"]));
        assert!(message.contains("line 6: the figures do not fit their check: changed"), "{message}");
        assert!(message.contains("delete from this line on"), "{message}");
        assert_eq!(fs::read_to_string(&part).expect("left alone"), changed[..changed.len() / 2]);
        // A finished file likewise.
        fs::write(&whole, &changed).expect("written");
        let mut summary = host_sim(&["summary"]);
        summary.arg(&whole);
        assert!(refused(summary).contains("line 6: the figures do not fit their check"));
    }
}

/// A sweep into `path` that takes a while, with its file begun.
fn long(path: &Path, part: &Path) -> process::Child {
    let mut command = process::Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.arg("sweep").args(designs()).args(["--lengths", "4", "--controllers", "slqg,slqg-udp"]);
    command.args(["--runs", "1000000", "--steps", "100", "--resume", "--output"]).arg(path);
    let mut running = command.stdout(process::Stdio::null()).spawn().expect("started");
    while fs::metadata(part).map_or(0, |metadata| metadata.len()) < 10_000 {
        assert!(running.try_wait().expect("a status").is_none(), "it has ended");
        sleep(Duration::from_millis(1));
    }
    running
}

#[test]
fn two_sweeps_into_one_file_lock_each_other_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shared.csv");
    let part = folder.path().join("shared.csv.part");
    let mut first = long(&path, &part);
    for arguments in [&["--resume"][..], &[]] {
        let message = refused(into(&path, arguments));
        assert!(message.contains("another sweep is writing it; wait until that has ended"), "{message}");
    }
    first.kill().expect("killed");
    first.wait().expect("ended");
    // The lock has ended with the process: now it is only another experiment.
    let message = refused(into(&path, &["--resume"]));
    assert!(message.contains("another experiment"), "{message}");
}

#[test]
#[cfg(target_os = "linux")]
fn an_output_that_is_no_regular_file_gets_the_rows_and_stays_what_it_is() {
    let (folder, _, text) = whole();
    let begins_with_rows = stdout(into(Path::new("/dev/stdout"), &["--resume"]));
    assert!(begins_with_rows.starts_with(&text), "then the table");
    into(Path::new("/dev/null"), &[]).assert().success();
    let full = refused(into(Path::new("/dev/full"), &[]));
    assert!(full.contains("/dev/full: cannot be written"), "{full}");
    for left in ["/dev/stdout.part", "/dev/null.part", "/dev/full.part"] {
        assert!(!Path::new(left).exists(), "{left}");
    }
    let pipe = folder.path().join("pipe");
    assert!(process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    let reader = {
        let pipe = pipe.clone();
        std::thread::spawn(move || fs::read_to_string(pipe).expect("rows"))
    };
    into(&pipe, &[]).assert().success();
    assert!(reader.join().expect("read") == text);
}

#[test]
fn a_killed_sweep_is_continued_to_the_same_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let [killed, through] = ["killed.csv", "through.csv"].map(|name| folder.path().join(name));
    let part = folder.path().join("killed.csv.part");
    let arguments = |path: &Path| {
        let mut command = process::Command::new(env!("CARGO_BIN_EXE_host-sim"));
        command.arg("sweep").args(designs()).args(["--lengths", "4", "--controllers", "slqg,slqg-udp"]);
        command.args(["--runs", "3000", "--steps", "100", "--resume", "--output"]).arg(path);
        command.stdout(process::Stdio::null());
        command
    };
    let mut running = arguments(&killed).spawn().expect("started");
    // Some rows must be there; how long that takes does not matter.
    let rows = || fs::metadata(&part).map_or(0, |metadata| metadata.len());
    while rows() < 20_000 && running.try_wait().expect("a status").is_none() {
        sleep(Duration::from_millis(1));
    }
    running.kill().expect("killed");
    running.wait().expect("ended");
    let left = fs::read_to_string(&part).expect("an interrupted sweep");
    assert!(!killed.exists());
    for path in [&killed, &through] {
        assert!(arguments(path).status().expect("started").success());
    }
    let text = fs::read_to_string(&through).expect("the file");
    assert!(left.len() < text.len() && text.starts_with(&left));
    assert!(fs::read_to_string(&killed).expect("the file") == text);
}

#[test]
fn shards_make_the_file_of_the_whole_sweep() {
    let (folder, _, text) = whole();
    let shard = |name: &str| folder.path().join(name.replace('/', "of"));
    for name in ["1/3", "2/3", "3/3", "1/2"] {
        into(&shard(name), &["--shard", name]).assert().success();
    }
    let merged = folder.path().join("merged.csv");
    let merge = |names: &[&str]| {
        let mut command = host_sim(&["merge"]);
        command.args(names.iter().map(|name| shard(name))).arg("--output").arg(&merged);
        command
    };
    let missing = refused(merge(&["1/3", "3/3"]));
    assert!(missing.contains("shards 2/3 are missing; give the files of all 3"), "{missing}");
    let twice = refused(merge(&["1/3", "2/3", "1/3", "3/3"]));
    assert!(twice.contains("both are shard 1/3"), "{twice}");
    let mixed = refused(merge(&["1/2", "2/3", "3/3"]));
    assert!(mixed.contains("not the same experiment: shards: 2 against 3"), "{mixed}");
    assert!(!merged.exists());
    merge(&["3/3", "1/3", "2/3"]).assert().success();
    assert!(fs::read_to_string(&merged).expect("the file") == text);
    let mut alone = host_sim(&["summary"]);
    alone.arg(shard("1/2"));
    let alone = refused(alone);
    assert!(alone.contains("shard 1/2 only; put all shards together"), "{alone}");
}

#[test]
fn a_file_of_another_experiment_is_refused_and_left_alone() {
    let (folder, _, text) = whole();
    let part = folder.path().join("other.csv.part");
    let path = folder.path().join("other.csv");
    fs::write(&part, &text[..text.len() / 2]).expect("written");
    let interrupted = refused(into(&path, &[]));
    assert!(interrupted.contains("an interrupted sweep; continue it with --resume"), "{interrupted}");
    for (arguments, difference) in [
        (["--resume", "--seed", "2"], "seed: 1 against 2"),
        (["--resume", "--acknowledgement", "none"], "design double_integrator: its file"),
        (["--resume", "--shard", "1/2"], "shard: 1/1 against 1/2"),
    ] {
        let message = refused(into(&path, &arguments));
        assert!(message.contains("another experiment") && message.contains(difference), "{message}");
    }
    assert_eq!(fs::read_to_string(&part).expect("the file"), text[..text.len() / 2]);
    // A finished file too; and a row in the wrong place.
    fs::remove_file(&part).expect("removed");
    fs::write(&path, &text).expect("written");
    assert!(refused(into(&path, &["--resume", "--seed", "2"])).contains("seed: 1 against 2"));
    fs::write(&path, text.replacen("slqg,3,5,", "slqg,3,7,", 1)).expect("written");
    let message = refused(into(&path, &["--resume"]));
    assert!(message.contains("line 8: expected double_integrator, slqg, N = 3, run 5"), "{message}");
}

#[test]
fn the_summary_of_the_file_is_what_the_sweep_printed() {
    let (_folder, path, text) = whole();
    let summary = |arguments: &[&str]| {
        let mut command = host_sim(&["summary"]);
        command.arg(&path).args(arguments);
        stdout(command)
    };
    assert_eq!(summary(&[]), stdout(sweep(&[])));
    assert_eq!(summary(&["--json", "--baseline", "lqg"]), stdout(sweep(&["--json", "--baseline", "lqg"])));
    let json: Value = serde_json::from_str(&summary(&["--json"])).expect("one JSON object");
    assert_eq!(
        (&json["name"], &json["baseline"]),
        (&"double_integrator, double_integrator_bad".into(), &"slqg".into())
    );
    let results = json["results"].as_array().expect("results");
    // The difference is that of the rows.
    let costs = |controller: &str| -> Vec<f64> {
        let begin = format!("double_integrator,{controller},3,");
        let rows = text.lines().filter(|line| line.starts_with(&begin));
        rows.map(|line| line.split(',').nth(4).expect("a cost").parse().expect("a number")).collect()
    };
    let (base, udp) = (costs("slqg"), costs("slqg-udp"));
    assert_eq!((base.len(), udp.len()), (40, 40));
    let mean = udp.iter().zip(&base).map(|(udp, base)| udp - base).sum::<f64>() / 40.0;
    let case = results
        .iter()
        .find(|case| {
            case["design"] == "double_integrator"
                && case["controller"] == "slqg-udp"
                && case["sequence_length"] == 3
        })
        .expect("a case");
    let difference = &case["difference"];
    assert!((difference["mean"].as_f64().expect("a number") - mean).abs() < 1e-9, "{difference}");
    // What both have in common has dropped out; on the good network that is much.
    let paired = difference["std_error"].as_f64().expect("a number");
    let alone = case["std_error"].as_f64().expect("a number");
    assert!(paired < alone, "{paired} {alone}");
    let wrong = refused({
        let mut command = host_sim(&["summary", "--baseline", "slqg-task"]);
        command.arg(&path);
        command
    });
    assert!(wrong.contains("--baseline slqg-task") && wrong.contains("slqg, slqg-udp, lqg"), "{wrong}");
}

#[test]
fn a_run_of_a_sweep_is_that_of_the_same_number_in_a_simulation_of_its_design() {
    let (_folder, path, _) = whole();
    let mut summary = host_sim(&["summary", "--json"]);
    summary.arg(&path);
    let sweep: Value = serde_json::from_str(&stdout(summary)).expect("one JSON object");
    let mut run = host_sim(&["run", "--runs", "40", "--steps", "30", "--sequence-length", "3", "--json"]);
    run.arg(&designs()[1]);
    let run: Value = serde_json::from_str(&stdout(run)).expect("one JSON object");
    let found = sweep["results"].as_array().expect("results").iter().find(|case| {
        case["design"] == "double_integrator_bad"
            && case["controller"] == "slqg"
            && case["sequence_length"] == 3
    });
    let found = found.expect("a case");
    for key in
        ["mean_cost", "std_error", "median_cost", "p95_cost", "diverged", "send_rate", "mean_input_age"]
    {
        assert_eq!(found[key], run["results"][0][key], "{key}");
    }
}
