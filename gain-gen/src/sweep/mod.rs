//! What each sequence length costs: one design, many lengths, side by side.
//!
//! [`Sweep`] holds the figures; `table`, `json` and `plot` write them down.

mod json;
mod plot;
mod table;

use crate::channels;
use crate::design::{Design, DeviceScalar};
use crate::estimation::Sight;
use crate::report::{FailedCondition, Verdict, failed};
use crate::solve::{LoopProblem, Method, Outcome, emitted_rate, if_linear, solve};
use rayon::prelude::*;
use slqg::DefaultInput;
use slqg::estimator::Merging;

/// The figures of every length asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Name of the design.
    pub name: String,
    /// Default inputs compared, at least one.
    pub default_inputs: Vec<DefaultInput>,
    /// Scalar on the device, for the sizes in bytes.
    pub scalar: DeviceScalar,
    /// In order of the default inputs, and for each of ascending length.
    pub results: Vec<LengthFigures>,
}

/// What one length comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthFigures {
    /// Inputs per packet, `N`.
    pub sequence_length: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
    /// Whether the loop is shown to be stable with this length as it runs; as in [`crate::report::Report::verdict`].
    pub verdict: Verdict,
    /// Whether the loop of the theorems is stable; as in [`crate::report::Report::converged`].
    pub converged: bool,
    /// Spectral radius of the closed loop's second moments, per step.
    pub mean_square_rate: f64,
    /// Long-run cost per step with the state known, `tr(P W)`; infinite if no gains stabilise.
    pub control_cost: f64,
    /// Numbers in the tables on the device: `Lx`, `M`, `r`.
    pub table_floats: usize,
    /// Numbers in the tables of the coupled form.
    pub coupled_table_floats: usize,
}

impl Sweep {
    /// Solves `design` for each of the `lengths` with each of the `default_inputs`, in parallel.
    ///
    /// The same figures in the same order on any number of threads.
    pub fn new(design: &Design, lengths: &[usize], default_inputs: &[DefaultInput]) -> Self {
        let sight = Sight::of(design);
        let cases: Vec<_> = default_inputs
            .iter()
            .flat_map(|&input| lengths.iter().map(move |&length| (input, length)))
            .collect();
        let results = cases
            .into_par_iter()
            // One case a task: a few long sequences take most of the time.
            .with_max_len(1)
            .map(|(default_input, length)| {
                let problem = LoopProblem { default_input, length, ..LoopProblem::of(design) };
                figures(design, &problem, sight)
            })
            .collect();
        Self {
            name: design.name.clone(),
            default_inputs: default_inputs.to_vec(),
            scalar: design.controller.scalar,
            results,
        }
    }

    /// Whether any length stabilises the loop.
    pub fn is_any_stable(&self) -> bool {
        self.results.iter().any(|figures| figures.verdict == Verdict::Stable)
    }

    /// Cost of `figures` as a multiple of the cost of the longest stable length with the same default input.
    /// `None` if it has no finite cost, or the longest costs nothing.
    pub fn relative_cost(&self, figures: &LengthFigures) -> Option<f64> {
        let comparable = |other: &&LengthFigures| {
            other.default_input == figures.default_input && other.control_cost.is_finite()
        };
        let longest = self.results.iter().rfind(comparable)?.control_cost;
        (figures.control_cost.is_finite() && longest > 0.0).then(|| figures.control_cost / longest)
    }

    /// Size of `floats` numbers on the device, in bytes.
    pub fn bytes(&self, floats: usize) -> usize {
        floats
            * match self.scalar {
                DeviceScalar::F32 => size_of::<f32>(),
                DeviceScalar::F64 => size_of::<f64>(),
            }
    }
}

fn figures(design: &Design, problem: &LoopProblem, sight: Sight) -> LengthFigures {
    let solution = solve(problem, Method::InFlight).for_acknowledgements(design, problem);
    let unacknowledged = if_linear(design, problem, &solution);
    let found = unacknowledged.as_ref();
    let emitted_rate = emitted_rate(design, problem, &solution, found);
    let on_channel = channels::control(design, problem, &solution);
    let conditions =
        failed(design, problem, (&solution, found), emitted_rate, sight, on_channel, (None, || None));
    LengthFigures {
        sequence_length: problem.length,
        default_input: problem.default_input,
        verdict: Verdict::of(&conditions),
        converged: !conditions.iter().any(FailedCondition::is_of_theorems),
        mean_square_rate: found.map_or(solution.mean_square_rate, |found| found.rate),
        control_cost: match solution.outcome {
            Outcome::Converged if design.estimator() == Merging::Linear => {
                found.map_or(f64::INFINITY, |found| found.cost)
            }
            Outcome::Converged => solution.control_cost(&design.plant.process_noise),
            Outcome::Unstable | Outcome::Undecided => f64::INFINITY,
        },
        table_floats: solution.law.table_floats(),
        coupled_table_floats: solution.law.coupled_table_floats(),
    }
}
