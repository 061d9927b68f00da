//! A number as the unevaluated sum of two `f64`: about 31 decimal digits, with the range of `f64`.
//!
//! The error-free transformations are those of Dekker (Numerische Mathematik 18, 1971) and Knuth; the sums and products
//! on them err by a few units of 2^-104. No fused operation is used, so that every machine computes the same bits.

use slqg::Number;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// `high + low`, where `high` is the sum rounded to `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extended {
    high: f64,
    low: f64,
}

/// `a + b` and the error of it, exactly.
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// The same where `a` is not smaller than `b`, or zero.
#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Upper and lower half of the digits of `a`.
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    /// 2^27 + 1
    const SPLITTER: f64 = 134_217_729.0;
    let shifted = SPLITTER * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

/// `a * b` and the error of it, exactly, unless it leaves the range of `f64`.
#[inline(always)]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}

impl Extended {
    pub(crate) const ZERO: Self = Self { high: 0.0, low: 0.0 };
    pub(crate) const ONE: Self = Self { high: 1.0, low: 0.0 };

    /// The nearest `f64`.
    #[inline(always)]
    pub(crate) fn rounded(self) -> f64 {
        self.high
    }

    /// Magnitude, to the precision of `f64`.
    #[inline(always)]
    pub(crate) fn magnitude(self) -> f64 {
        self.high.abs()
    }

    /// Square root of a number that is not negative.
    pub(crate) fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        let root = self.high.sqrt();
        let (square, error) = two_product(root, root);
        let (high, low) = quick_two_sum(root, (self - Self { high: square, low: error }).high / (2.0 * root));
        Self { high, low }
    }
}

impl From<f64> for Extended {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }
}

impl Add for Extended {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, error) = two_sum(self.high, other.high);
        let (low, rest) = two_sum(self.low, other.low);
        let (high, error) = quick_two_sum(high, error + low);
        let (high, low) = quick_two_sum(high, error + rest);
        Self { high, low }
    }
}

impl Neg for Extended {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Extended {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Extended {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (high, error) = two_product(self.high, other.high);
        let (high, low) = quick_two_sum(high, error + (self.high * other.low + self.low * other.high));
        Self { high, low }
    }
}

impl Div for Extended {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        let (high, low) = quick_two_sum(first, second);
        Self { high, low } + Self::from(rest.high / other.high)
    }
}

impl AddAssign for Extended {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Extended {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Extended {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl DivAssign for Extended {
    #[inline]
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}

impl PartialOrd for Extended {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        // Low parts decide between equal high ones: the sums are rounded.
        match self.high.partial_cmp(&other.high)? {
            std::cmp::Ordering::Equal => self.low.partial_cmp(&other.low),
            order => Some(order),
        }
    }
}

impl Number for Extended {
    const EPSILON: Self = Self { high: f64::EPSILON * f64::EPSILON, low: 0.0 };
    #[inline(always)]
    fn zero() -> Self {
        Self::ZERO
    }
    #[inline(always)]
    fn one() -> Self {
        Self::ONE
    }
    #[inline(always)]
    fn nearest(value: f64) -> Self {
        value.into()
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        self.high
    }
    #[inline(always)]
    fn is_zero(&self) -> bool {
        self.high == 0.0
    }
    #[inline(always)]
    fn is_finite(&self) -> bool {
        self.high.is_finite()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }
    fn sqrt(self) -> Self {
        Extended::sqrt(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ulps(difference: Extended, of: f64) -> f64 {
        difference.high.abs() / (of.abs() * 2.0_f64.powi(-104))
    }

    #[test]
    fn a_third_times_three_is_one_to_thirty_digits() {
        let third = Extended::ONE / Extended::from(3.0);
        assert!(ulps(third * Extended::from(3.0) - Extended::ONE, 1.0) < 4.0);
    }

    #[test]
    fn what_cancels_in_f64_is_kept() {
        let small = Extended::from(1e-25);
        assert_eq!(((Extended::ONE + small) - Extended::ONE).rounded(), 1e-25);
        let (a, b) = (Extended::from(1.0 + 2.0_f64.powi(-40)), Extended::from(1.0 - 2.0_f64.powi(-40)));
        assert_eq!((a * b - Extended::ONE).rounded(), -(2.0_f64.powi(-80)));
    }

    #[test]
    fn a_root_squared_gives_the_number_back() {
        for value in [2.0, 3.0, 1e-9, 7e11] {
            let root = Extended::from(value).sqrt();
            assert!(ulps(root * root - Extended::from(value), value) < 8.0, "{value}");
        }
    }
}
