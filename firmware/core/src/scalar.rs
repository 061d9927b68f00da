//! The scalar types the core computes in: `f32` (the device's default) and `f64`.
//!
//! Only what differs between the two lives here, or between platforms; arithmetic is nalgebra's `RealField`.

use nalgebra::RealField;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`.
pub trait Scalar: RealField + Copy + sealed::Sealed {
    /// Bytes of one value on the wire; also the tag that tells the two apart in a frame header.
    const BYTES: u8;
    /// The distance from 1 to the next larger value.
    const EPSILON: Self;
    /// 0, where a constant is needed.
    const ZERO: Self;
    /// The nearest value of this type.
    fn nearest(value: f64) -> Self;
    /// The same value; exact.
    fn widen(self) -> f64;
    /// The value that little-endian `bytes` begin with, and the bytes after it; `None` if they are too few.
    fn read(bytes: &[u8]) -> Option<(Self, &[u8])>;
    /// Writes the value, little-endian, to the beginning of `bytes`; `None` if they are too few.
    fn write(self, bytes: &mut [u8]) -> Option<()>;
    /// Natural logarithm, of `libm` on every platform: the platform's own may round otherwise.
    fn logarithm(self) -> Self;
    /// Exponential function, of `libm` likewise.
    fn exponential(self) -> Self;
}

impl Scalar for f32 {
    const BYTES: u8 = 4;
    const EPSILON: Self = f32::EPSILON;
    const ZERO: Self = 0.0;
    #[inline]
    fn nearest(value: f64) -> Self {
        value as f32
    }
    #[inline]
    fn widen(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn read(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (value, rest) = bytes.split_first_chunk()?;
        Some((Self::from_le_bytes(*value), rest))
    }
    #[inline(always)]
    fn write(self, bytes: &mut [u8]) -> Option<()> {
        *bytes.first_chunk_mut()? = self.to_le_bytes();
        Some(())
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
    const ZERO: Self = 0.0;
    #[inline]
    fn nearest(value: f64) -> Self {
        value
    }
    #[inline]
    fn widen(self) -> f64 {
        self
    }
    #[inline(always)]
    fn read(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (value, rest) = bytes.split_first_chunk()?;
        Some((Self::from_le_bytes(*value), rest))
    }
    #[inline(always)]
    fn write(self, bytes: &mut [u8]) -> Option<()> {
        *bytes.first_chunk_mut()? = self.to_le_bytes();
        Some(())
    }
    fn logarithm(self) -> Self {
        libm::log(self)
    }
    fn exponential(self) -> Self {
        libm::exp(self)
    }
}
