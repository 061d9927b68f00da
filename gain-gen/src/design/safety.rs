//! `[safety]`: what is believed of the measurements, when an end of the loop is lost, and what the plant gets then.
//!
//! All of it has a default. What the core makes of it is in `slqg::estimator::Plausibility` and `slqg::actuator::Safe`.

mod silence;

use super::document::{Field, Section, counted};
use super::{Acknowledgement, ControllerSettings, DesignError, Network, Plant};
use slqg::{DefaultInput, estimator::Merging};
use slqg_links::identify::chance::two_sided;

/// Standard deviations beyond which no innovation is believed unless the design says. A loop whose plant is not quite the model has
/// larger innovations than the filter thinks, in proportion to its state: a gate of six would take from it what its margins promise.
const FAR: f64 = 100.0;
/// Rejected cycles in a row after which it is the model that is doubted.
const DOUBT_AFTER: usize = 8;
/// Readings that are the same to the bit after which a sensor is held to be stuck.
const STUCK_AFTER: usize = 10;
/// Seconds, and cycles, without a measurement that are an outage on any link.
const OUTAGE: (f64, usize) = (2.0, 100);
/// Most cycles that a count can have.
const MOST: usize = u16::MAX as usize;

/// What both ends do where measurements or packets fail. Counts are of cycles in a row; 0 stands for never.
#[derive(Debug, Clone, PartialEq)]
pub struct Safety {
    /// Probability that an output of a right measurement is rejected.
    pub gate: Gate,
    /// Cycles in which nothing that was measured was believed before the estimate begins anew.
    pub doubt_after: u8,
    /// (least, greatest) reading of each output, in output units.
    pub range: Option<Vec<(f64, f64)>>,
    /// Readings of each output that are the same before it is held to be stuck.
    pub stuck_after: Vec<u16>,
    /// Whether the readings of an output that is held to be stuck are taken for not measured.
    pub rejects_stuck: bool,
    /// Cycles without a measurement before the loop is degraded.
    pub stale_after: u16,
    /// Cycles without a measurement before the loop is lost, and the controller falls silent.
    pub lost_after: u16,
    /// Cycles with an empty buffer before the actuator applies an input, and that, in input units.
    pub safe: Option<(u16, Vec<f64>)>,
}

/// Whether measurements are judged by how well they fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gate {
    /// Beyond 100 standard deviations; never where the estimator itself weighs ages that would explain them.
    Usual,
    /// With this probability of rejecting one that is right.
    Level(f64),
    /// Never.
    None,
}

impl Safety {
    /// `sends_rarely`: whether packets are sent only where they are worth it.
    pub(super) fn read(
        root: &Section<'_>,
        plant: &Plant,
        (network, controller, sends_rarely): (&Network, &ControllerSettings, bool),
    ) -> Result<Self, DesignError> {
        let (inputs, outputs, sample_time) = (plant.inputs(), plant.outputs(), plant.sample_time);
        let keys = [
            "gate",
            "doubt_after",
            "range",
            "stuck_after",
            "reject_stuck",
            "stale_after",
            "lost_after",
            "safe_after",
            "safe_input",
        ];
        let table = root.optional("safety", "a table, of which every key has a default");
        let safety = table.map(|table| table.section(&keys)).transpose()?;
        let field = |name, meaning| safety.as_ref().and_then(|safety| safety.optional(name, meaning));
        let cycles =
            |name, default: usize| match field(name, "a whole number of cycles from 0 (never) to 65535") {
                None => Ok(default as u16),
                Some(field) => Ok(field.whole_number(0..=MOST)? as u16),
            };

        let stale = silence::longest(&network.sensor_to_controller, controller.measurement_buffer);
        let outage = ((OUTAGE.0 / sample_time) as usize).max(OUTAGE.1);
        let lost = stale.map_or(0, |stale| outage.max(10 * stale).min(MOST));
        let (stale_after, lost_after) =
            (cycles("stale_after", stale.unwrap_or(0).min(MOST))?, cycles("lost_after", lost)?);
        let doubt_after = match field("doubt_after", "a whole number of cycles from 0 (never) to 200") {
            None => DOUBT_AFTER,
            Some(field) => field.whole_number(0..=200)?,
        };
        let range = "one pair [least, greatest] per output: [[-1, 1], ..]";
        let unheard =
            silence::longest(&network.controller_to_actuator, network.controller_to_actuator.largest_delay());
        let idle = unheard.map_or(0, |unheard| outage.max(10 * unheard).min(MOST)) as u16;
        let after = cycles("safe_after", idle.into())?;
        let safe = match field("safe_input", "a list of one value per input, in input units") {
            Some(field) => Some(values_of(&field, inputs)?),
            // Zero is applied anyhow; and who sends rarely wants the last input held for as long as it takes.
            None if controller.default_input == DefaultInput::Zero || sends_rarely => None,
            None => Some(vec![0.0; inputs]),
        };
        Ok(Self {
            gate: gate_of(field("gate", "a probability from 1e-100 to 0.1, or 0 to believe everything"))?,
            doubt_after: doubt_after as u8,
            range: field("range", range).map(|field| range_of(&field, outputs)).transpose()?,
            stuck_after: stuck_of(
                field("stuck_after", "readings, 0 (never) to 65535, of all outputs or a list"),
                outputs,
            )?,
            rejects_stuck: field("reject_stuck", "true or false").map_or(Ok(false), |field| field.truth())?,
            stale_after,
            lost_after,
            safe: safe.filter(|_| after > 0).map(|input| (after, input)),
        })
    }

    /// The squared innovation, in its variance, beyond which a reading is rejected in a loop with these acknowledgements and this
    /// estimator: a quantile of the chi-square distribution with one degree of freedom. `None`: everything is believed.
    pub fn threshold(&self, acknowledgement: &Acknowledgement, merging: Merging) -> Option<f64> {
        let level = match self.gate {
            Gate::Usual
                if matches!(merging, Merging::Single | Merging::Linear)
                    || *acknowledgement == Acknowledgement::Instant =>
            {
                return Some(FAR * FAR);
            }
            Gate::Usual | Gate::None => return None,
            Gate::Level(level) => level,
        };
        // The tail falls with the distance: bisection, to the last bit.
        let (mut near, mut far) = (0.0, 40.0);
        for _ in 0..100 {
            let middle = 0.5 * (near + far);
            *(if two_sided(middle) > level { &mut near } else { &mut far }) = middle;
        }
        Some(far * far)
    }
}

fn gate_of(field: Option<Field<'_>>) -> Result<Gate, DesignError> {
    let Some(field) = field else { return Ok(Gate::Usual) };
    match field.number()? {
        0.0 => Ok(Gate::None),
        level if (1e-100..0.1).contains(&level) => Ok(Gate::Level(level)),
        level => Err(field.reject(format!("found the number {level}"))),
    }
}

fn stuck_of(field: Option<Field<'_>>, outputs: usize) -> Result<Vec<u16>, DesignError> {
    let Some(field) = field else { return Ok(vec![STUCK_AFTER as u16; outputs]) };
    let Ok(entries) = field.entries() else {
        return Ok(vec![field.whole_number(0..=MOST)? as u16; outputs]);
    };
    let counts: Vec<_> =
        entries.iter().map(|entry| Ok(entry.whole_number(0..=MOST)? as u16)).collect::<Result<_, _>>()?;
    check_count(&field, counts.len(), outputs, "output")?;
    Ok(counts)
}

fn values_of(field: &Field<'_>, inputs: usize) -> Result<Vec<f64>, DesignError> {
    let values = field.numbers()?;
    check_count(field, values.len(), inputs, "input")?;
    Ok(values)
}

fn check_count(field: &Field<'_>, found: usize, needed: usize, noun: &str) -> Result<(), DesignError> {
    if found == needed {
        return Ok(());
    }
    Err(field.reject(format!(
        "found {}, but the plant has {}",
        counted(found, "value"),
        counted(needed, noun)
    )))
}

fn range_of(field: &Field<'_>, outputs: usize) -> Result<Vec<(f64, f64)>, DesignError> {
    let pairs = field.lists()?;
    check_count(field, pairs.len(), outputs, "output")?;
    let pair = |(at, pair): (usize, &Vec<f64>)| match pair[..] {
        [least, greatest] if least < greatest => Ok((least, greatest)),
        _ => Err(field.reject(format!("found {pair:?} for output {}", at + 1))),
    };
    pairs.iter().enumerate().map(pair).collect()
}
