//! Functions of numbers of 106 bits, good to about 90 bits relative, for references that must not round.
//!
//! Series after reduction of the argument; differences from 1 are computed as such.

#[allow(dead_code, unreachable_pub)] // as the tests of whole systems use it
#[path = "../../../../tests/src/double_double.rs"]
mod double_double;

pub(super) use double_double::Double;

pub(super) fn of(x: f64) -> Double {
    Double::from(x)
}

fn is_negative(x: Double) -> bool {
    x.nearest() < 0.0
}

pub(super) fn square(x: Double) -> Double {
    x * x
}

pub(super) fn sqrt(x: Double) -> Double {
    let near = of(x.nearest().sqrt());
    if near.nearest() == 0.0 {
        return near;
    }
    near + (x - near * near) / (of(2.0) * near)
}

/// `exp x − 1`: the series at `x/2ᵏ`, then `E(2x) = E(x)(2 + E(x))`.
pub(super) fn exp_m1(x: Double) -> Double {
    if is_negative(x) {
        let e = exp_m1(-x);
        return -e / (of(1.0) + e);
    }
    let halvings = (x.nearest().log2().ceil() + 7.0).clamp(0.0, 40.0) as i32;
    let small = x * of(0.5f64.powi(halvings));
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
    if is_negative(x) {
        return of(1.0) / exp(-x);
    }
    of(1.0) + exp_m1(x)
}

/// `ln(1 + y)`: a step of Newton's method from the library's value.
pub(super) fn ln_1p(y: Double) -> Double {
    let near = of(y.nearest().ln_1p());
    let e = exp_m1(near);
    near + (y - e) / (of(1.0) + e)
}

pub(super) fn sinh(x: Double) -> Double {
    let e = exp_m1(x);
    of(0.5) * (e + e / (of(1.0) + e))
}

pub(super) fn cosh(x: Double) -> Double {
    of(0.5) * (exp(x) + exp(-x))
}

/// `x = n π/2 + r`, with π in three parts.
fn reduced(x: Double) -> (i64, Double) {
    let n = (x.nearest() / std::f64::consts::FRAC_PI_2).round();
    let parts = [
        std::f64::consts::FRAC_PI_2,
        6.123_233_995_736_766e-17,
        -1.497_384_904_859_183_3e-33,
    ];
    let r = parts.iter().fold(x, |r, &part| r - of(n) * of(part));
    (n as i64, r)
}

/// `Σ (−1)ᵏ x^(2k+first)/(2k+first)!`.
fn series(x: Double, first: u32) -> Double {
    let mut term = if first == 0 { of(1.0) } else { x };
    let mut sum = term;
    for k in 1..16 {
        let n = f64::from(2 * k + first);
        term = -(term * x * x) / of(n * (n - 1.0));
        sum = sum + term;
    }
    sum
}

pub(super) fn sin(x: Double) -> Double {
    let (n, r) = reduced(x);
    match n.rem_euclid(4) {
        0 => series(r, 1),
        1 => series(r, 0),
        2 => -series(r, 1),
        _ => -series(r, 0),
    }
}

pub(super) fn cos(x: Double) -> Double {
    let (n, r) = reduced(x);
    match n.rem_euclid(4) {
        0 => series(r, 0),
        1 => -series(r, 1),
        2 => -series(r, 0),
        _ => series(r, 1),
    }
}

#[test]
fn agrees_with_the_library() {
    type Pair = (fn(Double) -> Double, fn(f64) -> f64);
    let pairs: [Pair; 8] = [
        (sin, f64::sin),
        (cos, f64::cos),
        (exp, f64::exp),
        (exp_m1, f64::exp_m1),
        (ln_1p, f64::ln_1p),
        (sinh, f64::sinh),
        (cosh, f64::cosh),
        (sqrt, f64::sqrt),
    ];
    for (at, (exact, library)) in pairs.into_iter().enumerate() {
        for k in 0..400 {
            let x = 20.0 * (f64::from(k) / 199.5 - 1.0).powi(3);
            let (found, expected) = (exact(of(x)).nearest(), library(x));
            if expected.is_nan() {
                continue;
            }
            // the library's functions are good to a unit or two in the last place
            let bound = 2.0 * f64::EPSILON * expected.abs();
            assert!(
                (found - expected).abs() <= bound,
                "{at}: {x} {found} {expected}"
            );
        }
    }
    // 1 − π/2 of the nearest f64 is known to be in the second part of π/2
    let residue = cos(of(std::f64::consts::FRAC_PI_2)).nearest();
    assert_eq!(residue, 6.123_233_995_736_766e-17);
}
