//! The continuous plant that a discrete one samples, where there is a real one.

use nalgebra::DMatrix;

/// Distance from the identity at which the series takes over from square roots.
const NEAR: f64 = 0.25;
/// Square roots at most; each halves the logarithm.
const ROOTS: usize = 64;
/// Steps of Newton's iteration for one root at most.
const NEWTON: usize = 100;
/// Relative difference at which that iteration has ended.
const SETTLED: f64 = 1e-14;
/// Relative difference between the matrix and the exponential of its logarithm that is accepted.
const RESIDUAL: f64 = 1e-9;
/// Nodes and weights of Gauss and Legendre on [-1, 1], the positive half of eight.
const QUADRATURE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// (a, b) of `dx/dt = a x + b u` whose zero-order hold over `sample_time` is (`a`, `b`): the principal logarithm of
/// `[A B; 0 I]`. `None`: an eigenvalue of A is 0 or negative, so that there is no real one, or rounding does not let it
/// be found.
pub(super) fn continuous(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    sample_time: f64,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let (nx, nu) = b.shape();
    let mut transition = DMatrix::identity(nx + nu, nx + nu);
    transition.view_mut((0, 0), (nx, nx)).copy_from(a);
    transition.view_mut((0, nx), (nx, nu)).copy_from(b);
    let generator = logarithm(&transition)?;
    let difference = (generator.exp() - &transition).amax();
    let part = |from: usize, width: usize| generator.view((0, from), (nx, width)) / sample_time;
    (difference <= RESIDUAL * transition.amax()).then(|| (part(0, nx), part(nx, nu)))
}

/// By inverse scaling and squaring: roots until the matrix is near the identity, then the integral
/// `log(I + X) = int_0^1 X (I + s X)^-1 ds` by Gauss and Legendre.
fn logarithm(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let identity = DMatrix::identity(matrix.nrows(), matrix.nrows());
    let mut root = matrix.clone();
    let mut factor = 1.0;
    for _ in 0..ROOTS {
        let beyond = &root - &identity;
        if beyond.norm() <= NEAR {
            let mut sum = DMatrix::zeros(matrix.nrows(), matrix.nrows());
            for (node, weight) in QUADRATURE.into_iter().flat_map(|(x, w)| [(x, w), (-x, w)]) {
                let part = (&identity + &beyond * (0.5 * (1.0 + node))).lu().solve(&beyond)?;
                sum += part * (0.5 * weight);
            }
            return Some(sum * factor);
        }
        root = square_root(&root)?;
        factor *= 2.0;
    }
    None
}

/// The principal root, by the product form of Denman and Beavers' iteration.
fn square_root(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let identity = DMatrix::<f64>::identity(matrix.nrows(), matrix.nrows());
    let (mut product, mut root) = (matrix.clone(), matrix.clone());
    for _ in 0..NEWTON {
        let inverse = product.clone().try_inverse()?;
        root = &root * (&identity + &inverse) * 0.5;
        product = (&identity + (&product + inverse) * 0.5) * 0.5;
        let rest = (&product - &identity).amax();
        if !rest.is_finite() {
            return None;
        }
        if rest <= SETTLED * matrix.nrows() as f64 {
            return Some(root);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discretise::zero_order_hold;

    #[test]
    fn a_sampled_plant_is_found_again() {
        let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, -4.0, -0.2, 1.0, 0.0, 0.0, 0.3]);
        let b = DMatrix::from_row_slice(3, 2, &[0.0, 0.5, 1.0, 0.0, -2.0, 0.1]);
        let (discrete_a, discrete_b) = zero_order_hold(&a, &b, 0.7).expect("in range");
        let (found_a, found_b) = continuous(&discrete_a, &discrete_b, 0.7).expect("it is sampled");
        assert!((found_a - a).amax() < 1e-10 && (found_b - b).amax() < 1e-10);
    }

    #[test]
    fn a_negative_or_lost_mode_has_no_real_continuous_plant() {
        let b = DMatrix::from_element(2, 1, 1.0);
        for modes in [[0.5, -0.5], [0.5, 0.0]] {
            let a = DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&modes));
            assert_eq!(continuous(&a, &b, 1.0), None, "{modes:?}");
        }
    }
}
