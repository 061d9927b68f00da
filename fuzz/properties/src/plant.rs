//! A double integrator and a law for it: what a controller of a script controls.

use crate::script::{byte, up_to};
use arbitrary::{Result, Unstructured};
use slqg::actuator::{Limits, Settings};
use slqg::controller::{Design, Memory, Sizes};
use slqg::estimator::{Cycle, Estimate, Merging, Model, Plausibility};
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::wire::can::Grid;
use slqg::{DefaultInput, Scalar};

/// Inputs of a sequence.
pub(crate) const LENGTH: usize = 3;
/// By rows: a law that stabilises the plant, though not the best one.
const LX: [f64; 6] = [-3.0, -2.5, -2.5, -2.25, -2.0, -2.0];
const M_ZERO: [f64; 6] = [0.0, 0.0, -0.5, 0.0, -0.25, -0.5];
const M_HOLD: [f64; 9] = [0.0, 0.0, 0.1, -0.5, 0.0, 0.05, -0.25, -0.5, 0.0];
const ARRIVAL: [f64; 3] = [0.5, 0.75, 0.5];

/// Everything that a [`Design`] borrows.
#[derive(Debug, Clone)]
pub(crate) struct Workshop<T: Scalar> {
    model: Model<T, 2, 1, 1>,
    plausibility: Plausibility<T, 1>,
    lx: Vec<T>,
    m: Vec<T>,
    arrival: Vec<T>,
    pub(crate) settings: Settings<T, 1>,
    merging: Merging,
    buffers: [usize; 2],
    grid: Option<Grid<T, 1>>,
}

impl<T: Scalar> Workshop<T> {
    /// A loop of the script's choice: default input, limits and rates, estimator, what is believed, grid, memory.
    pub(crate) fn read(script: &mut Unstructured<'_>) -> Result<Self> {
        let choice = byte(script)?;
        let is = |bit: u8| choice & 1 << bit != 0;
        let merging = match byte(script)? % 3 {
            0 => Merging::Single,
            1 => Merging::Imm,
            _ => Merging::Gpb2,
        };
        let of = |value: f64| SVector::<T, 1>::repeat(T::nearest(value));
        let rate = (is(2) && merging == Merging::Single).then(|| of(1.5));
        let default_input = if is(0) { DefaultInput::Hold } else { DefaultInput::Zero };
        let all = |values: &[f64]| values.iter().map(|value| T::nearest(*value)).collect();
        Ok(Self {
            model: Model {
                a: SMatrix::<f64, 2, 2>::from([[1.0, 0.0], [0.1, 1.0]]).map(T::nearest),
                b: SMatrix::<f64, 2, 1>::from([[0.005, 0.1]]).map(T::nearest),
                c: SMatrix::<f64, 1, 2>::from([[1.0], [0.0]]).map(T::nearest),
                process_noise: SMatrix::from_diagonal_element(T::nearest(1e-4)),
                measurement_noise: SMatrix::from_element(T::nearest(1e-4)),
                initial_mean: SVector::zeros(),
                initial_covariance: SMatrix::identity(),
            },
            plausibility: if is(3) { believed() } else { Plausibility::NONE },
            lx: all(&LX),
            m: if is(0) { all(&M_HOLD) } else { all(&M_ZERO) },
            arrival: all(&ARRIVAL),
            settings: Settings {
                default_input,
                limits: is(1).then(|| Limits { min: of(-4.0), max: of(2.0), rate }),
                safe: None,
            },
            merging,
            buffers: [up_to(script, 6)?.into(), up_to(script, 9)?.into()],
            grid: is(4).then(|| Grid { step: of(0.25), largest_count: 100 }),
        })
    }

    /// The same loop, but it believes every reading.
    pub(crate) fn believing(self) -> Self {
        Self { plausibility: Plausibility::NONE, ..self }
    }

    pub(crate) fn design(&self) -> Design<'_, T, 2, 1, 1> {
        let tables = Tables::check(&self.lx, &self.m, &self.arrival).expect("finite, and probabilities");
        let gains = Gains::check(LENGTH, self.settings.default_input, tables);
        let [measurement_buffer, acknowledgement_buffer] = self.buffers;
        Design {
            gains: gains.expect("tables of the right shape"),
            model: &self.model,
            actuator: self.settings,
            measurement_buffer,
            acknowledgement_buffer,
            preview: None,
            trigger: None,
            arrives_at_once: T::nearest(0.5),
            merging: self.merging,
            plausibility: &self.plausibility,
            grid: self.grid,
        }
    }
}

/// What a design believes that says nothing of it, with patience that a script can exhaust.
fn believed<T: Scalar>() -> Plausibility<T, 1> {
    Plausibility {
        gate: Some(T::nearest(100.0)),
        doubt_after: 5,
        range: Some([[T::nearest(-50.0), T::nearest(50.0)]]),
        stuck_after: [4],
        rejects_stuck: true,
        stale_after: 3,
        lost_after: 8,
    }
}

/// The memory of a controller; what it holds at first does not matter.
pub(crate) struct Room<T: Scalar> {
    cycles: Vec<Cycle<T, 1, 1>>,
    estimates: Vec<Estimate<T, 2>>,
    ages: Vec<T>,
    sent: Vec<bool>,
    inputs: Vec<SVector<T, 1>>,
}

impl<T: Scalar> Room<T> {
    pub(crate) fn new(sizes: Sizes) -> Self {
        Self {
            cycles: vec![Cycle::EMPTY; sizes.cycles],
            estimates: vec![Estimate::EMPTY; sizes.estimates],
            ages: vec![T::nearest(f64::NAN); sizes.ages],
            sent: vec![true; sizes.sent],
            inputs: vec![SVector::repeat(T::nearest(f64::NAN)); sizes.inputs],
        }
    }

    pub(crate) fn lend(&mut self) -> Memory<'_, T, 2, 1, 1> {
        let Self { cycles, estimates, ages, sent, inputs } = self;
        Memory { cycles, estimates, ages, sent, inputs }
    }
}
