//! `controller.sequence_length = "auto"`: the shortest length that costs nearly as little as long sequences do.
//!
//! What counts is the long-run cost per step with the state known, `tr(P W)`. A length that does not stabilise the loop
//! costs infinitely much.
//!
//! **The limit.** With zero default input the cost never rises with the length: a longer sequence can end in zeros.
//! It falls for ever, though by ever less: the last of `N` inputs is applied only where none of the next `N` packets
//! comes in time, with probability `(1 - Q(0)) (1 - Q(1)) .. (1 - Q(N-1))`. So the cost of infinitely long sequences is
//! taken at a length that
//!
//! 1. is at least twice as long as one for which that probability is at most a tenth of the tolerance, so that all
//!    delays that matter, and rows of losses, have had their part in what follows, and
//! 2. changed the cost by less than a tenth of the tolerance when it was reached by doubling.
//!
//! If there is no such length up to [`LONGEST_SEQUENCE`], the cost there stands in, and the choice says so.
//!
//! **The search.** With zero default input by bisection, after ever longer strides from the shortest length. With hold,
//! an input that comes late may do harm that the held one does not, so that the cost need not fall at every step: the
//! lengths are tried one after the other.

use crate::design::{Design, LONGEST_SEQUENCE, LengthChoice, LongSequences};
use crate::solve::{LoopProblem, Method, solve};
use crate::stability;
use slqg::DefaultInput;
use std::collections::HashMap;

/// Part of the tolerance by which the cost may still change where a sequence counts as long.
const SETTLED: f64 = 0.1;

impl Design {
    /// The choice behind the sequence length; `None` if it was given, or changed since it was chosen.
    pub fn length_choice(&self) -> Option<&LengthChoice> {
        let settings = &self.controller;
        settings.length_choice.as_ref().filter(|choice| {
            (choice.length, choice.default_input) == (settings.sequence_length, settings.default_input)
        })
    }

    /// Takes sequences of `length` inputs, 1 to 128, whatever the design says.
    pub fn set_sequence_length(&mut self, length: usize) {
        self.controller.sequence_length = length;
        self.controller.length_choice = None;
        // Longer frames take longer on a bus. Where none of them arrives, the delays stay those of the length before.
        self.run_on_bus();
    }

    /// Lets each acknowledgement tell `cycles` cycles, 1 to 8, whatever the design says.
    pub fn set_acknowledged_cycles(&mut self, cycles: usize) {
        self.network.acknowledged_cycles = cycles;
        self.run_on_bus();
    }

    /// Takes another default input. A length that the design leaves open is chosen anew.
    pub fn set_default_input(&mut self, default_input: DefaultInput) {
        let open = self.length_choice().filter(|choice| choice.default_input != default_input);
        let open = open.map(|choice| choice.tolerance);
        self.controller.default_input = default_input;
        if let Some(tolerance) = open {
            self.choose_length(tolerance);
        }
    }

    /// Takes the shortest length whose cost is within `tolerance` of the cost of long sequences.
    pub(crate) fn choose_length(&mut self, tolerance: f64) {
        let choice = Search::new(self, LONGEST_SEQUENCE).choose(tolerance);
        self.controller.sequence_length = choice.length;
        self.controller.length_choice = Some(choice);
    }
}

/// Costs by length, computed once each.
struct Search<'d> {
    design: &'d Design,
    problem: LoopProblem,
    /// Longest length to consider.
    longest: usize,
    costs: HashMap<usize, f64>,
}

impl<'d> Search<'d> {
    fn new(design: &'d Design, longest: usize) -> Self {
        Self { design, problem: LoopProblem::of(design), longest, costs: HashMap::new() }
    }

    /// `tr(P W)` with sequences of `length` inputs; infinite if they are not shown to stabilise.
    fn cost(&mut self, length: usize) -> f64 {
        *self.costs.entry(length).or_insert_with(|| {
            let solution = solve(&self.problem.with_length(length), Method::InFlight);
            if !solution.is_stabilising() {
                return f64::INFINITY;
            }
            solution.control_cost(&self.design.plant.process_noise)
        })
    }

    fn choose(mut self, tolerance: f64) -> LengthChoice {
        let default_input = self.problem.default_input;
        let holds_all = (self.problem.link.largest_delay() + 1).min(self.longest);
        let none = LengthChoice {
            tolerance,
            default_input,
            length: holds_all,
            limit: LongSequences::NoneStabilises,
        };
        let shortest = stability::shortest_admissible_length(&self.problem);
        let Some(shortest) = shortest.filter(|&length| length <= self.longest) else { return none };
        let limit = self.limit(tolerance);
        let (longest, cost) = match limit {
            LongSequences::Settled { length, cost } | LongSequences::Capped { length, cost } => {
                (length, cost)
            }
            LongSequences::NoneStabilises => return none,
        };
        let bound = (1.0 + tolerance) * cost;
        let length = match default_input {
            DefaultInput::Zero => self.shortest_within(shortest, longest, bound),
            DefaultInput::Hold => {
                (shortest..longest).find(|&length| self.cost(length) <= bound).unwrap_or(longest)
            }
        };
        LengthChoice { tolerance, default_input, length, limit }
    }

    /// Doubles the length, from one whose last input is hardly ever applied, until that no longer matters.
    fn limit(&mut self, tolerance: f64) -> LongSequences {
        let (mut length, mut applied) = (0, 1.0);
        while applied > SETTLED * tolerance && length < self.longest {
            applied *= 1.0 - self.problem.link.arrival(length);
            length += 1;
        }
        while 2 * length <= self.longest {
            let (before, cost) = (self.cost(length), self.cost(2 * length));
            if cost.is_finite() && (before - cost).abs() <= SETTLED * tolerance * cost {
                return LongSequences::Settled { length: 2 * length, cost };
            }
            length *= 2;
        }
        let (length, cost) = (self.longest, self.cost(self.longest));
        if cost.is_finite() { LongSequences::Capped { length, cost } } else { LongSequences::NoneStabilises }
    }

    /// Shortest length from `low` to `high` whose cost, which falls with the length, is at most `bound`; `high` is one.
    fn shortest_within(&mut self, mut low: usize, mut high: usize, bound: f64) -> usize {
        // Ever longer strides first: long sequences take most of the time, and the answer is rarely among them.
        let mut stride = 1;
        while low + stride <= high && self.cost(low + stride - 1) > bound {
            low += stride;
            stride *= 2;
        }
        high = high.min(low + stride - 1);
        while low < high {
            let middle = (low + high) / 2;
            if self.cost(middle) <= bound {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAD: &str = include_str!("../../../designs/double_integrator_bad.toml");

    #[test]
    fn where_the_longest_sequences_are_still_too_short_the_choice_says_so() {
        let design = Design::parse(BAD, "double_integrator_bad.toml").unwrap();
        // The last of nine inputs is still applied in four of ten thousand cycles; twice nine are not allowed.
        let choice = Search::new(&design, 16).choose(0.01);
        assert!(matches!(choice.limit, LongSequences::Capped { length: 16, .. }), "{choice:?}");
        assert_eq!(choice.length, 7);
        let said =
            "chosen: within 1 % of the cost of N = 16, the longest allowed; longer ones might cost less";
        assert_eq!(choice.to_string(), said);
        let choice = Search::new(&design, 18).choose(0.01);
        assert!(matches!(choice.limit, LongSequences::Settled { length: 18, .. }), "{choice:?}");
    }

    #[test]
    fn what_no_length_stabilises_is_given_the_length_that_holds_the_longest_delay() {
        let lossy = BAD.replace("a = [[1, 1], [0, 1]]", "a = [[4, 1], [0, 1]]");
        assert_ne!(lossy, BAD);
        let choice =
            Search::new(&Design::parse(&lossy, "lossy.toml").unwrap(), LONGEST_SEQUENCE).choose(0.01);
        assert_eq!((choice.length, choice.limit), (10, LongSequences::NoneStabilises));
    }
}
