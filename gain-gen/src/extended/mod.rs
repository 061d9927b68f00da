//! Numbers of twice the precision of `f64`, for what decides the last digits: residuals, and plants whose entries cancel.
//!
//! | file | what lives there |
//! |---|---|
//! | `number` | [`Extended`], the sum of two `f64` that do not overlap |
//! | `dense` | products and solutions of dense matrices, for [`Extended`] and `f64` alike |
//!
//! Own arithmetic, as it has to run at full speed on any processor: the crates for it are built on the fused
//! multiply-add, which is a call into the C library wherever the compiler may not assume the instruction.

mod dense;
mod number;

pub(crate) use dense::{
    Lu, Real, cholesky, product, rounded, solve_lower, symmetric, transposed_product, widened,
};
pub(crate) use number::Extended;
