//! One link of `[network]`, in any of the ways a design file can give it. Which links there are is in `network`.

use super::document::{Field, Section};
use super::{DelayDistribution, DesignError, can};
use slqg_links::{
    can::Id,
    identify::{
        formats::message::CanId,
        logs::{self, Selection},
        sample::{Clock, LONGEST, Sample},
    },
    link::Link,
    markov::{MOST_STATES, MarkovLink},
    recording::Recording,
};
use std::path::PathBuf;

/// Most entries of a list of delays; a longer one is a mistake, not a link.
const MOST_DELAYS: usize = 1000;
/// The ways, of which a link takes one.
const WAYS: [&str; 5] = ["delays", "gilbert_elliott", "markov", "trace", "can"];
const A_PROBABILITY: &str = "a probability per cycle, above 0 and at most 1";
const STATE_DELAYS: &str = "the probabilities of delay 0, 1, .. steps in this state, each within 0 and 1, with a sum of \
                            at most 1 (what is missing to 1 is loss; an empty list loses all)";

/// What a link's figures are read against.
pub(super) struct Surroundings<'d> {
    /// Control cycle in seconds.
    pub(super) sample_time: f64,
    /// The design file, beside which traces are looked for.
    pub(super) origin: &'d str,
    /// Kind of the frames on the link (docs/wire-format.md).
    pub(super) kind: u8,
}

/// The link behind a key, and its identifier if it is on the bus: what it does to packets is then not known yet.
///
/// Errors: no way, more than one, or figures that are none.
pub(super) fn read(
    field: &Field<'_>,
    surroundings: &Surroundings<'_>,
) -> Result<(Link, Option<Id>), DesignError> {
    let table = field.section(&["delays", "gilbert_elliott", "markov", "trace", "can", "duplicates"])?;
    let given: Vec<_> = WAYS.into_iter().filter(|way| table.optional(way, "").is_some()).collect();
    let mut link = match given.as_slice() {
        ["gilbert_elliott"] => gilbert_elliott(&table)?,
        ["markov"] => markov(&table)?,
        ["trace"] => trace(&table, surroundings)?,
        ["can"] => return on_bus(&table),
        [_, other, ..] => {
            let found = format!("found `{other}` beside `{}`", given[0]);
            return Err(table.reject(table.key(), found, format!("give one of {}", WAYS.join(", "))));
        }
        // Without any of them, delays are what is missing.
        _ => Link::independent(delays(&table)?),
    };
    if let Some(field) = table.optional("duplicates", "a probability from 0 to 0.5") {
        link.duplicates = field.number()?;
        if !(0.0..=0.5).contains(&link.duplicates) {
            return Err(field.reject(format!("found the number {}", link.duplicates)));
        }
    }
    Ok((link, None))
}

fn on_bus(table: &Section<'_>) -> Result<(Link, Option<Id>), DesignError> {
    if let Some(field) = table.optional("duplicates", "") {
        let found = "found beside can".to_string();
        return Err(field.reject_with(found, "leave it out: the bus repeats what it repeats".into()));
    }
    Ok((Link::bus(Link::perfect().delays), Some(can::identifier(table)?)))
}

fn delays(table: &Section<'_>) -> Result<DelayDistribution, DesignError> {
    let meaning = "the probabilities of delay 0, 1, .. steps, each within 0 and 1, with a sum of at most 1 \
                   (what is missing to 1 is loss) and above 0";
    let field = table.required("delays", meaning)?;
    DelayDistribution::new(few(&field, field.numbers()?)?).map_err(|error| field.reject(error.to_string()))
}

fn few(field: &Field<'_>, probabilities: Vec<f64>) -> Result<Vec<f64>, DesignError> {
    if probabilities.len() > MOST_DELAYS {
        let found = format!("found {} delays", probabilities.len());
        return Err(field.reject_with(found, format!("give at most {MOST_DELAYS}; count the rest as loss")));
    }
    Ok(probabilities)
}

fn gilbert_elliott(table: &Section<'_>) -> Result<Link, DesignError> {
    let meaning = "{ to_bad = P(good -> bad), to_good = P(bad -> good), good = [..], bad = [..] }, per cycle";
    let whole = table.required("gilbert_elliott", meaning)?;
    let model = whole.section(&["to_bad", "to_good", "good", "bad"])?;
    let change = |name| {
        let field = model.required(name, A_PROBABILITY)?;
        let probability = field.number()?;
        let is_one = probability > 0.0 && probability <= 1.0;
        if is_one { Ok(probability) } else { Err(field.reject(format!("found the number {probability}"))) }
    };
    let state = |name| {
        let field = model.required(name, STATE_DELAYS)?;
        few(&field, field.numbers()?)
    };
    let link =
        MarkovLink::gilbert_elliott(change("to_bad")?, change("to_good")?, state("good")?, state("bad")?);
    link.map(Link::markov).map_err(|error| {
        let states = "state 0 is good, state 1 bad; each list holds probabilities that sum to at most 1, and one of \
                      them lets packets arrive";
        whole.reject_with(error.to_string(), states.into())
    })
}

fn markov(table: &Section<'_>) -> Result<Link, DesignError> {
    let meaning =
        "{ transitions = [[P(from 0 to 0), P(from 0 to 1), ..], ..], delays = [[..], ..] }, per cycle";
    let whole = table.required("markov", meaning)?;
    let model = whole.section(&["transitions", "delays"])?;
    let transitions =
        model.required("transitions", "a square matrix of probabilities, with rows that sum to 1")?;
    let matrix = transitions.matrix()?;
    let delays = model.required("delays", "one list of delay probabilities for each state")?;
    let delays = delays.lists()?.into_iter().map(|list| few(&delays, list)).collect::<Result<Vec<_>, _>>()?;
    let rows = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    MarkovLink::new(rows, delays).map(Link::markov).map_err(|error| {
        let allowed = format!(
            "give a square matrix of transitions between up to {MOST_STATES} states with rows that sum to 1, a way from \
             every state to every other, and one list of delays for each state"
        );
        whole.reject_with(error.to_string(), allowed)
    })
}

/// `"file"` or a table with options, as `host-sim identify` has them.
fn trace(table: &Section<'_>, surroundings: &Surroundings<'_>) -> Result<Link, DesignError> {
    let meaning =
        "the path of a log, or { files = [..], tx = \"can0\", rx = \"can1\", id = 0x123, offset = seconds }";
    let field = table.required("trace", meaning)?;
    let (mut offset, mut tx, mut rx, mut id) = (0.0, None, None, None);
    let names = if field.is_text() {
        vec![field.text()?]
    } else {
        let options = field.section(&["files", "offset", "tx", "rx", "id"])?;
        let seconds =
            "the time in seconds from the begin of a cycle to the sending, from 0 to less than two cycles";
        if let Some(field) = options.optional("offset", seconds) {
            offset = field.number()?;
            if !(0.0..2.0 * surroundings.sample_time).contains(&offset) {
                return Err(field.reject(format!("found the number {offset}")));
            }
        }
        let interface = "the name of an interface, as \"can0\"";
        tx = options.optional("tx", interface).map(|field| field.text()).transpose()?;
        rx = options.optional("rx", interface).map(|field| field.text()).transpose()?;
        let identifier = options.optional("id", "a CAN identifier, 0 to 0x1fffffff");
        id = identifier
            .map(|field| field.whole_number(0..=0x1fff_ffff))
            .transpose()?
            .map(|id| CanId::of(id as u32));
        options.required("files", "a list of the paths of logs, at least one")?.texts()?
    };
    let beside = std::path::Path::new(surroundings.origin).parent();
    let paths: Vec<PathBuf> =
        names.iter().map(|name| beside.map_or_else(|| name.into(), |folder| folder.join(name))).collect();
    let selection = Selection {
        tx,
        rx,
        id,
        kind: surroundings.kind,
        sample_time: Some(surroundings.sample_time),
        ..Selection::default()
    };
    let clock = Clock { sample_time: surroundings.sample_time, offset, longest: LONGEST };
    let wrong = |error: &dyn std::fmt::Display| {
        field.reject_with(format!("found {error}"), "give a log that `host-sim identify` can read".into())
    };
    let traces = logs::read(&paths, &selection).map_err(|error| wrong(&error))?;
    let recording = Recording::of(&Sample::new(&traces, &clock).map_err(|error| wrong(&error))?);
    let shares = recording.shares().map_err(|error| wrong(&error))?;
    Ok(Link::recorded(shares, recording))
}
