//! What the claims in `tests/` share: reference cases from an independent oracle, and problems made from them; plants with right
//! answers ([`accuracy`]); and [`page`]s that quote figures.
//!
//! The claims themselves are in `tests/tests/`, one file per claim and named after it.

pub mod accuracy;
pub mod drawn;
pub mod page;

use gain_gen::{design::DelayDistribution, solve::LoopProblem};
use nalgebra::DMatrix;
use serde::Deserialize;
use slqg::DefaultInput;

/// One case of `tests/data`, computed by an independent implementation of the coupled recursion.
#[derive(Debug, Deserialize)]
pub struct ReferenceCase {
    /// Name of the case.
    pub name: String,
    /// State transition and input matrices.
    pub plant: ReferencePlant,
    /// State and input weights.
    pub cost: ReferenceCost,
    /// Process noise covariance, `W`.
    pub process_noise: Rows,
    /// Delay probabilities of the actuator link.
    pub delay_pmf: Vec<f64>,
    /// Inputs per sequence, `N`.
    pub sequence_length: usize,
    /// `zero` or `hold`.
    pub default_input: String,
    /// Transition matrix of the age.
    pub transition_matrix: Rows,
    /// `L(i)` for `i = 0..=N`, thesis (3.31).
    pub gains: Vec<Rows>,
    /// State block of `K(i)` for `i = 0..=N`, thesis (3.32).
    pub cost_to_go_xx: Vec<Rows>,
    /// Mean-square rate of the closed loop.
    pub spectral_radius: f64,
    /// Long-run average cost per step with the state known.
    pub lrac_control_cost: f64,
}

/// A matrix as rows.
pub type Rows = Vec<Vec<f64>>;

/// State transition and input matrices of a case.
#[derive(Debug, Deserialize)]
pub struct ReferencePlant {
    /// `A`.
    pub a: Rows,
    /// `B`.
    pub b: Rows,
}

/// Weights of a case.
#[derive(Debug, Deserialize)]
pub struct ReferenceCost {
    /// `Q`.
    pub q: Rows,
    /// `R`.
    pub r: Rows,
}

/// The matrix with these rows.
pub fn matrix(rows: &Rows) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows[0].len(), |row, column| rows[row][column])
}

/// Largest entry of the difference, relative to the largest entry of `expected`.
pub fn relative_difference(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
    assert_eq!(found.shape(), expected.shape());
    (found - expected).amax() / expected.amax().max(f64::MIN_POSITIVE)
}

impl ReferenceCase {
    /// Every case of `tests/data`.
    pub fn all() -> Vec<Self> {
        [
            include_str!("../data/critical_n3.json"),
            include_str!("../data/critical_n4.json"),
            include_str!("../data/critical_hold_n3.json"),
            include_str!("../data/double_integrator_good_n3.json"),
            include_str!("../data/double_integrator_bad_n5.json"),
            include_str!("../data/pendulum_good_n4.json"),
        ]
        .into_iter()
        .map(|text| serde_json::from_str(text).expect("a reference case"))
        .collect()
    }

    /// The problem of the case.
    pub fn problem(&self) -> LoopProblem {
        LoopProblem {
            a: matrix(&self.plant.a),
            b: matrix(&self.plant.b),
            q: matrix(&self.cost.q),
            r: matrix(&self.cost.r),
            link: DelayDistribution::new(self.delay_pmf.clone()).expect("a distribution"),
            length: self.sequence_length,
            default_input: if self.default_input == "hold" { DefaultInput::Hold } else { DefaultInput::Zero },
        }
    }
}
