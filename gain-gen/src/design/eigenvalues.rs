//! The eigenvalues of a real matrix without its eigenvectors, which most of what asks for them does not need.
//!
//! Reflections bring the matrix to Hessenberg form; Francis' QR iteration with two shifts at a time splits off one real
//! eigenvalue, or a pair, after the other. It works on what is left alone, never on a triangular form of the whole (R. S.
//! Martin, G. Peters and J. H. Wilkinson, Numerische Mathematik 14, 1970), which takes a tenth of the work of one with vectors.

use nalgebra::{Complex, DMatrix};

/// Sweeps for one eigenvalue, at most: three do as a rule.
const SWEEPS: usize = 300;
/// Sweeps after which other shifts are tried once: the usual ones can go round in a circle.
const STANDSTILL: usize = 10;

/// The eigenvalues of a square matrix of entries that are neither huge nor tiny, conjugates beside each other; `None` if the
/// iteration stands still, as it may on orthogonal matrices.
pub(super) fn eigenvalues(matrix: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let mut left = matrix.clone();
    to_hessenberg(&mut left);
    let size: f64 = left.iter().map(|entry| entry.abs()).sum();
    if !size.is_finite() {
        return None;
    }
    let mut found = Vec::with_capacity(left.nrows());
    // What the shifts took off the diagonal.
    let mut shifted = 0.0;
    let mut sweeps = 0;
    while let Some(last) = (left.nrows() - found.len()).checked_sub(1) {
        let first = start_of_block(&mut left, last, size);
        if first == last {
            found.push(Complex::from(left[(last, last)] + shifted));
        } else if first + 1 == last {
            found.extend(pair(&left, last, shifted));
        } else if sweeps == SWEEPS {
            return None;
        } else {
            let shifts = if sweeps > 0 && sweeps.is_multiple_of(STANDSTILL) {
                shifted += take_off(&mut left, last);
                Shifts::unusual(&left, last)
            } else {
                Shifts::of_corner(&left, last)
            };
            sweep(&mut left, first, last, &shifts);
            sweeps += 1;
            continue;
        }
        sweeps = 0;
    }
    Some(found)
}

/// Brings a matrix to Hessenberg form by reflections; what stands below the first subdiagonal is left over from them.
fn to_hessenberg(matrix: &mut DMatrix<f64>) {
    let size = matrix.nrows();
    for column in 0..size.saturating_sub(2) {
        let below: Vec<f64> = (column + 1..size).map(|row| matrix[(row, column)]).collect();
        if below[1..].iter().all(|entry| *entry == 0.0) {
            continue;
        }
        let length = below.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        if length == 0.0 {
            continue;
        }
        let mut normal = below;
        let image = -length.copysign(normal[0]);
        normal[0] -= image;
        let strength = 1.0 / (length * normal[0].abs());
        // From the left on every later column, then from the right on all rows.
        for other in column + 1..size {
            let mut entries = matrix.view_mut((column + 1, other), (normal.len(), 1));
            let along: f64 = entries.iter().zip(&normal).map(|(entry, part)| entry * part).sum();
            entries.iter_mut().zip(&normal).for_each(|(entry, part)| *entry -= strength * along * part);
        }
        let mut along = vec![0.0; size];
        for (other, part) in normal.iter().enumerate() {
            let entries = matrix.column(column + 1 + other);
            along.iter_mut().zip(entries.iter()).for_each(|(sum, entry)| *sum += part * entry);
        }
        for (other, part) in normal.iter().enumerate() {
            let mut entries = matrix.column_mut(column + 1 + other);
            entries.iter_mut().zip(&along).for_each(|(entry, sum)| *entry -= strength * part * sum);
        }
        matrix[(column + 1, column)] = image;
        matrix.view_mut((column + 2, column), (normal.len() - 1, 1)).fill(0.0);
    }
}

/// The first row of the block that ends with row `last`: above it stands a subdiagonal entry that is rounding, set to zero here.
fn start_of_block(left: &mut DMatrix<f64>, last: usize, size: f64) -> usize {
    for row in (1..=last).rev() {
        let beside = left[(row - 1, row - 1)].abs() + left[(row, row)].abs();
        let beside = if beside == 0.0 { size } else { beside };
        if left[(row, row - 1)].abs() <= f64::EPSILON * beside {
            left[(row, row - 1)] = 0.0;
            return row;
        }
    }
    0
}

/// The eigenvalues of the two rows that end with row `last`.
fn pair(left: &DMatrix<f64>, last: usize, shifted: f64) -> [Complex<f64>; 2] {
    let (upper, lower) = (left[(last - 1, last - 1)], left[(last, last)]);
    let coupling = left[(last, last - 1)] * left[(last - 1, last)];
    let half = 0.5 * (upper - lower);
    let discriminant = half * half + coupling;
    let root = discriminant.abs().sqrt();
    let lower = lower + shifted;
    if discriminant < 0.0 {
        return [Complex::new(lower + half, root), Complex::new(lower + half, -root)];
    }
    // The one farther away first: nothing cancels in it.
    let farther = half + root.copysign(half);
    let nearer = if farther == 0.0 { 0.0 } else { coupling / farther };
    [Complex::from(lower + farther), Complex::from(lower - nearer)]
}

/// Takes the last diagonal entry off all of them, up to row `last`, and returns it.
fn take_off(left: &mut DMatrix<f64>, last: usize) -> f64 {
    let shift = left[(last, last)];
    (0..=last).for_each(|row| left[(row, row)] -= shift);
    shift
}

/// Two shifts `x` and `y`, as `x`, `y` and `w` of the polynomial `(x - z) (y - z) - w`.
struct Shifts {
    x: f64,
    y: f64,
    w: f64,
}

impl Shifts {
    /// The eigenvalues of the two rows that end with row `last`.
    fn of_corner(left: &DMatrix<f64>, last: usize) -> Self {
        Self {
            x: left[(last, last)],
            y: left[(last - 1, last - 1)],
            w: left[(last, last - 1)] * left[(last - 1, last)],
        }
    }

    /// Others, as in the source.
    fn unusual(left: &DMatrix<f64>, last: usize) -> Self {
        let size = left[(last, last - 1)].abs() + left[(last - 1, last - 2)].abs();
        Self { x: 0.75 * size, y: 0.75 * size, w: -0.4375 * size * size }
    }

    /// First column of the polynomial of the block from row `row` on, scaled: it has three entries.
    fn first_column(&self, left: &DMatrix<f64>, row: usize) -> [f64; 3] {
        let z = left[(row, row)];
        let (r, s) = (self.x - z, self.y - z);
        scaled([
            (r * s - self.w) / left[(row + 1, row)] + left[(row, row + 1)],
            left[(row + 1, row + 1)] - z - r - s,
            left[(row + 2, row + 1)],
        ])
        .0
    }
}

/// Entries over the sum of their sizes, and this sum.
fn scaled(entries: [f64; 3]) -> ([f64; 3], f64) {
    let size = entries[0].abs() + entries[1].abs() + entries[2].abs();
    if size == 0.0 { (entries, 0.0) } else { (entries.map(|entry| entry / size), size) }
}

/// One sweep of two QR steps with these shifts on the block of rows `first..=last`, of at least three rows.
fn sweep(left: &mut DMatrix<f64>, first: usize, last: usize, shifts: &Shifts) {
    // Two small subdiagonal entries in a row let the sweep begin below them.
    let mut begin = last - 2;
    let mut bulge = shifts.first_column(left, begin);
    while begin > first {
        let [p, q, r] = bulge;
        let taken = left[(begin, begin - 1)].abs() * (q.abs() + r.abs());
        let diagonal = [begin - 1, begin, begin + 1].map(|row| left[(row, row)].abs());
        if taken <= f64::EPSILON * p.abs() * diagonal.iter().sum::<f64>() {
            break;
        }
        begin -= 1;
        bulge = shifts.first_column(left, begin);
    }
    for row in begin + 2..=last {
        left[(row, row - 2)] = 0.0;
        if row > begin + 2 {
            left[(row, row - 3)] = 0.0;
        }
    }
    for row in begin..last {
        let is_last = row + 1 == last;
        let mut size = 1.0;
        if row > begin {
            let third = if is_last { 0.0 } else { left[(row + 2, row - 1)] };
            (bulge, size) = scaled([left[(row, row - 1)], left[(row + 1, row - 1)], third]);
        }
        let [p, q, r] = bulge;
        let length = (p * p + q * q + r * r).sqrt().copysign(p);
        if length == 0.0 {
            continue;
        }
        if row > begin {
            left[(row, row - 1)] = -length * size;
        } else if begin > first {
            left[(row, row - 1)] = -left[(row, row - 1)];
        }
        let p = p + length;
        let (weights, normal) = ([p / length, q / length, r / length], [1.0, q / p, r / p]);
        if is_last {
            reflect::<2>(left, row, (first, last), &weights, &normal);
        } else {
            reflect::<3>(left, row, (first, last), &weights, &normal);
        }
    }
}

/// Reflects `ROWS` rows from `row` on, then the same columns, within the block of rows `first..=last`.
fn reflect<const ROWS: usize>(
    left: &mut DMatrix<f64>,
    row: usize,
    (first, last): (usize, usize),
    weights: &[f64; 3],
    normal: &[f64; 3],
) {
    let size = left.nrows();
    let entries = left.as_mut_slice();
    for column in row..=last {
        let entries = &mut entries[column * size + row..][..ROWS];
        let along: f64 = (0..ROWS).map(|place| normal[place] * entries[place]).sum();
        (0..ROWS).for_each(|place| entries[place] -= along * weights[place]);
    }
    let end = last.min(row + 3) + 1;
    let mut columns = entries[row * size..][..ROWS * size].chunks_exact_mut(size);
    let columns: [&mut [f64]; ROWS] =
        std::array::from_fn(|_| &mut columns.next().expect("there are that many")[first..end]);
    for place in 0..end - first {
        let along: f64 = (0..ROWS).map(|column| weights[column] * columns[column][place]).sum();
        (0..ROWS).for_each(|column| columns[column][place] -= along * normal[column]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Schur;

    /// Largest distance of a value of one list to the nearest one of the other that is still free.
    fn apart(found: &[Complex<f64>], expected: &[Complex<f64>]) -> f64 {
        let mut free = expected.to_vec();
        let distances = found.iter().map(|value| {
            let distance = |other: &Complex<f64>| (other - value).norm();
            let nearest = (0..free.len()).min_by(|&a, &b| distance(&free[a]).total_cmp(&distance(&free[b])));
            distance(&free.swap_remove(nearest.expect("as many")))
        });
        distances.fold(0.0, f64::max)
    }

    #[test]
    fn eigenvalues_are_those_of_the_triangular_form() {
        let mut state = 1_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for size in 1..=40 {
            let matrix = DMatrix::from_fn(size, size, |_, _| draw());
            let expected = Schur::new(matrix.clone()).complex_eigenvalues();
            let found = eigenvalues(&matrix).unwrap();
            assert_eq!(found.len(), size);
            assert!(apart(&found, expected.as_slice()) < 1e-11, "{size}");
        }
    }

    #[test]
    fn eigenvalues_of_a_companion_matrix_are_the_roots_of_its_polynomial() {
        // (z - 1) (z - 2) .. (z - 6)
        let coefficients = [-21.0, 175.0, -735.0, 1624.0, -1764.0, 720.0];
        let matrix = DMatrix::from_fn(6, 6, |i, j| match i {
            0 => -coefficients[j],
            _ => f64::from(u8::from(j + 1 == i)),
        });
        let roots: Vec<_> = (1..=6).map(|root| Complex::from(f64::from(root))).collect();
        assert!(apart(&eigenvalues(&matrix).unwrap(), &roots) < 1e-9);
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_none() {
        let mut matrix = DMatrix::from_element(3, 3, 1.0);
        matrix[(1, 2)] = f64::NAN;
        assert_eq!(eigenvalues(&matrix), None);
    }
}
