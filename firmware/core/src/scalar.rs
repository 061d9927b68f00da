//! The scalar types the core computes in: `f32` (the device's default) and `f64`.
//!
//! Only what differs between the two lives here, or between platforms; arithmetic is nalgebra's `RealField`. Tables are checked where they are
//! constants, and comparisons of a type parameter cannot be `const`: hence a range check for each of the two.

use nalgebra::RealField;
use serde::{Serialize, de::DeserializeOwned};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`.
pub trait Scalar: RealField + Copy + Serialize + DeserializeOwned + sealed::Sealed {
    /// Bytes of one value on the wire; also the tag that tells the two apart in a frame header.
    const BYTES: u8;
    /// The distance from 1 to the next larger value.
    const EPSILON: Self;
    /// The nearest value of this type.
    fn nearest(value: f64) -> Self;
    /// The same value; exact.
    fn widen(self) -> f64;
    /// Natural logarithm, of `libm` on every platform: the platform's own may round otherwise.
    fn logarithm(self) -> Self;
    /// Exponential function, of `libm` likewise.
    fn exponential(self) -> Self;
}

impl Scalar for f32 {
    const BYTES: u8 = 4;
    const EPSILON: Self = f32::EPSILON;
    fn nearest(value: f64) -> Self {
        value as f32
    }
    fn widen(self) -> f64 {
        f64::from(self)
    }
    fn logarithm(self) -> Self {
        libm::logf(self)
    }
    fn exponential(self) -> Self {
        libm::expf(self)
    }
}

impl Scalar for f64 {
    const BYTES: u8 = 8;
    const EPSILON: Self = f64::EPSILON;
    fn nearest(value: f64) -> Self {
        value
    }
    fn widen(self) -> f64 {
        self
    }
    fn logarithm(self) -> Self {
        libm::log(self)
    }
    fn exponential(self) -> Self {
        libm::exp(self)
    }
}

macro_rules! range_check {
    ($name:ident, $scalar:ty) => {
        /// Whether every value is within `low..=high`; NaN is not.
        pub(crate) const fn $name(values: &[$scalar], low: $scalar, high: $scalar) -> bool {
            let mut i = 0;
            while i < values.len() {
                // Written so that NaN is outside.
                if !(values[i] >= low && values[i] <= high) {
                    return false;
                }
                i += 1;
            }
            true
        }
    };
}
range_check!(all_within_f32, f32);
range_check!(all_within_f64, f64);
