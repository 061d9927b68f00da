//! Whether a matrix of floating point numbers is singular, without rounding.
//!
//! Each number is an integer times a power of two. Modulo a prime both have inverses, and elimination gives the determinant's
//! remainder exactly. A determinant that is not zero leaves remainder 0 by three primes of 61 to 63 bits only if their product divides
//! its numerator.

use nalgebra::DMatrix;

/// 2^61 - 1, 2^62 - 57, 2^63 - 25.
const PRIMES: [u64; 3] = [2_305_843_009_213_693_951, 4_611_686_018_427_387_847, 9_223_372_036_854_775_783];

/// Whether the determinant of a square matrix is exactly zero.
pub(super) fn is_singular(matrix: &DMatrix<f64>) -> bool {
    PRIMES.into_iter().all(|prime| is_singular_modulo(matrix, 0, prime))
}

/// Whether 1 is exactly an eigenvalue of a square matrix.
pub(super) fn has_eigenvalue_one(matrix: &DMatrix<f64>) -> bool {
    PRIMES.into_iter().all(|prime| is_singular_modulo(matrix, 1, prime))
}

/// Whether the determinant of `matrix - shift I` leaves no remainder.
fn is_singular_modulo(matrix: &DMatrix<f64>, shift: u64, prime: u64) -> bool {
    let size = matrix.nrows();
    let times = |a: u64, b: u64| (u128::from(a) * u128::from(b) % u128::from(prime)) as u64;
    let less = |a: u64, b: u64| if a >= b { a - b } else { a + (prime - b) };
    let mut rows: Vec<Vec<u64>> =
        matrix.row_iter().map(|row| row.iter().map(|&entry| remainder(entry, prime)).collect()).collect();
    for (at, row) in rows.iter_mut().enumerate() {
        row[at] = less(row[at], shift);
    }
    for column in 0..size {
        let Some(pivot) = (column..size).find(|&row| rows[row][column] != 0) else { return true };
        rows.swap(column, pivot);
        let (done, rest) = rows.split_at_mut(column + 1);
        let pivot = &done[column];
        let inverse = power(pivot[column], prime - 2, prime);
        for row in rest.iter_mut().filter(|row| row[column] != 0) {
            let factor = times(row[column], inverse);
            for (entry, above) in row.iter_mut().zip(pivot).skip(column) {
                *entry = less(*entry, times(factor, *above));
            }
        }
    }
    false
}

/// A finite number modulo the prime.
fn remainder(value: f64, prime: u64) -> u64 {
    let bits = value.to_bits();
    let (exponent, fraction) = ((bits >> 52) & 0x7ff, bits & ((1 << 52) - 1));
    let (integer, power_of_two) =
        if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent as i64 - 1075) };
    let half = prime.div_ceil(2);
    let scale = power(if power_of_two < 0 { half } else { 2 }, power_of_two.unsigned_abs(), prime);
    let found = (u128::from(integer) * u128::from(scale) % u128::from(prime)) as u64;
    if value < 0.0 && found > 0 { prime - found } else { found }
}

fn power(base: u64, mut exponent: u64, prime: u64) -> u64 {
    let times = |a: u64, b: u64| (u128::from(a) * u128::from(b) % u128::from(prime)) as u64;
    let (mut square, mut found) = (base % prime, 1);
    while exponent > 0 {
        if exponent & 1 == 1 {
            found = times(found, square);
        }
        square = times(square, square);
        exponent >>= 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_unit_in_the_last_place_is_told_from_singular() {
        let matrix = |last: f64| DMatrix::from_row_slice(2, 2, &[0.1, 0.3, 0.2, last]);
        // 0.3 and 0.6 are rounded alike, as 0.1 and 0.2 are.
        assert!(is_singular(&matrix(0.3 * 2.0)));
        assert!(!is_singular(&matrix(0.6_f64.next_up())));
        assert!(is_singular(&DMatrix::from_row_slice(2, 2, &[0.0, 1e-300, 0.0, -1e300])));
    }

    #[test]
    fn an_integrator_is_told_from_a_mode_that_all_but_is_one() {
        let plant = |value: f64| DMatrix::from_row_slice(2, 2, &[value, 0.1, 0.0, 0.9]);
        assert!(has_eigenvalue_one(&plant(1.0)));
        for near in [1.0_f64.next_up(), 1.0_f64.next_down(), 1.0 + 1e-12] {
            assert!(!has_eigenvalue_one(&plant(near)), "{near}");
        }
    }
}
