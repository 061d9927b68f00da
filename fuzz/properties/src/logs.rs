//! Logs of a link, in each format that is read: packets come out in order and none arrives before it was sent, and what is told of them is
//! a link that a design file takes.

use crate::script::{byte, up_to};
use arbitrary::{Result, Unstructured};
use gain_gen::design::Design;
use slqg_links::identify::{
    figures::Figures,
    formats::message::CanId,
    fragment::fragment,
    logs::{Format, Selection, traces},
    sample::{Clock, LONGEST},
    trace::{Gaps, Trace},
};
use std::path::PathBuf;

/// Delays of the longest list that is handed to a design.
const MOST_DELAYS: usize = 40;
/// Bytes of a log beyond which nothing new comes.
const MOST_BYTES: usize = 1 << 14;

/// The formats by their place in a script; before them: recognised by the content.
const FORMATS: [Format; 13] = [
    Format::Csv,
    Format::Candump,
    Format::Pcap,
    Format::CandumpView,
    Format::Asc,
    Format::Blf,
    Format::Trc,
    Format::PythonCanText,
    Format::PythonCanCsv,
    Format::Irtt,
    Format::Owping,
    Format::Ping,
    Format::Fping,
];

/// Reads the first bytes as options and the others as one log or two.
pub fn check(bytes: &[u8]) {
    // What is too short for options is no log either.
    let _ = read(&mut Unstructured::new(bytes));
}

fn read(script: &mut Unstructured<'_>) -> Result<()> {
    let (format, gaps, kind) = (up_to(script, FORMATS.len() as u8)?, up_to(script, 2)?, up_to(script, 4)?);
    let (parts, cycles) = (byte(script)?, up_to(script, 200)?);
    let bytes = script.bytes(script.len().min(MOST_BYTES))?;
    // Where the first of two logs ends, in parts of 256 of all bytes; zero: there is one.
    let (first, second) = bytes.split_at(bytes.len() * usize::from(parts) / 256);
    let logs: Vec<(PathBuf, Vec<u8>)> = match parts {
        0 => vec![("one.log".into(), bytes.into())],
        _ => vec![("one.log".into(), first.into()), ("two.log".into(), second.into())],
    };
    let selection = Selection {
        format: usize::from(format).checked_sub(1).map(|index| FORMATS[index]),
        gaps: [None, Some(Gaps::Lost), Some(Gaps::Ignore)][usize::from(gaps)],
        tx: Some("can0"),
        rx: Some("can1"),
        id: (kind == 4).then_some(CanId::of(0x123)),
        kind,
        sample_time: (gaps == 0).then_some(0.001 * f64::from(cycles + 1)),
        halves_round_trips: true,
        is_way_back: cycles % 3 == 1,
        shortest_delay: (cycles % 5 == 1).then_some(1000),
        ..Selection::default()
    };
    let traces = match traces(&logs, &selection) {
        Ok(traces) => traces,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return Ok(());
        }
    };
    traces.iter().for_each(in_order);
    let clock = Clock {
        sample_time: 0.001 * f64::from(cycles + 1),
        offset: 0.0005 * f64::from(cycles % 2),
        longest: if cycles > 100 { LONGEST } else { usize::from(cycles) },
    };
    match Figures::new(logs.iter().map(|(name, _)| name.display().to_string()).collect(), &traces, &clock) {
        Ok(figures) => told(&figures),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    Ok(())
}

fn in_order(trace: &Trace) {
    let mut before = None;
    for packet in trace.packets() {
        assert!(before.is_none_or(|before| before < packet.sequence), "each once, in order");
        before = Some(packet.sequence);
        if let (Some(sent), Some(received)) = (packet.sent, packet.received) {
            assert!(sent <= received, "none arrives before it was sent");
        }
        assert!(
            packet.sent.is_some() || packet.received.is_none(),
            "what only a gap tells of did not arrive"
        );
    }
}

fn told(figures: &Figures) {
    let shares = || figures.delays.iter().chain([&figures.loss]);
    for share in shares() {
        let (probability, within) = (share.probability, 0.0..=1.0);
        assert!(within.contains(&probability) && share.low <= probability && probability <= share.high);
        assert!(within.contains(&share.low) && within.contains(&share.high));
    }
    assert_eq!(
        shares().map(|share| share.packets).sum::<u64>(),
        figures.packets,
        "every packet is told of once"
    );
    assert!(figures.mean_delay >= 0.0 && (0.0..=1.0).contains(&figures.unseen_below));
    let json: serde_json::Value = serde_json::from_str(&figures.json()).expect("JSON");
    assert_eq!(json["packets"], figures.packets);
    if figures.delays.len() > MOST_DELAYS {
        return;
    }
    let text = DESIGN.replace("# LINK", &fragment(figures, "controller_to_actuator"));
    let design = Design::parse(&text, "identified.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let link = &design.network.controller_to_actuator.delays;
    for (delay, share) in figures.delays.iter().enumerate() {
        // As many digits as are written.
        assert!((link.probability(delay) - share.probability).abs() < 1e-6, "the link that was identified");
    }
}

/// A design whose link to the actuator is missing.
const DESIGN: &str = r#"
name = "identified"
[plant]
sample_time = 0.1
discrete = { a = [[0.5]], b = [[1]] }
c = [[1]]
process_noise = [[1]]
measurement_noise = [[1]]
initial_mean = [0]
initial_covariance = [[1]]
[cost]
q = [[1]]
r = [[1]]
[controller]
sequence_length = 1
[network]
sensor_to_controller.delays = [1]
# LINK
"#;
