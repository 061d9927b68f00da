//! The report is one file that tells everything, with pictures that can be read and taken out of it.

use assert_cmd::Command;
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// A run or a sweep with its report and its pictures.
struct Made {
    html: String,
    plots: BTreeMap<String, String>,
    json: Value,
}

fn make(command: &str, design: &str, arguments: &[&str]) -> Made {
    let folder = tempfile::tempdir().expect("a folder");
    let (report, plots) = (folder.path().join("report.html"), folder.path().join("pictures"));
    let design = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs").join(design);
    let mut host_sim = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    host_sim.arg(command).arg(design).args(["--runs", "20", "--json"]).args(arguments);
    if !arguments.contains(&"--steps") {
        host_sim.args(["--steps", "80"]);
    }
    host_sim.arg("--report").arg(&report).arg("--plots").arg(&plots);
    let output = host_sim.assert().success().get_output().stdout.clone();
    Made {
        html: fs::read_to_string(&report).expect("the report"),
        plots: files(&plots),
        json: serde_json::from_slice(&output).expect("one JSON object"),
    }
}

fn files(folder: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path());
    let read = |path: PathBuf| {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        (name, fs::read_to_string(&path).expect("a picture"))
    };
    entries.map(read).collect()
}

/// Every picture of the page.
fn pictures(html: &str) -> Vec<&str> {
    let from_start = html.split("<svg").skip(1);
    from_start.map(|rest| &rest[..rest.find("</svg>").expect("an end")]).collect()
}

/// Texts of a row's cells.
fn cells(row: &str) -> Vec<&str> {
    row.split("<td>").skip(1).map(|cell| &cell[..cell.find('<').expect("an end")]).collect()
}

/// Checks that tags are closed in the order they were opened, and that attributes are quoted.
fn is_well_formed(svg: &str) -> bool {
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        if rest[..start].contains('>') {
            return false;
        }
        let Some(length) = rest[start..].find('>') else { return false };
        let tag = &rest[start + 1..start + length];
        rest = &rest[start + length + 1..];
        if tag.matches('"').count() % 2 == 1 || tag.contains('<') {
            return false;
        }
        match tag.strip_prefix('/') {
            Some(name) if open.pop() == Some(name.trim()) => (),
            Some(_) => return false,
            None if tag.ends_with('/') => (),
            None => open.push(tag.split_whitespace().next().unwrap_or_default()),
        }
    }
    open.is_empty()
}

#[test]
fn the_report_loads_nothing_and_runs_nothing() {
    let made = make("run", "drive_event.toml", &[]);
    for foreign in ["http:", "https:", "<script", "@import", "url(", "src=", "href=", "<link"] {
        assert!(!made.html.contains(foreign), "{foreign}");
    }
    assert!(made.html.contains("prefers-color-scheme: dark") && made.html.contains("@media print"));
}

#[test]
fn a_run_is_told_in_all_its_parts_in_order() {
    let made = make("run", "drive_event.toml", &["--controllers", "slqg,slqg-always,lqg"]);
    let parts = [
        "What was designed",
        "Sample time",
        "Default input",
        "Acknowledgement",
        "wire format bytes",
        "delay d in steps",
        "Theorem 3.4 b)",
        "All figures of the design",
        "<h2>Results",
        "<h2>The first run",
        "Tracked outputs",
        "States and estimates",
        "Inputs",
        "<h2>Packets of the first run",
        "<h2>All runs",
        "cost of a run",
        "age of the applied input in steps",
        "control frames sent, in % of the cycles",
        "<h2>How this was made",
        "--controllers slqg,slqg-always,lqg",
    ];
    let mut rest = made.html.as_str();
    for part in parts {
        let at = rest.find(part).unwrap_or_else(|| panic!("{part} is missing, or before what it follows"));
        rest = &rest[at..];
    }
    assert!(!made.html.contains("--report"), "where it was written is no part of it");
}

#[test]
fn a_sweep_is_told_by_length() {
    let made = make("sweep", "double_integrator_bad.toml", &["--lengths", "2,3,4"]);
    for part in
        ["Cost against sequence length", "inputs per sequence, N", "mean cost", "<h2>How this was made"]
    {
        assert!(made.html.contains(part), "{part}");
    }
    assert!(!made.html.contains("The first run"), "there are several first runs");
    assert!(made.plots.contains_key("cost-against-length.svg"));
}

#[test]
fn figures_are_those_of_the_json() {
    let made = make("run", "pendulum_bad.toml", &["--controllers", "slqg,slqg-udp,lqg"]);
    let results = made.json["results"].as_array().expect("results");
    let (_, table) = made.html.split_once("<h2>Results").expect("results");
    let (table, _) = table.split_once("</table>").expect("a table");
    // The first part is before the table, the second its head.
    let rows: Vec<Vec<&str>> = table.split("<tr>").skip(2).map(cells).collect();
    assert_eq!(rows.len(), results.len());
    for (row, result) in rows.iter().zip(results) {
        assert_eq!(row[0], result["controller"].as_str().expect("a name"));
        for (cell, key) in row[2..6].iter().zip(["mean_cost", "std_error", "median_cost", "p95_cost"]) {
            let (shown, exact) =
                (cell.parse::<f64>().expect("a number"), result[key].as_f64().expect("a number"));
            assert!((shown - exact).abs() <= 1e-4 * exact.abs(), "{key}: {shown} for {exact}");
        }
        assert_eq!(row[6], result["diverged"].to_string());
        assert_eq!(row[8], format!("{:.2}", result["mean_input_age"].as_f64().expect("a number")));
    }
    let (_, json) = made.html.split_once("Results as JSON</summary>\n<pre>").expect("the JSON");
    let json = json[..json.find("</pre>").expect("an end")].replace("&quot;", "\"");
    assert_eq!(serde_json::from_str::<Value>(&json).expect("one JSON object"), made.json);
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let with_threads = |threads: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let report = folder.path().join("report.html");
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        command.env("RAYON_NUM_THREADS", threads).args(["run", "--runs", "20", "--steps", "40", "--report"]);
        command
            .arg(&report)
            .arg(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs/pendulum_bad.toml"));
        command.assert().success();
        fs::read_to_string(&report).expect("the report")
    };
    assert_eq!(with_threads("1"), with_threads("3"));
}

#[test]
fn every_chart_names_both_axes() {
    let made = make("run", "drive_event.toml", &[]);
    let across = [
        "time in s",
        "delay d in steps",
        "age of the applied input in steps",
        "cost of a run",
        "control frames sent, in %",
        "cycle;",
    ];
    let upwards = [
        " (unit of the ",
        " error (its unit)",
        "P(delay = d) in %",
        "cycles in %",
        "runs in %",
        "controller",
        "age in cycles",
    ];
    for picture in pictures(&made.html) {
        let name = &picture[..picture.find('>').expect("an end")];
        assert!(across.iter().any(|label| picture.contains(label)), "{name}: no horizontal axis");
        let (_, drawn) = picture.split_at(name.len());
        assert!(upwards.iter().any(|label| drawn.contains(label)), "{name}: no vertical axis");
    }
}

#[test]
fn every_picture_is_also_a_well_formed_file_of_its_own() {
    let made = make("run", "pendulum_can.toml", &["--controllers", "slqg,slqg-udp"]);
    assert_eq!(made.plots.len(), pictures(&made.html).len());
    for (name, svg) in &made.plots {
        assert!(name.ends_with(".svg") && is_well_formed(svg), "{name}");
        assert!(svg.starts_with("<svg width=") && svg.contains("xmlns="), "{name}");
        assert!(
            svg.contains("fill=\"#FFFFFF\"") && svg.contains("fill=\"#1A1A1A\""),
            "{name}: black on white"
        );
    }
    for picture in pictures(&made.html) {
        assert!(is_well_formed(&format!("<svg{picture}</svg>")));
        assert!(!picture[..picture.find('>').expect("an end")].contains(" width="), "the page sets the size");
    }
}

#[test]
fn a_tag_that_is_not_closed_is_not_well_formed() {
    assert!(is_well_formed("<svg a=\"b\"><line/></svg>"));
    for wrong in ["<svg><text></svg>", "<svg a=\"b></svg>", "<svg></text>", "<svg>"] {
        assert!(!is_well_formed(wrong), "{wrong}");
    }
}

#[test]
fn packets_are_drawn_where_some_are_late_and_named_where_none_is() {
    let made = make("run", "double_integrator_bursty.toml", &["--controllers", "slqg,lqg"]);
    assert!(made.plots.contains_key("packets-slqg.svg") && !made.plots.contains_key("packets-lqg.svg"));
    assert!(made.html.contains("Not drawn: lqg"));
}

/// The pendulum with acknowledgements over a link that delays, loses and, if it is to, doubles them.
fn acknowledged_late(duplicates: &str) -> Made {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs/pendulum.toml");
    let link = format!("acknowledgement = {{ delays = [0.5, 0.2, 0.1]{duplicates} }}");
    let text = fs::read_to_string(path).expect("the design").replace("acknowledgement = \"instant\"", &link);
    assert!(text.contains(&link));
    let folder = tempfile::tempdir().expect("a folder");
    let design = folder.path().join("late.toml");
    fs::write(&design, text).expect("written");
    make("run", design.to_str().expect("a path in UTF-8"), &["--controllers", "slqg,slqg-udp"])
}

#[test]
fn acknowledgements_are_drawn_where_they_go_over_a_link() {
    let of_a_link = acknowledged_late("");
    let svg = &of_a_link.plots["packets-slqg.svg"];
    assert!(
        svg.contains("acknowledgements") && svg.matches("controller\n").count() == 2,
        "two controller lines"
    );
    assert!(!svg.contains("copy made by the link"));
    assert!(of_a_link.html.contains("An acknowledgement is used if"));
    // One that sends none has no line for them, and neither has one that always has them in time.
    assert!(!of_a_link.plots["packets-slqg-udp.svg"].contains("acknowledgements"));
    let instant = make("run", "pendulum.toml", &["--controllers", "slqg"]);
    assert!(!instant.plots["packets-slqg.svg"].contains("acknowledgements"));
    assert!(!instant.html.contains("An acknowledgement is used if"));
}

#[test]
fn copies_that_a_link_makes_are_drawn_and_named() {
    let svg = &acknowledged_late(", duplicates = 0.3").plots["packets-slqg.svg"];
    assert!(svg.contains("copy made by the link"));
    // An arrow has one line, that of a copy several dashes.
    let lines = |svg: &str| svg.matches("<polyline").count() + svg.matches("<line").count();
    assert!(lines(svg) > 20 + lines(&acknowledged_late("").plots["packets-slqg.svg"]));
}

#[test]
fn acknowledgements_on_a_bus_are_drawn_with_the_fate_that_was_decided_later() {
    let svg = &make("run", "pendulum_can.toml", &[]).plots["packets-slqg.svg"];
    assert!(svg.contains("acknowledgements"));
}

#[test]
fn a_loop_that_diverges_is_drawn_too() {
    let made = make(
        "run",
        "pendulum_bad.toml",
        &["--controllers", "slqg-udp", "--sequence-length", "4", "--steps", "1500"],
    );
    assert!(made.json["results"][0]["diverged"].as_u64() > Some(0));
    assert!(made.html.contains("the state diverged with slqg-udp"));
    for (name, svg) in &made.plots {
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
}

#[test]
fn the_picture_in_the_docs_is_what_its_command_draws() {
    let made = make("run", "pendulum_bad.toml", &["--controllers", "slqg", "--steps", "40"]);
    let shown = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/report-packets.svg");
    assert!(fs::read_to_string(shown).expect("the picture") == made.plots["packets-slqg.svg"]);
}
