//! The tables of a nominal controller that predicts its own loop and sends the predicted inputs. Thesis 2.4.2.
//!
//! Whatever is believed of the inputs in flight, the prediction is linear in the estimate, in `vbar` and in the reference,
//! so it is a law as the core computes it. The nominal controller itself is LQG as it is taught, for the plant alone.

use super::{Contender, ContenderError, Deadband, Kind, steady::without_network};
use gain_gen::{
    design::{Design, Goal, Preview},
    solve::{Law, LoopProblem, Method, PreviewGains, solve},
};
use nalgebra::DMatrix;

/// The nominal controller: what it makes of a state, and of the reference samples to come.
struct Nominal {
    /// `L`, `nu x nx`: `u = L x`. Thesis (2.1).
    feedback: DMatrix<f64>,
    preview: Option<PreviewGains>,
}

impl Nominal {
    fn new(problem: &LoopProblem, design: &Design) -> Result<Option<Self>, ContenderError> {
        let problem = without_network(problem);
        let solution = solve(&problem, Method::InFlight);
        if !solution.is_stabilising() {
            return Ok(None);
        }
        let preview = PreviewGains::over(&problem, design, &solution).transpose()?;
        Ok(Some(Self { feedback: solution.law.lx, preview }))
    }
}

/// What is predicted: `u_m = L_m x_m + sum_t Gamma_t z_{k+m+t}`, `x_{m+1} = A x_m + B (w_m u_m + (1 - w_m) vbar_m)`.
pub(super) struct Prediction<'p, L, W> {
    /// Plant and sequences.
    pub(super) problem: &'p LoopProblem,
    /// `L_m`, `nu x nx`.
    pub(super) feedback: L,
    /// `w_m`: to what part the input applied `m` cycles ahead is taken to be this sequence's. For the rest it is what is
    /// expected of those in flight.
    pub(super) own_part: W,
    /// The nominal controller's `Gamma_t`, `nu x (T nz)`.
    pub(super) preview: Option<&'p PreviewGains>,
    /// Most samples of the reference to come that may be known.
    pub(super) most_samples: usize,
}

impl<L: Fn(usize) -> DMatrix<f64>, W: Fn(usize) -> f64> Prediction<'_, L, W> {
    /// The law that sends `u_0, .., u_{N-1}`, and what it makes of the reference.
    pub(super) fn law(&self) -> (Law, Option<PreviewGains>) {
        let LoopProblem { a, b, length, default_input, .. } = self.problem;
        let (states, inputs) = b.shape();
        let expected = default_input.in_flight(*length);
        let known = self.preview.map_or(0, |preview| (preview.samples + length - 1).min(self.most_samples));
        let outputs = self.preview.map_or(0, |preview| preview.sequence.ncols() / preview.samples);
        // Columns: the estimate, the expected inputs, the samples known.
        let samples_from = states + expected * inputs;
        let columns = samples_from + known * outputs;
        let mut state = DMatrix::identity(states, columns);
        let mut sequence = DMatrix::zeros(length * inputs, columns);
        for step in 0..*length {
            let mut input = (self.feedback)(step) * &state;
            if let Some(preview) = self.preview {
                for sample in 0..preview.samples {
                    // What follows the last sample known is held to be equal to it.
                    let place = samples_from + (step + sample).min(known - 1) * outputs;
                    let mut columns = input.columns_mut(place, outputs);
                    columns += preview.sequence.columns(sample * outputs, outputs);
                }
            }
            sequence.rows_mut(step * inputs, inputs).copy_from(&input);
            let own = (self.own_part)(step);
            let mut applied = input * own;
            if step < expected {
                let mut in_flight = applied.columns_mut(states + step * inputs, inputs);
                in_flight += DMatrix::identity(inputs, inputs) * (1.0 - own);
            }
            state = a * state + b * applied;
        }
        let law = Law {
            length: *length,
            default_input: *default_input,
            lx: sequence.columns(0, states).into_owned(),
            m: sequence.columns(states, expected * inputs).into_owned(),
            arrival: self.problem.arrival_table(),
        };
        let preview = self.preview.map(|preview| PreviewGains {
            samples: known,
            sequence: sequence.columns(samples_from, known * outputs).into_owned(),
            displaced: DMatrix::zeros(expected * inputs, known * outputs),
            tail: preview.tail,
            standing_cost: None,
        });
        (law, preview)
    }
}

/// Most samples of the reference to come that the design lets a controller know.
fn most_samples(design: &Design) -> usize {
    match design.tracking.as_ref().map(|tracking| &tracking.goal) {
        Some(Goal::SetPoint(_)) => 1,
        Some(Goal::Trajectory(trajectory)) => match trajectory.preview {
            Preview::Cycles(samples) => samples,
            Preview::Auto { .. } => usize::MAX,
        },
        None => 0,
    }
}

impl Contender {
    /// Gives it the predicted inputs of the nominal controller.
    pub(super) fn predict_loop(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
        steps: usize,
    ) -> Result<(), ContenderError> {
        self.must_see(design)?;
        let Some(nominal) = Nominal::new(problem, design)? else { return Err(self.unstable()) };
        let link = &problem.link;
        let expects = self.kind == Kind::ExpectedInput;
        let prediction = Prediction {
            problem,
            feedback: |_| nominal.feedback.clone(),
            // The nominal prediction knows of no network: its inputs are applied when they are meant to be.
            own_part: |ahead| if expects { link.arrival(ahead) } else { 1.0 },
            preview: nominal.preview.as_ref(),
            most_samples: most_samples(design),
        };
        let (law, preview) = prediction.law();
        self.laws = vec![law];
        self.preview = preview;
        self.learn_reference(design, steps)?;
        if self.kind == Kind::Deadband {
            self.deadband = Some(Deadband::over(&self.actuator_link));
        }
        Ok(())
    }
}
