//! Eigenvalues that do not decay, with how uncertain they are, and the directions that belong to them.
//!
//! From a unitary triangular form `A = Q T Q*`. A cluster of eigenvalues is brought to the front by rotations that swap
//! neighbours; then the first columns of `Q` span its invariant subspace, and with `T11 R - R T22 = T12` the projector onto
//! it along the rest has norm `sqrt(1 + |R|^2)`: the factor by which the mean of the cluster moves when `A` does (Bai,
//! Demmel, McKenney 1993). Eigenvalues that cannot be told apart are one cluster, such as those of a defective block, whose
//! computed values lie on a circle far larger than rounding; their mean is as certain as a simple eigenvalue.

use nalgebra::{Complex, DMatrix, Schur};

type Matrix = DMatrix<Complex<f64>>;

/// Moduli from here on are looked at: below, an eigenvalue decays whatever rounding does.
const LEAST: f64 = 0.99;
/// Sweeps of the QR iteration before another start is tried.
const SWEEPS: usize = 10_000;

/// A cluster of eigenvalues that cannot be told apart.
#[derive(Debug, Clone)]
pub(super) struct Mode {
    /// Their mean.
    pub value: Complex<f64>,
    /// The largest modulus of those computed.
    pub largest: f64,
    /// Distance within which the exact mean lies.
    pub uncertainty: f64,
    /// Orthonormal basis of the eigenvectors, nx x any: one column for each Jordan block.
    pub vectors: Matrix,
    /// Distance, relative to their length, within which the exact eigenvectors lie.
    pub vector_uncertainty: f64,
}

/// The modes of `a`, in balanced coordinates, that may not decay, if each entry of `a` is known up to `rounding` parts of
/// the size of `a`. `None` if the iteration for eigenvalues does not converge.
pub(super) fn lasting_modes(a: &DMatrix<f64>, rounding: f64) -> Option<Vec<Mode>> {
    let form = Triangular::of(a)?;
    let noise = rounding * form.t.norm();
    let lasting = (0..a.nrows()).filter(|&at| form.t[(at, at)].norm() >= LEAST);
    let reach = |members: &[usize]| noise * form.led_by(members).condition(members.len());
    let mut clusters: Vec<(Vec<usize>, f64)> = lasting.map(|at| (vec![at], reach(&[at]))).collect();
    // The nearest first: of eigenvalues that all but coincide one alone may be anywhere, and both together are not.
    while let Some((at, with)) = nearest_in_doubt(&clusters, &form.t) {
        let (mut members, _) = clusters.remove(with);
        members.extend(&clusters[at].0);
        clusters[at] = (members.clone(), reach(&members));
    }
    Some(
        clusters.iter().map(|(members, _)| form.led_by(members).leading_mode(members.len(), noise)).collect(),
    )
}

/// Orthonormal basis, nx x `count`, of the invariant subspace of the `count` eigenvalues of `a` of largest modulus, which no
/// conjugate pair is on both sides of. `None` if the iteration for eigenvalues does not converge.
pub(super) fn growing_part(a: &DMatrix<f64>, count: usize) -> Option<DMatrix<f64>> {
    let form = Triangular::of(a)?;
    let mut places: Vec<usize> = (0..a.nrows()).collect();
    places.sort_by(|&i, &j| form.t[(j, j)].norm().total_cmp(&form.t[(i, i)].norm()));
    let led = form.led_by(&places[..count]);
    let complex = led.q.columns(0, count);
    // Real and imaginary parts span the same subspace, and the projector onto it is real.
    let parts = DMatrix::from_fn(a.nrows(), 2 * count, |i, j| {
        if j < count { complex[(i, j)].re } else { complex[(i, j - count)].im }
    });
    let parts = parts.svd(true, false);
    Some(parts.u.expect("asked for").columns(0, count).clone_owned())
}

/// Of the clusters (positions on the diagonal of `t`, uncertainty of their mean) that may coincide, the two nearest.
fn nearest_in_doubt(clusters: &[(Vec<usize>, f64)], t: &Matrix) -> Option<(usize, usize)> {
    let mut nearest: Option<(f64, usize, usize)> = None;
    for (second, (members, reach)) in clusters.iter().enumerate() {
        for (first, (others, radius)) in clusters[..second].iter().enumerate() {
            let pairs = members.iter().flat_map(|&i| others.iter().map(move |&j| (i, j)));
            let distance = pairs.map(|(i, j)| (t[(i, i)] - t[(j, j)]).norm()).fold(f64::INFINITY, f64::min);
            if distance <= reach + radius && nearest.is_none_or(|(least, ..)| distance < least) {
                nearest = Some((distance, first, second));
            }
        }
    }
    nearest.map(|(_, first, second)| (first, second))
}

/// `A = Q T Q*`, Q unitary, T upper triangular.
#[derive(Clone)]
struct Triangular {
    q: Matrix,
    t: Matrix,
}

impl Triangular {
    fn of(a: &DMatrix<f64>) -> Option<Self> {
        let a = a.map(Complex::from);
        let form = |a: Matrix| Schur::try_new(a, f64::EPSILON, SWEEPS).map(Schur::unpack);
        let is_finite =
            |(_, t): &(Matrix, Matrix)| t.iter().all(|entry| entry.re.is_finite() && entry.im.is_finite());
        // The shifted QR iteration can stand still on orthogonal matrices; a reflection keeps the eigenvalues.
        let (q, t) = form(a.clone()).filter(is_finite).or_else(|| {
            let normal = DMatrix::from_fn(a.nrows(), 1, |i, _| Complex::from(1.0 / (i as f64 + 1.3)));
            let strength = Complex::from(2.0 / normal.norm_squared());
            let reflection = Matrix::identity(a.nrows(), a.nrows()) - &normal * normal.adjoint() * strength;
            let (q, t) = form(&reflection * a * &reflection).filter(is_finite)?;
            Some((reflection * q, t))
        })?;
        Some(Self { q, t })
    }

    /// The form with the eigenvalues at the positions `chosen` in front.
    fn led_by(&self, chosen: &[usize]) -> Self {
        let mut form = self.clone();
        let mut chosen = chosen.to_vec();
        chosen.sort_unstable();
        for (place, &from) in chosen.iter().enumerate() {
            for at in (place..from).rev() {
                form.swap(at);
            }
        }
        form
    }

    /// Swaps the eigenvalues at `at` and `at + 1` by a rotation.
    fn swap(&mut self, at: usize) {
        let (first, second) = (self.t[(at, at)], self.t[(at + 1, at + 1)]);
        let (along, across) = (self.t[(at, at + 1)], second - first);
        let length = along.norm().hypot(across.norm());
        if length == 0.0 {
            return;
        }
        let (cos, sin) = match along.norm() {
            0.0 => (0.0, across.conj() / length),
            size => (size / length, along / size * across.conj() / length),
        };
        for column in at + 2..self.t.ncols() {
            let (x, y) = (self.t[(at, column)], self.t[(at + 1, column)]);
            self.t[(at, column)] = x * cos + sin * y;
            self.t[(at + 1, column)] = y * cos - sin.conj() * x;
        }
        let turn = |matrix: &mut Matrix, rows: usize| {
            for row in 0..rows {
                let (x, y) = (matrix[(row, at)], matrix[(row, at + 1)]);
                matrix[(row, at)] = x * cos + sin.conj() * y;
                matrix[(row, at + 1)] = y * cos - sin * x;
            }
        };
        turn(&mut self.t, at);
        let size = self.q.nrows();
        turn(&mut self.q, size);
        self.t[(at, at)] = second;
        self.t[(at + 1, at + 1)] = first;
    }

    /// Norm of the projector onto the invariant subspace of the first `count` eigenvalues along that of the others.
    fn condition(&self, count: usize) -> f64 {
        let rest = self.t.nrows() - count;
        let mut solution = Matrix::zeros(count, rest);
        let smallest = f64::EPSILON * self.t.norm();
        for column in 0..rest {
            let at = count + column;
            for row in (0..count).rev() {
                let mut sum = self.t[(row, at)];
                for before in 0..column {
                    sum += solution[(row, before)] * self.t[(count + before, at)];
                }
                for after in row + 1..count {
                    sum -= self.t[(row, after)] * solution[(after, column)];
                }
                let gap = self.t[(row, row)] - self.t[(at, at)];
                solution[(row, column)] =
                    sum / if gap.norm() > smallest { gap } else { Complex::from(smallest) };
            }
        }
        let size = solution.norm();
        if size.is_finite() { size.hypot(1.0) } else { f64::INFINITY }
    }

    /// The first `count` eigenvalues as one mode.
    fn leading_mode(&self, count: usize, noise: f64) -> Mode {
        let value = (0..count).map(|at| self.t[(at, at)]).sum::<Complex<f64>>() / count as f64;
        let uncertainty = noise * self.condition(count);
        let largest = (0..count).map(|at| self.t[(at, at)].norm()).fold(0.0, f64::max);
        let gap =
            (count..self.t.nrows()).map(|at| (self.t[(at, at)] - value).norm()).fold(f64::INFINITY, f64::min);
        let subspace = self.q.columns(0, count);
        let mut vectors = subspace.clone_owned();
        if count > 1 {
            let block = self.t.view((0, 0), (count, count)) - Matrix::identity(count, count) * value;
            let parts = block.svd(false, true);
            let directions = parts.v_t.expect("asked for").adjoint();
            let least = parts.singular_values.min();
            let kept: Vec<usize> =
                (0..count).filter(|&at| parts.singular_values[at] <= uncertainty.max(least)).collect();
            vectors = subspace * directions.select_columns(&kept);
        }
        let vector_uncertainty = uncertainty / gap.max(f64::MIN_POSITIVE);
        Mode { value, largest, uncertainty, vectors, vector_uncertainty }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_eigenvalues_can_be_brought_to_the_front_of_the_triangular_form() {
        let a =
            DMatrix::from_fn(6, 6, |i, j| ((7 * i + 3 * j) as f64).sin() + if i == j { 1.0 } else { 0.0 });
        let form = Triangular::of(&a).unwrap();
        let led = form.led_by(&[1, 4]);
        for (at, from) in [(0, 1), (1, 4)] {
            assert!((led.t[(at, at)] - form.t[(from, from)]).norm() < 1e-13);
        }
        let again = &led.q * &led.t * led.q.adjoint();
        assert!((again - a.map(Complex::from)).norm() < 1e-13);
        assert!((led.q.adjoint() * &led.q - Matrix::identity(6, 6)).norm() < 1e-13);
    }

    #[test]
    fn a_defective_block_is_one_mode_with_one_direction_and_a_certain_mean() {
        let units =
            DMatrix::from_fn(4, 4, |i, j| ((5 * i + 11 * j) as f64).cos() + if i == j { 3.0 } else { 0.0 });
        let block = DMatrix::from_fn(4, 4, |i, j| match (i, j) {
            (3, 3) => 0.4,
            _ if i == j => 1.3,
            (0, 1) | (1, 2) => 0.5,
            _ => 0.0,
        });
        let a = &units * block * units.clone().try_inverse().unwrap();
        let modes = lasting_modes(&a, 8.0 * f64::EPSILON).unwrap();
        assert_eq!(modes.len(), 1);
        assert!((modes[0].value - Complex::from(1.3)).norm() < 1e-12);
        assert!(modes[0].uncertainty < 1e-10);
        assert_eq!(modes[0].vectors.ncols(), 1);
    }

    #[test]
    fn equal_eigenvalues_with_two_blocks_are_one_mode_with_two_directions() {
        let units =
            DMatrix::from_fn(3, 3, |i, j| ((5 * i + 11 * j) as f64).cos() + if i == j { 3.0 } else { 0.0 });
        let diagonal = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1.3, 1.3, -1.1]));
        let a = &units * diagonal * units.clone().try_inverse().unwrap();
        let modes = lasting_modes(&a, 8.0 * f64::EPSILON).unwrap();
        assert_eq!(modes.iter().map(|mode| mode.vectors.ncols()).sum::<usize>(), 3);
        assert_eq!(modes.len(), 2);
    }
}
