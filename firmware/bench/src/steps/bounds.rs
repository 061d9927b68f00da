//! Multiply-adds that a step cannot do without, from dimensions alone.
//!
//! Counted where the numbers are unknown: symmetric matrices by their upper triangle, nothing known to be zero but what the
//! dimensions make so. Divisions, roots, exponentials and comparisons are left out: these are lower bounds.

use super::stopwatch::Step;
use slqg::DefaultInput;

/// Dimensions of a loop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dimensions {
    pub(super) states: usize,
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    /// Inputs of a sequence, `N`.
    pub(super) length: usize,
    pub(super) default_input: DefaultInput,
    /// Samples of a reference times its outputs.
    pub(super) reference: usize,
    /// Whether an event trigger decides.
    pub(super) triggered: bool,
    /// Whether estimates are kept apart by age.
    pub(super) apart: bool,
    /// Whether the age is acknowledged.
    pub(super) acknowledged: bool,
}

impl Dimensions {
    /// Of the longest case; `None` for steps that do no arithmetic.
    pub(super) fn multiply_adds(&self, step: Step) -> Option<usize> {
        let sequence = self.length * self.inputs;
        let in_flight = self.in_flight() * self.inputs;
        Some(match step {
            Step::Law => sequence * (self.states + in_flight),
            Step::ExpectedInputs => self.expected_inputs(),
            Step::Estimator => self.predict() + self.update(),
            Step::ModeFilter => self.mode_filter(),
            Step::Feedforward => {
                let displaced = if self.triggered { in_flight } else { 0 };
                (sequence + displaced) * self.reference
            }
            Step::Benefit => self.benefit(),
            Step::ControllerCycle => {
                let estimator = if self.acknowledged { Step::Estimator } else { Step::ModeFilter };
                let steps = [Some(Step::Law), Some(Step::ExpectedInputs), Some(estimator)];
                let feedforward = (self.reference > 0).then_some(Step::Feedforward);
                let benefit = self.triggered.then_some(Step::Benefit);
                let all = steps.into_iter().chain([feedforward, benefit]).flatten();
                all.filter_map(|step| self.multiply_adds(step)).sum()
            }
            _ => return None,
        })
    }

    fn in_flight(&self) -> usize {
        self.default_input.in_flight(self.length)
    }

    /// With an empty buffer, every sequence under way is weighed against what is expected without it.
    fn expected_inputs(&self) -> usize {
        let one_age = (self.length - 1) * self.in_flight() * self.inputs;
        // Of every age its own, and their mean.
        if self.acknowledged { one_age } else { one_age + self.length * self.in_flight() * self.inputs }
    }

    /// `A x + B u`, `A P A^T`.
    fn predict(&self) -> usize {
        let nx = self.states;
        nx * nx + nx * self.inputs + nx * nx * nx + nx * triangle(nx)
    }

    /// `C P`, `C P C^T`, the gain, the innovation, `x + K e`, and `P - K C P`, the shortest form there is.
    fn update(&self) -> usize {
        let (nx, ny) = (self.states, self.outputs);
        ny * nx * nx + nx * triangle(ny) + nx * ny * ny + 2 * nx * ny + ny * triangle(nx)
    }

    /// Mean and covariance of one estimate merged into another.
    fn merge(&self) -> usize {
        self.states + 2 * triangle(self.states)
    }

    fn mode_filter(&self) -> usize {
        let ages = self.length + 1;
        if self.apart {
            // Each age merges those that lead to it, and at the end all are merged.
            ages * (self.predict() + self.update()) + (triangle(ages) + ages) * self.merge()
        } else {
            self.predict() + self.update() + ages * (self.inputs + triangle(self.inputs))
        }
    }

    /// Quadratic in the sequence, bilinear in state and expected inputs, and for each cycle to come a quadratic in what
    /// is expected of each sequence that may be played then.
    fn benefit(&self) -> usize {
        let (in_flight, nu) = (self.in_flight(), self.inputs);
        let quadratics: usize = (1..=in_flight).map(|left| self.length * triangle(left * nu)).sum();
        triangle(self.length * nu) + self.states * in_flight * nu + quadratics
    }
}

/// Entries of a symmetric matrix of `size` rows that differ.
fn triangle(size: usize) -> usize {
    size * (size + 1) / 2
}
