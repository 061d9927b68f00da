//! `[plant]`: the model, its noise and its start, always in discrete time after reading.

use super::document::{Field, Section, counted};
use super::symmetric::{Definiteness, symmetric};
use super::{DesignError, modes};
use crate::discretise::zero_order_hold;
use nalgebra::{Complex, DMatrix, DVector};

/// Most states of a plant.
pub const MOST_STATES: usize = 100;
/// Most inputs of a plant.
pub const MOST_INPUTS: usize = 8;

/// `x+ = A x + B u + w`, `y = C x + v` with w ~ N(0, W), v ~ N(0, V), all independent; nx states, nu inputs,
/// ny outputs. (A, B) is stabilisable and (A, C) detectable.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Length of a step, in seconds; above 0.
    pub sample_time: f64,
    /// A: nx x nx, over one step.
    pub a: DMatrix<f64>,
    /// B: nx x nu, for an input that is held over the step.
    pub b: DMatrix<f64>,
    /// C: ny x nx.
    pub c: DMatrix<f64>,
    /// W: nx x nx, covariance of w per step; symmetric positive semidefinite.
    pub process_noise: DMatrix<f64>,
    /// V: ny x ny, covariance of v; symmetric positive definite.
    pub measurement_noise: DMatrix<f64>,
    /// Mean of the first state: nx.
    pub initial_mean: DVector<f64>,
    /// Covariance of the first state: nx x nx, symmetric positive semidefinite.
    pub initial_covariance: DMatrix<f64>,
    /// (a, b) of `dx/dt = a x + b u` in 1/s, nx x nx and nx x nu, if the design gives the plant so.
    pub continuous: Option<(DMatrix<f64>, DMatrix<f64>)>,
}

impl Plant {
    /// nx, the number of states.
    pub fn states(&self) -> usize {
        self.a.nrows()
    }

    /// nu, the number of inputs.
    pub fn inputs(&self) -> usize {
        self.b.ncols()
    }

    /// ny, the number of outputs.
    pub fn outputs(&self) -> usize {
        self.c.nrows()
    }

    /// Also returns the modes of A that do not decay, for checks of the cost.
    pub(super) fn read(root: &Section<'_>) -> Result<(Self, Vec<Complex<f64>>), DesignError> {
        let plant = root.required("plant", "a table with the model of the plant")?.section(&[
            "sample_time",
            "continuous",
            "discrete",
            "c",
            "process_noise",
            "measurement_noise",
            "initial_mean",
            "initial_covariance",
        ])?;
        let field = plant.required("sample_time", "a number of seconds above 0")?;
        let sample_time = field.number()?;
        if sample_time <= 0.0 {
            return Err(field.reject(format!("found the number {sample_time}")));
        }
        let Dynamics { a, b, continuous, unstable } = dynamics(&plant, sample_time)?;
        let states = a.nrows();
        let size = counted(states, "state");

        let field = plant.required("c", "C, a matrix with one row per output and one column per state")?;
        let c = field.matrix()?;
        let outputs = c.nrows();
        if c.ncols() != states {
            let found = format!("found a {outputs}x{} matrix, but the plant has {size}", c.ncols());
            return Err(field.reject_with(found, format!("give a {outputs}x{states} matrix")));
        }
        if let Some(lambda) = modes::unreached(&a.transpose(), &c.transpose(), &unstable) {
            let found = format!("found outputs that do not see the unstable mode {}", modes::spoken(lambda));
            let allowed = "measure a state that shows this mode: (A, C) must be detectable";
            return Err(field.reject_with(found, allowed.into()));
        }

        let semidefinite = |key: &str, meaning: &'static str| {
            let field = plant.required(key, meaning)?;
            symmetric(&field, states, &format!("the plant has {size}"), Definiteness::Semidefinite, "")
        };
        let process_noise = semidefinite("process_noise", "W, the covariance per step, nx x nx")?;
        let measurement_noise = symmetric(
            &plant.required("measurement_noise", "V, the covariance of the measurement noise, ny x ny")?,
            outputs,
            &format!("the plant has {}", counted(outputs, "output")),
            Definiteness::Positive,
            "give a perfect sensor a small positive variance",
        )?;
        let initial_mean = {
            let field = plant.required("initial_mean", "a list of numbers, one per state")?;
            let mean = field.numbers()?;
            if mean.len() != states {
                let found = format!("found {}, but the plant has {size}", counted(mean.len(), "number"));
                return Err(field.reject_with(found, format!("give {}", counted(states, "number"))));
            }
            DVector::from_vec(mean)
        };
        let initial_covariance =
            semidefinite("initial_covariance", "the covariance of the first state, nx x nx")?;
        let read = Plant {
            sample_time,
            a,
            b,
            c,
            process_noise,
            measurement_noise,
            initial_mean,
            initial_covariance,
            continuous,
        };
        Ok((read, unstable))
    }
}

/// The dynamics over one step.
struct Dynamics {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    /// As the design gives it.
    continuous: Option<(DMatrix<f64>, DMatrix<f64>)>,
    /// Modes of A that do not decay.
    unstable: Vec<Complex<f64>>,
}

/// From whichever of `continuous` and `discrete` is given.
fn dynamics(plant: &Section<'_>, sample_time: f64) -> Result<Dynamics, DesignError> {
    let meaning = "a table { a = [[..]], b = [[..]] }";
    let (field, is_continuous) =
        match (plant.optional("continuous", meaning), plant.optional("discrete", meaning)) {
            (Some(field), None) => (field, true),
            (None, Some(field)) => (field, false),
            (Some(_), Some(field)) => {
                let found = "found beside plant.continuous".into();
                return Err(field.reject_with(found, "give one of them: either describes the plant".into()));
            }
            (None, None) => {
                let found = "found neither `continuous` nor `discrete`".into();
                let allowed = "give one of them: { a = [[..]], b = [[..]] }".into();
                return Err(plant.reject(plant.key(), found, allowed));
            }
        };
    let section = field.section(&["a", "b"])?;
    let a_field = section.required("a", "A, a square matrix with one row per state")?;
    let b_field = section.required("b", "B, a matrix with one row per state and one column per input")?;
    let (a, b) = (square(&a_field)?, b_field.matrix()?);
    let (states, inputs) = (a.nrows(), b.ncols());
    if b.nrows() != states {
        let found =
            format!("found a {}x{inputs} matrix, but the plant has {}", b.nrows(), counted(states, "state"));
        return Err(b_field.reject_with(found, format!("give a {states}x{inputs} matrix")));
    }
    let continuous = is_continuous.then(|| (a.clone(), b.clone()));
    if states > MOST_STATES {
        return Err(a_field.reject_with(
            format!("found {states} states"),
            format!("gains are found for up to {MOST_STATES}: reduce the model"),
        ));
    }
    if inputs > MOST_INPUTS {
        return Err(b_field.reject_with(
            format!("found {inputs} inputs"),
            format!("gains are found for up to {MOST_INPUTS}: leave out or combine inputs"),
        ));
    }
    let (a, b) = if is_continuous {
        zero_order_hold(&a, &b, sample_time).ok_or_else(|| {
            let found = format!("found a plant that grows out of range within {sample_time} s");
            a_field.reject_with(found, "check the units of `a` and of plant.sample_time".into())
        })?
    } else {
        (a, b)
    };
    let Some(unstable) = modes::unstable_eigenvalues(&a) else {
        let found = "found a matrix whose eigenvalues cannot be computed".into();
        return Err(a_field.reject_with(found, "check the units: scale the states alike".into()));
    };
    if let Some(lambda) = modes::unreached(&a, &b, &unstable) {
        let found = format!("found inputs that do not reach the unstable mode {}", modes::spoken(lambda));
        let mut allowed = "give an input that moves this mode: (A, B) must be stabilisable".to_string();
        if is_continuous {
            allowed.push_str(" at this sample time");
        }
        return Err(b_field.reject_with(found, allowed));
    }
    Ok(Dynamics { a, b, continuous, unstable })
}

fn square(field: &Field<'_>) -> Result<DMatrix<f64>, DesignError> {
    let matrix = field.matrix()?;
    let (rows, columns) = matrix.shape();
    if rows == columns {
        return Ok(matrix);
    }
    Err(field.reject(format!("found a {rows}x{columns} matrix")))
}
