//! [`Experiment`]: what a sweep simulates, as the first line of its file tells it.

use super::layout::Shard;
use crate::contender::Kind;
use crc::{CRC_32_ISCSI, CRC_64_XZ, Crc};
use gain_gen::design::Design;
use serde::{Deserialize, Serialize};

/// Version of the file's format.
pub const FORMAT: u32 = 2;
/// Of heads and rows.
pub(super) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
/// What the first line begins with.
const MARK: &str = "# host-sim sweep ";
/// Runs that are simulated together, of one case.
const CHUNK: u64 = 16;

/// A design of the sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Studied {
    /// Its name.
    pub name: String,
    /// Of its text, its network with all that it is read from, and what the command line changes: hexadecimal.
    pub checksum: String,
    /// Length of a cycle in seconds.
    pub sample_time: f64,
    /// What a cycle costs, as a formula.
    pub stage_cost: String,
}

impl Studied {
    /// `design`, read from `text` and perhaps changed since; `changes` says what else makes its runs others.
    pub fn new(design: &Design, text: &str, changes: &str) -> Self {
        // The network may come from other files too: logs of a link or of a bus.
        let content = format!("{text}\n{:?}\n{changes}", design.network);
        let goal = design.tracking.as_ref().map(|tracking| &tracking.goal);
        Self {
            name: design.name.clone(),
            checksum: format!("{:016x}", Crc::<u64>::new(&CRC_64_XZ).checksum(content.as_bytes())),
            sample_time: design.plant.sample_time,
            stage_cost: crate::output::stage_cost(goal).to_string(),
        }
    }
}

/// One controller with sequences of one length for one design.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Case {
    /// Name of the design.
    pub design: String,
    /// The controller.
    #[serde(with = "kind_by_name")]
    pub controller: Kind,
    /// Inputs per sequence.
    pub sequence_length: usize,
}

/// Everything that a file's rows follow from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// [`FORMAT`].
    pub(super) format: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Runs per case.
    pub runs: u64,
    /// Cycles per run.
    pub steps: usize,
    /// Runs that are simulated together, and dealt out to shards together.
    pub chunk: u64,
    /// Which part of it.
    pub shard: Shard,
    /// The designs.
    pub designs: Vec<Studied>,
    /// What is simulated, in this order; cases that cannot be stabilised are not among it.
    pub cases: Vec<Case>,
}

impl Experiment {
    /// All of an experiment.
    pub fn new(plan: crate::monte_carlo::Plan, designs: Vec<Studied>, cases: Vec<Case>) -> Self {
        let crate::monte_carlo::Plan { runs, steps, seed } = plan;
        let runs = runs as u64;
        Self { format: FORMAT, seed, runs, steps, chunk: CHUNK, shard: Shard::ALL, designs, cases }
    }

    /// The first line of the file, with its end.
    pub fn head(&self) -> String {
        let json = serde_json::to_string(self).expect("numbers and strings are always JSON");
        format!("{MARK}{json}\n")
    }

    /// A checksum of the head, whatever the shard: rows of other experiments do not fit it.
    pub(super) fn fingerprint(&self) -> u32 {
        CHECKSUM.checksum(Self { shard: Shard::ALL, ..self.clone() }.head().as_bytes())
    }

    /// From the first line of a file.
    ///
    /// # Errors
    /// What is wrong with it, for people.
    pub fn from_head(line: &str) -> Result<Self, String> {
        let json = line.trim_end().strip_prefix(MARK).ok_or("not written by `host-sim sweep`")?;
        let wrong = |reason: &dyn std::fmt::Display| format!("line 1: not a head of a sweep: {reason}");
        let value: serde_json::Value = serde_json::from_str(json).map_err(|error| wrong(&error))?;
        if value["format"] != FORMAT {
            let found = &value["format"];
            return Err(format!("format {found}; this version reads format {FORMAT}: sweep again with it"));
        }
        let experiment: Self = serde_json::from_value(value).map_err(|error| wrong(&error))?;
        match experiment.chunk == 0 || experiment.runs == 0 || experiment.cases.is_empty() {
            true => Err(wrong(&"it has no runs")),
            false => Ok(experiment),
        }
    }

    /// In what `other` is another experiment, shards apart.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let numbers = [
            ("seed", self.seed, other.seed),
            ("runs", self.runs, other.runs),
            ("steps", self.steps as u64, other.steps as u64),
            ("chunk", self.chunk, other.chunk),
        ];
        if let Some((what, own, others)) = numbers.into_iter().find(|(_, own, others)| own != others) {
            return Some(format!("{what}: {own} against {others}"));
        }
        let names =
            |of: &Self| of.designs.iter().map(|design| design.name.clone()).collect::<Vec<_>>().join(", ");
        if names(self) != names(other) {
            return Some(format!("designs: {} against {}", names(self), names(other)));
        }
        if let Some((own, _)) = self.designs.iter().zip(&other.designs).find(|(own, others)| own != others) {
            return Some(format!(
                "design {}: its file, a log that it names, or options that change it",
                own.name
            ));
        }
        (self.cases != other.cases).then(|| "controllers or lengths".to_string())
    }
}

/// Controllers as they are called.
mod kind_by_name {
    use super::Kind;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub(super) fn serialize<S: Serializer>(kind: &Kind, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(kind.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Kind, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}
