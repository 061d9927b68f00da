//! [`Shard`] and the order of the rows: case by case, and run by run.
//!
//! Work is dealt out in chunks of runs. Shard `i` of `n` has chunk `i`, `i + n`, ..; within a file chunks keep their order.

use super::experiment::Experiment;
use serde::{Deserialize, Serialize};
use std::{fmt, ops::Range, str::FromStr};

/// Which part of an experiment: the `index`-th of `count`, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// All of it.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// Which one, from 1.
    pub fn index(self) -> usize {
        self.index
    }

    /// How many there are.
    pub fn count(self) -> usize {
        self.count
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(format!("found `{text}`; give i/n with i from 1 to n, such as 1/4")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

/// Runs of one case that are simulated together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// Which case.
    pub case: usize,
    /// Numbers of the runs.
    pub runs: Range<u64>,
}

impl Chunk {
    /// How many runs.
    pub fn len(&self) -> usize {
        (self.runs.end - self.runs.start) as usize
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }
}

impl Experiment {
    /// The chunks of the shard, in the order of the file.
    pub fn chunks(&self) -> impl Iterator<Item = Chunk> + Send {
        let (runs, size, Shard { index, count }) = (self.runs, self.chunk, self.shard);
        let per_case = runs.div_ceil(size);
        let all = per_case * self.cases.len() as u64;
        ((index as u64 - 1)..all).step_by(count).map(move |number| {
            let first = number % per_case * size;
            Chunk { case: (number / per_case) as usize, runs: first..(first + size).min(runs) }
        })
    }

    /// The chunks that are left after `done` rows; of the first, perhaps only a part.
    pub fn chunks_after(&self, done: usize) -> impl Iterator<Item = Chunk> + Send {
        let mut skip = done as u64;
        self.chunks().filter_map(move |mut chunk| {
            let skipped = skip.min(chunk.len() as u64);
            skip -= skipped;
            chunk.runs.start += skipped;
            (!chunk.is_empty()).then_some(chunk)
        })
    }

    /// Rows of a complete file.
    pub fn rows(&self) -> usize {
        self.chunks().map(|chunk| chunk.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{contender::Kind, monte_carlo::Plan, sweep::Case};

    fn experiment(shard: &str) -> Experiment {
        let case = |sequence_length| Case { design: "a".into(), controller: Kind::Slqg, sequence_length };
        let plan = Plan { runs: 40, steps: 1, seed: 1 };
        let mut experiment = Experiment::new(plan, vec![], vec![case(1), case(2)]);
        experiment.shard = shard.parse().expect("a shard");
        experiment
    }

    #[test]
    fn shards_share_all_runs_out_and_none_twice() {
        let mut all = Vec::new();
        for shard in ["1/4", "2/4", "3/4", "4/4"] {
            let experiment = experiment(shard);
            let dealt: Vec<_> =
                experiment.chunks().flat_map(|chunk| chunk.runs.map(move |run| (chunk.case, run))).collect();
            assert_eq!(experiment.rows(), dealt.len());
            all.extend(dealt);
        }
        all.sort_unstable();
        let expected: Vec<_> = (0..2).flat_map(|case| (0..40).map(move |run| (case, run))).collect();
        assert_eq!(all, expected);
    }

    #[test]
    fn what_is_left_begins_within_a_chunk() {
        let left: Vec<_> = experiment("1/1").chunks_after(37).take(2).collect();
        assert_eq!(left, [Chunk { case: 0, runs: 37..40 }, Chunk { case: 1, runs: 0..16 }]);
        assert_eq!(experiment("1/1").chunks_after(80).count(), 0);
    }

    #[test]
    fn a_shard_that_is_none_is_refused() {
        for text in ["0/2", "3/2", "1", "a/b", "1/0"] {
            assert!(text.parse::<Shard>().unwrap_err().contains("give i/n"), "{text}");
        }
    }
}
