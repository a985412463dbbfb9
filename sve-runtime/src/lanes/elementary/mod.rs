//! Elementary functions for lanes.
//!
//! Input: a number. Output: the value of the function; NaN outside of the domain and outside of the
//! range in which the formula is accurate. A function that has such a range names it. A lane with a
//! NaN takes the scalar step, which calls the library's function.
//!
//! Invariant: no branches and no calls, only `+ − × ÷ √`, comparisons and operations on bits, so
//! that a loop over lanes compiles to vector instructions, and the bits are the same for vectors of
//! any width. `tests.rs` checks the bounds of the errors.
//!
//! Unless a comment says otherwise, polynomials interpolate the named function at Chebyshev's
//! nodes, computed with 60 digits and rounded.

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

/// 1.5 · 2⁵². A number added to it is rounded to an integer, ties to even, which stands in the
/// lowest bits of the sum.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// The sign bit.
const SIGN: u64 = 1 << 63;

/// Selects one of two values. Both are computed.
#[inline(always)]
fn select(condition: bool, yes: f64, no: f64) -> f64 {
    if condition { yes } else { no }
}

/// Returns the nearest integer, and a word whose lowest 51 bits are this integer in two's
/// complement, for `|x| < 2⁵⁰`.
#[inline(always)]
fn nearest(x: f64) -> (f64, u64) {
    let shifted = x + TO_INTEGER;
    (shifted - TO_INTEGER, shifted.to_bits())
}

/// Returns 2 to the power of the integer in the low bits of [`nearest`], for powers from −1022
/// to 1023.
#[inline(always)]
fn power_of_two(exponent: u64) -> f64 {
    f64::from_bits(exponent.wrapping_add(1023) << 52)
}

/// Returns `c₀ + c₁ x + …` of four terms, from `x` and `x²`.
#[inline(always)]
fn four(c: [f64; 4], x: f64, x2: f64) -> f64 {
    (c[0] + x * c[1]) + x2 * (c[2] + x * c[3])
}
