//! From which states inputs within their limits lead an unstable plant back.
//!
//! For an eigenvalue `lambda` of `A` with `|lambda| > 1` and its left eigenvector `w`, `z = w'x` follows
//! `z+ = lambda z + w'B u + w'(noise)`. Where `|z| > max |w'Bu| / (|lambda| - 1)` over the inputs allowed, `|z|` grows whatever is
//! applied: without noise the state never comes back. States within the bound may be lost all the same, and are beyond it a few
//! cycles later.

use crate::plant::padded;
use gain_gen::design::Plant;
use nalgebra::{Complex, DMatrix, DVector, SVector};

/// Modes that grow more slowly than this are not told from the limit of stability.
const MARGIN: f64 = 1e-9;

/// The bounds of all modes that grow, for inputs with limits.
#[derive(Debug, Clone)]
pub struct Recovery<const NX: usize> {
    modes: Vec<GrowingMode<NX>>,
}

#[derive(Debug, Clone)]
struct GrowingMode<const NX: usize> {
    /// `w`, real and imaginary part.
    real: SVector<f64, NX>,
    imaginary: SVector<f64, NX>,
    /// `|z|` beyond which it grows whatever is applied.
    farthest: f64,
}

impl<const NX: usize> Recovery<NX> {
    /// That of the plant under `limits`, a pair for each input; without them, or without a mode that grows, no state is beyond it.
    pub fn of(plant: &Plant, limits: Option<&[(f64, f64)]>) -> Self {
        let (a, b) = (&plant.a, &plant.b);
        let Some(limits) = limits else { return Self { modes: Vec::new() } };
        let growing = a.complex_eigenvalues();
        let growing = growing.iter().filter(|value| value.norm() > 1.0 + MARGIN);
        let modes = growing.filter_map(|&eigenvalue| {
            let w = left_eigenvector(a, eigenvalue)?;
            let push = limits.iter().enumerate().map(|(input, (least, greatest))| {
                let effect: Complex<f64> = w.iter().zip(&b.column(input)).map(|(w, b)| w * *b).sum();
                effect.norm() * greatest.max(-least)
            });
            let farthest = push.sum::<f64>() / (eigenvalue.norm() - 1.0);
            let part = |of: fn(&Complex<f64>) -> f64| {
                let column = DMatrix::from_iterator(w.len(), 1, w.iter().map(of));
                padded::<NX, 1>(&column)
            };
            Some(GrowingMode { real: part(|w| w.re), imaginary: part(|w| w.im), farthest })
        });
        Self { modes: modes.collect() }
    }

    /// Whether no inputs within the limits lead back from `state`. What is not a number is.
    pub fn is_beyond(&self, state: &SVector<f64, NX>) -> bool {
        let beyond = |mode: &GrowingMode<NX>| {
            let size = mode.real.dot(state).hypot(mode.imaginary.dot(state));
            size.is_nan() || size > mode.farthest
        };
        self.modes.iter().any(beyond)
    }
}

/// `w` with `w'A = lambda w'`, of unit length; `None` if the iteration for it does not converge.
fn left_eigenvector(a: &DMatrix<f64>, eigenvalue: Complex<f64>) -> Option<DVector<Complex<f64>>> {
    let size = a.nrows();
    let shifted = a.transpose().map(Complex::from) - DMatrix::from_diagonal_element(size, size, eigenvalue);
    let rows = shifted.try_svd(false, true, f64::EPSILON, 0)?;
    let least = rows.singular_values.imin();
    Some(rows.v_t?.row(least).adjoint())
}

#[cfg(test)]
mod tests {
    use super::*;
    use gain_gen::design::Design;

    fn recovery(a: &str, limits: &str) -> Recovery<2> {
        let text = format!(
            "name = \"mode\"\n[plant]\nsample_time = 1\ndiscrete = {{ a = {a}, b = [[1], [0.5]] }}\n\
             c = [[1, 0], [0, 1]]\nprocess_noise = [[1, 0], [0, 1]]\nmeasurement_noise = [[1, 0], [0, 1]]\n\
             initial_mean = [0, 0]\ninitial_covariance = [[1, 0], [0, 1]]\n[cost]\nq = [[1, 0], [0, 1]]\nr = [[1]]\n\
             [network]\ncontroller_to_actuator.delays = [1]\nsensor_to_controller.delays = [1]\n\
             [controller]\nsequence_length = 1\n{limits}"
        );
        let design = Design::parse(&text, "mode.toml").expect("a design");
        Recovery::of(&design.plant, design.controller.input_limits.as_deref())
    }

    #[test]
    fn a_real_mode_is_lost_where_its_growth_exceeds_the_largest_input() {
        // z = x1, z+ = 1.25 z + u with |u| <= 2: beyond 8.
        let recovery = recovery("[[1.25, 0], [0, 0.5]]", "input_limits = [[-1, 2]]");
        assert!(!recovery.is_beyond(&SVector::from([7.99, 1e6])));
        assert!(recovery.is_beyond(&SVector::from([8.01, 0.0])));
        assert!(recovery.is_beyond(&SVector::from([f64::NAN, 0.0])));
    }

    #[test]
    fn a_rotating_mode_is_lost_where_no_sequence_of_inputs_stops_its_growth() {
        let recovery = recovery("[[0.9, 0.8], [-0.8, 0.9]]", "input_limits = [[-1, 1]]");
        let modulus = 0.9_f64.hypot(0.8);
        let farthest = 1.0_f64.hypot(0.5) / (modulus - 1.0);
        for angle in [0.0_f64, 1.0, 2.0, 3.0] {
            let at = |radius: f64| SVector::from([radius * angle.cos(), radius * angle.sin()]);
            assert!(!recovery.is_beyond(&at(0.999 * farthest)));
            assert!(recovery.is_beyond(&at(1.001 * farthest)));
        }
    }

    #[test]
    fn nothing_is_lost_without_limits_or_by_a_plant_that_comes_back() {
        let far = SVector::from([1e9, 1e9]);
        assert!(!recovery("[[1.25, 0], [0, 0.5]]", "").is_beyond(&far));
        assert!(!recovery("[[0.9, 0], [0, 0.5]]", "input_limits = [[-1, 1]]").is_beyond(&far));
    }
}
