//! Exact discretisation of a continuous plant. Reading and checking the plant is in [`crate::design`].

use nalgebra::DMatrix;

/// Largest entry of `a` times the sample time that is accepted.
const LARGEST: f64 = 1e15;

/// (A, B) of `x+ = A x + B u` for `dx/dt = a x + b u` with u held over each step (zero-order hold).
///
/// `a`: nx x nx, `b`: nx x nu, `sample_time` in the time unit of `a`. Both results come out of one matrix
/// exponential, `exp([a b; 0 0] sample_time) = [A B; 0 I]`, which also covers a singular `a`.
/// `None`: the result exceeds the range of f64, or `a` times `sample_time` has an entry beyond 1e15, of which
/// no digit would be right.
///
/// # Panics
/// If `a` is not square or `b` has another number of rows.
pub fn zero_order_hold(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    sample_time: f64,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let (nx, nu) = b.shape();
    assert_eq!(a.shape(), (nx, nx), "a must be square with as many rows as b");
    let mut generator = DMatrix::zeros(nx + nu, nx + nu);
    generator.view_mut((0, 0), (nx, nx)).copy_from(a);
    // B is linear in b: with b scaled to 1, the unit of an input costs no accuracy in A.
    let unit = if b.amax() > 0.0 { b.amax() } else { 1.0 };
    generator.view_mut((0, nx), (nx, nu)).copy_from(&(b / unit));
    generator *= sample_time;
    // The number of squarings follows from the size; beyond all sense it would not end.
    if generator.amax() > LARGEST {
        return None;
    }
    let transition = generator.exp();
    let held: DMatrix<f64> = transition.view((0, 0), (nx, nx)).into();
    let driven = transition.view((0, nx), (nx, nu)) * unit;
    let in_range = held.iter().chain(driven.iter()).all(|entry| entry.is_finite());
    in_range.then_some((held, driven))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(x: &DMatrix<f64>, y: &DMatrix<f64>) -> f64 {
        (x - y).amax()
    }

    #[test]
    fn double_integrator_has_its_textbook_form() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        for t in [1e-4, 0.1, 1.0, 25.0] {
            let (ad, bd) = zero_order_hold(&a, &b, t).unwrap();
            assert!(
                difference(&ad, &DMatrix::from_row_slice(2, 2, &[1.0, t, 0.0, 1.0])) < 1e-14 * t.max(1.0)
            );
            assert!(
                difference(&bd, &DMatrix::from_row_slice(2, 1, &[t * t / 2.0, t])) < 1e-14 * (t * t).max(1.0)
            );
        }
    }

    #[test]
    fn a_lag_approaches_its_input_exponentially() {
        for (pole, t) in [(-3.0, 0.5), (-4000.0, 0.01), (0.7, 2.0)] {
            let (ad, bd) =
                zero_order_hold(&DMatrix::from_element(1, 1, pole), &DMatrix::from_element(1, 1, 2.0), t)
                    .unwrap();
            let decay = (pole * t).exp();
            assert!((ad[0] - decay).abs() < 1e-14 * decay.max(1.0), "{pole}: {}", ad[0] - decay);
            assert!((bd[0] - 2.0 * (decay - 1.0) / pole).abs() < 1e-14 * decay.max(1.0));
        }
    }

    #[test]
    fn an_oscillator_turns_by_its_angle() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 7.0, -7.0, 0.0]);
        let (ad, _) = zero_order_hold(&a, &DMatrix::zeros(2, 1), 0.3).unwrap();
        let (sin, cos) = 2.1_f64.sin_cos();
        assert!(difference(&ad, &DMatrix::from_row_slice(2, 2, &[cos, sin, -sin, cos])) < 1e-14);
    }

    #[test]
    fn the_unit_of_the_input_does_not_matter() {
        let a = DMatrix::from_row_slice(2, 2, &[-0.3, 1.0, 0.2, -2.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.5, 1.0]);
        let (expected_a, expected_b) = zero_order_hold(&a, &b, 0.1).unwrap();
        for unit in [1e-200, 1e200] {
            let (ad, bd) = zero_order_hold(&a, &(&b * unit), 0.1).unwrap();
            assert_eq!(ad, expected_a);
            assert!(difference(&(bd / unit), &expected_b) < 1e-15);
        }
    }

    #[test]
    fn growth_out_of_range_is_refused() {
        for pole in [800.0, 1e60, 1e300, -1e60] {
            let a = DMatrix::from_element(1, 1, pole);
            assert_eq!(zero_order_hold(&a, &DMatrix::from_element(1, 1, 1.0), 1.0), None, "{pole}");
        }
    }

    #[test]
    fn two_steps_are_one_of_double_length() {
        for scale in [1e-3, 0.1, 1.0, 10.0] {
            let a = DMatrix::from_fn(4, 4, |i, j| ((3 * i + 5 * j) % 7) as f64 / 7.0 - 0.5) * scale;
            let b = DMatrix::from_fn(4, 2, |i, j| 1.0 - (i * j) as f64 / 5.0);
            let (a1, b1) = zero_order_hold(&a, &b, 0.5).unwrap();
            let (a2, b2) = zero_order_hold(&a, &b, 1.0).unwrap();
            assert!(difference(&a2, &(&a1 * &a1)) < 1e-12 * a2.amax().max(1.0), "{scale}");
            assert!(difference(&b2, &(&a1 * &b1 + &b1)) < 1e-12 * b2.amax().max(1.0), "{scale}");
        }
    }
}
