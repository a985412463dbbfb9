//! Elementary functions for lanes.
//!
//! Input: a number. Output: the function there, or NaN where the formulas here are not sure of it: outside of the domain and in
//! the far range that each function names. Whoever meets a NaN asks the library's function.
//!
//! Invariant: no branches, no calls, only `+ − × ÷ √`, comparisons and operations on bits, so that a loop over lanes becomes
//! code of vectors, and the bits are the same with vectors of any width. Bounds of the errors are those that `tests.rs` checks.
//!
//! Polynomials are interpolations at Chebyshev's nodes of the named function, made with 60 digits and rounded, unless said
//! otherwise.

mod angles;
mod arcs;
mod exponentials;
mod hyperbolic;
mod logarithms;
mod powers;
#[cfg(test)]
mod tests;

pub use angles::{cos, sin, sin_cos, sin_cos_of_sum, tan};
pub use arcs::{acos, asin, atan, atan2};
pub use exponentials::{exp, exp_m1, exp2};
pub use hyperbolic::{acosh, asinh, atanh, cosh, sinh, tanh};
pub use logarithms::{ln, ln_1p, log2, log10};
pub use powers::{cbrt, hypot, power_log, powf};

/// 1.5 · 2⁵²: what is added to it is rounded to an integer, ties to even, which then stands in the lowest bits.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// The bit of the sign.
const SIGN: u64 = 1 << 63;

/// `yes` or `no`, both of which are computed.
#[inline(always)]
fn select(condition: bool, yes: f64, no: f64) -> f64 {
    if condition { yes } else { no }
}

/// The nearest integer, and bits whose lowest 51 are those of that integer in two's complement. Right for `|x| < 2⁵⁰`.
#[inline(always)]
fn nearest(x: f64) -> (f64, u64) {
    let shifted = x + TO_INTEGER;
    (shifted - TO_INTEGER, shifted.to_bits())
}

/// 2 to the power that the low bits of [`nearest`] are, which is from −1022 to 1023.
#[inline(always)]
fn power_of_two(exponent: u64) -> f64 {
    f64::from_bits(exponent.wrapping_add(1023) << 52)
}

/// `c₀ + c₁ x + …` of four terms, from `x` and `x²`.
#[inline(always)]
fn four(c: [f64; 4], x: f64, x2: f64) -> f64 {
    (c[0] + x * c[1]) + x2 * (c[2] + x * c[3])
}
