//! A double integrator with its optimal law, for tests of the closed loop.

use slqg::actuator::Settings;
use slqg::controller::{Controller, Design};
use slqg::estimator::{Merging, Model, Plausibility};
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::synthesis::{Dimensions, Problem, Synthesis};
use slqg::{DefaultInput, Scalar, arrival};

/// Inputs per sequence of the law.
pub(crate) const LENGTH: usize = 4;
/// Most cycles a measurement may be late.
pub(crate) const LATE: usize = 6;
/// A controller of the double integrator.
#[allow(dead_code)]
pub(crate) type Node<'a, T> = Controller<'a, T, 2, 1, 1>;

/// Delay probabilities of the control packets; the rest to 1 is loss.
pub(crate) const DELAYS: [f64; 5] = [0.4, 0.2, 0.15, 0.1, 0.05];

const A: [f64; 4] = [1.0, 0.1, 0.0, 1.0];
const B: [f64; 2] = [0.005, 0.1];
/// Weight of the state, `Q`.
pub(crate) const WEIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.1];

/// The recursion for [`DELAYS`] at its fixed point, and the survival function of the link.
pub(crate) fn at_fixed_point<Out>(
    default_input: DefaultInput,
    look: impl FnOnce(&mut Synthesis<'_, '_, f64>, &[f64]) -> Out,
) -> Out {
    let mut survival = [0.0; LENGTH];
    arrival::survival(&DELAYS, 1.0 - DELAYS.iter().sum::<f64>(), &mut survival);
    let dimensions = Dimensions { states: 2, inputs: 1, length: LENGTH, default_input };
    let problem = Problem { dimensions, a: &A, b: &B, q: &WEIGHT, r: &[0.05], survival: &survival };
    let mut workspace = vec![0.0; dimensions.workspace_len()];
    let mut synthesis = Synthesis::new(problem, &mut workspace).expect("slices of the right shape");
    while synthesis.optimal_step() > 1e-12 {}
    look(&mut synthesis, &survival)
}

/// The design of a closed loop, with everything that [`Design`] borrows.
pub(crate) struct Workshop<T> {
    pub(crate) model: Model<T, 2, 1, 1>,
    pub(crate) settings: Settings<T, 1>,
    lx: Vec<T>,
    m: Vec<T>,
    arrival: Vec<T>,
}

impl<T: Scalar> Workshop<T> {
    /// A double integrator with the optimal law for [`DELAYS`].
    pub(crate) fn double_integrator(settings: Settings<T, 1>) -> Self {
        let (gains, columns, table) = at_fixed_point(settings.default_input, |synthesis, survival| {
            let mut table = [0.0; arrival::table_len(LENGTH)];
            arrival::fill_table(survival, &mut table);
            (synthesis.gains().to_vec(), synthesis.dimensions().gain_columns(), table)
        });
        let rows = || gains.chunks(columns);
        let nearest = |value: &f64| T::nearest(*value);
        Self {
            model: Model {
                a: SMatrix::<f64, 2, 2>::from_row_slice(&A).map(T::nearest),
                b: SMatrix::<f64, 2, 1>::from_row_slice(&B).map(T::nearest),
                c: SMatrix::<f64, 1, 2>::new(1.0, 0.0).map(T::nearest),
                process_noise: SMatrix::from_diagonal_element(T::nearest(1e-4)),
                measurement_noise: SMatrix::from_element(T::nearest(1e-4)),
                initial_mean: SVector::zeros(),
                initial_covariance: SMatrix::identity(),
            },
            settings,
            lx: rows().flat_map(|row| &row[..2]).map(nearest).collect(),
            m: rows().flat_map(|row| &row[2..]).map(nearest).collect(),
            arrival: table.iter().map(nearest).collect(),
        }
    }

    pub(crate) fn design(&self) -> Design<'_, T, 2, 1, 1> {
        let tables = Tables::check(&self.lx, &self.m, &self.arrival).expect("finite, and probabilities");
        Design {
            gains: Gains::check(LENGTH, self.settings.default_input, tables)
                .expect("tables of the right shape"),
            model: &self.model,
            actuator: self.settings,
            measurement_buffer: LATE,
            acknowledgement_buffer: 1,
            preview: None,
            trigger: None,
            arrives_at_once: T::nearest(DELAYS[0]),
            merging: Merging::Single,
            plausibility: &Plausibility::NONE,
            grid: None,
        }
    }
}
