//! What the recursion that computes gains needs of a number.
//!
//! A device computes in a [`Scalar`]. A host may compute a step in more digits than any processor has, to see what rounding
//! has left of a solution: it brings a type of its own.

use crate::Scalar;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use nalgebra::{ComplexField, RealField};

/// A real number: every [`Scalar`], or a host's own type.
pub trait Number:
    Copy
    + PartialOrd
    + core::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// The distance from 1 to the next larger number, or what one operation rounds by.
    const EPSILON: Self;
    /// 0.
    fn zero() -> Self;
    /// 1.
    fn one() -> Self;
    /// The nearest number of this type.
    fn nearest(value: f64) -> Self;
    /// The nearest `f64`.
    fn widen(self) -> f64;
    /// Whether it is 0.
    fn is_zero(&self) -> bool;
    /// Whether it is neither infinite nor not a number.
    fn is_finite(&self) -> bool;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root of what is not negative.
    fn sqrt(self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
}

impl<T: Scalar> Number for T {
    const EPSILON: Self = <T as Scalar>::EPSILON;
    #[inline(always)]
    fn zero() -> Self {
        nalgebra::zero()
    }
    #[inline(always)]
    fn one() -> Self {
        nalgebra::one()
    }
    #[inline(always)]
    fn nearest(value: f64) -> Self {
        <T as Scalar>::nearest(value)
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        <T as Scalar>::widen(self)
    }
    #[inline(always)]
    fn is_zero(&self) -> bool {
        *self == nalgebra::zero()
    }
    #[inline(always)]
    fn is_finite(&self) -> bool {
        ComplexField::is_finite(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        ComplexField::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        ComplexField::sqrt(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        RealField::min(self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        RealField::max(self, other)
    }
}
