//! The elementary functions in 106 bits.
//!
//! Series after reduction of the argument, and steps of Newton's method from the value of the
//! standard library. The relative error is below 2⁻⁹⁷, plus the effect of a relative change of
//! 2⁻¹⁰⁰ in the argument: cos near π/2 has fewer relative digits. The value is NaN or infinite
//! where a function is not defined and beyond the range of `f64`.

pub(super) use super::double_double::Double;

/// Bound of the relative error of a function.
pub(super) const ROUNDING: f64 = 1.0 / (1u128 << 97) as f64;

/// Bound of the relative change of the argument that explains the rest of the error.
pub(super) const ARGUMENT: f64 = 1.0 / (1u128 << 100) as f64;

const ONE: Double = Double::ONE;
const NAN: Double = Double::new(f64::NAN, 0.0);

/// π/2 in three parts. The first two are [`HALF_PI`].
const HALF_PI_PARTS: [f64; 3] = [
    std::f64::consts::FRAC_PI_2,
    6.123_233_995_736_766e-17,
    -1.497_384_904_859_169_8e-33,
];

const HALF_PI: Double = Double::new(HALF_PI_PARTS[0], HALF_PI_PARTS[1]);

/// ln 2 in three parts. The first two are [`LN_2`].
const LN_2_PARTS: [f64; 3] = [
    std::f64::consts::LN_2,
    2.319_046_813_846_299_6e-17,
    5.707_708_438_416_212e-34,
];

const LN_2: Double = Double::new(LN_2_PARTS[0], LN_2_PARTS[1]);

const LN_10: Double = Double::new(std::f64::consts::LN_10, -2.170_756_223_382_249_4e-16);

/// Magnitude of the argument beyond which the exponential is infinite or zero.
const EXPONENT: f64 = 750.0;

/// Argument from which tanh is 1 in 106 bits.
const TANH_IS_ONE: f64 = 40.0;

/// Largest integer exponent for which a power is multiplied out.
const POWER: f64 = 1024.0;

pub(super) fn of(x: f64) -> Double {
    Double::from(x)
}

fn is_zero(x: Double) -> bool {
    x.nearest() == 0.0
}

fn is_negative(x: Double) -> bool {
    x.nearest() < 0.0
}

pub(super) fn square(x: Double) -> Double {
    x * x
}

/// Extends a function of nonnegative arguments to an odd function: `−f(−x)` for negative x.
fn odd(x: Double, f: impl Fn(Double) -> Double) -> Double {
    if is_negative(x) { -f(-x) } else { f(x) }
}

pub(super) fn sqrt(x: Double) -> Double {
    let near = of(x.nearest().sqrt());
    if is_zero(near) {
        return near;
    }
    near + (x - near * near) / (of(2.0) * near)
}

pub(super) fn cbrt(x: Double) -> Double {
    let near = of(x.nearest().cbrt());
    if is_zero(near) {
        return near;
    }
    let square = near * near;
    near + (x - square * near) / (of(3.0) * square)
}

pub(super) fn hypot(x: Double, y: Double) -> Double {
    let largest = x.nearest().abs().max(y.nearest().abs());
    if largest == 0.0 || !largest.is_finite() {
        return of(largest);
    }
    let k = largest.log2() as i32;
    let [x, y] = [x, y].map(|x| x.times_two_to(-k));
    sqrt(square(x) + square(y)).times_two_to(k)
}

/// Returns `exp x − 1` for |x| below 1: the series at `x/2ᵏ`, then `E(2x) = E(x)(2 + E(x))`.
fn small_exp_m1(x: Double) -> Double {
    let halvings = (x.nearest().abs().log2().ceil() + 7.0).clamp(0.0, 7.0) as i32;
    let small = x.times_two_to(-halvings);
    let (mut term, mut sum) = (small, small);
    for k in 2..16 {
        term = term * small / of(f64::from(k));
        sum = sum + term;
    }
    for _ in 0..halvings {
        sum = sum * (of(2.0) + sum);
    }
    sum
}

pub(super) fn exp(x: Double) -> Double {
    let near = x.nearest();
    if near.is_nan() || near.abs() > EXPONENT {
        return of(near.exp());
    }
    let k = (near / LN_2_PARTS[0]).round();
    let rest = LN_2_PARTS
        .iter()
        .fold(x, |rest, &part| rest - of(k) * of(part));
    (ONE + small_exp_m1(rest)).times_two_to(k as i32)
}

pub(super) fn exp2(x: Double) -> Double {
    exp(x * LN_2)
}

pub(super) fn exp_m1(x: Double) -> Double {
    if x.nearest().abs() < 0.5 {
        small_exp_m1(x)
    } else {
        exp(x) - ONE
    }
}

/// Returns `ln(1 + x)` by a step of Newton's method from the value of the standard library.
pub(super) fn ln_1p(x: Double) -> Double {
    let near = of(x.nearest().ln_1p());
    let e = exp_m1(near);
    near + (x - e) / (ONE + e)
}

pub(super) fn ln(x: Double) -> Double {
    let size = x.nearest();
    if (0.5..2.0).contains(&size) {
        return ln_1p(x - ONE);
    }
    let near = of(size.ln());
    near + (x * exp(-near) - ONE)
}

pub(super) fn log2(x: Double) -> Double {
    ln(x) / LN_2
}

pub(super) fn log10(x: Double) -> Double {
    ln(x) / LN_10
}

pub(super) fn tan(x: Double) -> Double {
    sin(x) / cos(x)
}

pub(super) fn pow(x: Double, y: Double) -> Double {
    let (base, exponent) = (x.nearest(), y.nearest());
    if base == 0.0 {
        return of(base.powf(exponent));
    }
    let is_integer = is_zero(y - of(exponent.round()));
    if is_integer && exponent.abs() <= POWER {
        return x.power(exponent as i32);
    }
    if base < 0.0 {
        return NAN;
    }
    exp(y * ln(x))
}

pub(super) fn sinh(x: Double) -> Double {
    odd(x, |x| {
        let e = exp_m1(x);
        of(0.5) * (e + e / (ONE + e))
    })
}

pub(super) fn cosh(x: Double) -> Double {
    of(0.5) * (exp(x) + exp(-x))
}

pub(super) fn tanh(x: Double) -> Double {
    odd(x, |x| {
        if x.nearest() > TANH_IS_ONE {
            return ONE;
        }
        let e = exp_m1(x + x);
        e / (e + of(2.0))
    })
}

pub(super) fn asinh(x: Double) -> Double {
    odd(x, |x| {
        let square = square(x);
        ln_1p(x + square / (ONE + sqrt(ONE + square)))
    })
}

pub(super) fn acosh(x: Double) -> Double {
    let beyond = x - ONE;
    ln_1p(beyond + sqrt(beyond * (beyond + of(2.0))))
}

pub(super) fn atanh(x: Double) -> Double {
    odd(x, |x| of(0.5) * ln_1p(of(2.0) * x / (ONE - x)))
}

/// Reduces the argument: `x = n π/2 + r`.
fn reduced(x: Double) -> (i64, Double) {
    let n = (x.nearest() / HALF_PI_PARTS[0]).round();
    let rest = HALF_PI_PARTS
        .iter()
        .fold(x, |rest, &part| rest - of(n) * of(part));
    (n as i64, rest)
}

/// Returns `Σ (−1)ᵏ x^(2k+first)/(2k+first)!`.
fn series(x: Double, first: u32) -> Double {
    let mut term = if first == 0 { ONE } else { x };
    let mut sum = term;
    for k in 1..16 {
        let n = f64::from(2 * k + first);
        term = -(term * x * x) / of(n * (n - 1.0));
        sum = sum + term;
    }
    sum
}

pub(super) fn sin(x: Double) -> Double {
    let (n, rest) = reduced(x);
    match n.rem_euclid(4) {
        0 => series(rest, 1),
        1 => series(rest, 0),
        2 => -series(rest, 1),
        _ => -series(rest, 0),
    }
}

pub(super) fn cos(x: Double) -> Double {
    let (n, rest) = reduced(x);
    match n.rem_euclid(4) {
        0 => series(rest, 0),
        1 => -series(rest, 1),
        2 => -series(rest, 0),
        _ => series(rest, 1),
    }
}

/// Returns the angle of the point `(x, y)`: the value of the standard library, plus the angle that
/// remains after the point is rotated back by it.
pub(super) fn atan2(y: Double, x: Double) -> Double {
    let near = y.nearest().atan2(x.nearest());
    if is_zero(x) && is_zero(y) {
        return of(near);
    }
    let (s, c) = (sin(of(near)), cos(of(near)));
    of(near) + (y * c - x * s) / (x * c + y * s)
}

pub(super) fn atan(x: Double) -> Double {
    odd(x, |x| {
        if x.nearest() > 1.0 {
            HALF_PI - atan2(ONE, x)
        } else {
            atan2(x, ONE)
        }
    })
}

/// Returns the inverse sine for |x| up to 0.7, where the cosine is not small.
fn small_asin(x: Double) -> Double {
    let near = of(x.nearest().asin());
    near + (x - sin(near)) / cos(near)
}

pub(super) fn asin(x: Double) -> Double {
    odd(x, |x| {
        if x.nearest() > 0.7 {
            HALF_PI - of(2.0) * small_asin(sqrt(of(0.5) * (ONE - x)))
        } else {
            small_asin(x)
        }
    })
}

pub(super) fn acos(x: Double) -> Double {
    let near = x.nearest();
    if near > 0.7 {
        of(2.0) * small_asin(sqrt(of(0.5) * (ONE - x)))
    } else if near < -0.7 {
        of(2.0) * (HALF_PI - small_asin(sqrt(of(0.5) * (ONE + x))))
    } else {
        HALF_PI - small_asin(x)
    }
}
