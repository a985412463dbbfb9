//! The rules of the algebra against plain evaluation, over signs, zeros and ranges.

mod derivatives;
mod elementary;
mod entries;
pub(crate) mod formula;
mod identities;
pub(crate) mod number;
pub(crate) mod recipe;
mod removable;
mod rules;
mod stable;

use std::collections::HashMap;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::expr::Bits;
use super::{Arena, Binary, Expr, Function, Symbol};
use number::{Bounded, Number};
use recipe::{BINARIES, FUNCTIONS, Make, Random, grow};

/// Numbers of symbols in random expressions.
pub(super) const SYMBOLS: usize = 3;

/// Values with signs, zeros, ones, powers of two and ranges.
fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.0, 1e-3, -1e3, 4.0]),
        -3.0..3.0f64,
        -1e3..1e3f64,
        0.0..1.0f64,
    ]
}

pub(super) fn close(found: f64, expected: f64, size: f64) -> bool {
    (found - expected).abs() <= 1e-12 * (1.0 + size)
}

/// Returns whether two values are equal except for a few last bits. Not every odd function of the
/// standard library is odd to the last bit.
fn same(found: f64, expected: f64) -> bool {
    found == expected
        || found.is_nan() && expected.is_nan()
        || (found - expected).abs() <= 1e-14 * expected.abs()
}

fn make() -> impl Strategy<Value = Make> {
    let any = 0..1000usize;
    prop_oneof![
        1 => value().prop_map(Make::Constant),
        2 => (0..SYMBOLS).prop_map(Make::Symbol),
        4 => (value(), prop::collection::vec((value(), any.clone()), 0..4)).prop_map(|(c, t)| Make::Sum(c, t)),
        4 => prop::collection::vec((any.clone(), -3..4i32), 0..4).prop_map(Make::Product),
        3 => (prop::sample::select(FUNCTIONS.to_vec()), any.clone()).prop_map(|(f, x)| Make::Call(f, x)),
        1 => (prop::sample::select(BINARIES.to_vec()), any.clone(), any.clone()).prop_map(|(f, x, y)| Make::Call2(f, x, y)),
        1 => any.prop_map(Make::Opaque),
    ]
}

pub(super) fn recipe() -> impl Strategy<Value = Vec<Make>> {
    prop::collection::vec(make(), 1..14)
}

/// Returns the expressions of a recipe, and their values by plain evaluation.
pub(super) fn build(recipe: &[Make], at: &[f64], arena: &mut Arena) -> Vec<(Expr, f64)> {
    let symbols: Vec<Symbol> = (0..SYMBOLS as u32).map(Symbol).collect();
    let exprs = recipe::build(recipe, &symbols, arena);
    exprs
        .into_iter()
        .zip(recipe::evaluate(recipe, at))
        .collect()
}

/// Returns whether every intermediate value is moderate, so that rounding and conditioning are
/// harmless.
pub(super) fn moderate(made: &[(Expr, f64)]) -> bool {
    made.iter()
        .all(|(_, x)| x.is_finite() && x.abs() < 30.0 && (*x == 0.0 || x.abs() > 1e-2))
}

/// Returns whether a difference is explained by the rounding of the argument. Next to a
/// singularity, such as the singularity of `atanh` at 1, the library's own values on the two sides
/// differ by as much.
fn rounded(f: Function, x: f64, difference: f64) -> bool {
    let slope = slope(|x| f.evaluate(x), x, 1e-9);
    difference.abs() <= 4.0 * f64::EPSILON * slope.abs() * x.abs().max(1.0)
}

/// Returns the derivative by central differences of sixth order.
fn slope(f: impl Fn(f64) -> f64, x: f64, h: f64) -> f64 {
    let odd = |k: f64| f(x + k * h) - f(x - k * h);
    (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, max_global_rejects: 100_000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn sums_collect(a in value(), b in value(), c in value(), x in value(), y in value()) {
        let mut arena = Arena::new();
        let [sx, sy] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        let first = arena.sum(a, &[(b, sx), (c, sy)]);
        let again = arena.sum(c, &[(a, first), (b, sx), (-a, sy)]);
        let found = arena.evaluate(again, |s| [x, y][s.0 as usize]);
        let expected = c + a * (a + b * x + c * y) + b * x - a * y;
        let size = [a * a, a * b * x, a * c * y, b * x, a * y, c].iter().fold(0.0f64, |m, t| m.max(t.abs()));
        prop_assert!(close(found, expected, size), "{found} {expected}");
    }

    #[test]
    fn products_collect(x in value(), y in value(), j in -4..5i32, k in -4..5i32, c in value()) {
        prop_assume!(x != 0.0 && y != 0.0 && c != 0.0);
        let mut arena = Arena::new();
        let [sx, sy] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        let scaled = arena.scale(c, sx);
        let inner = arena.product(&[(scaled, j), (sy, k)]);
        let whole = arena.product(&[(inner, k), (sx, j), (sy, -k)]);
        let found = arena.evaluate(whole, |s| [x, y][s.0 as usize]);
        let expected = ((c * x).powi(j) * y.powi(k)).powi(k) * x.powi(j) * y.powi(-k);
        prop_assume!(expected.is_finite() && expected != 0.0 && found.is_finite() && found != 0.0);
        prop_assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
    }

    #[test]
    fn sums_inside_products_are_normalised(a in value(), b in value(), c in value(), k in 1..4i32, x in value(), y in value()) {
        prop_assume!(a != 0.0 && b != 0.0 && c != 0.0);
        let mut arena = Arena::new();
        let [sx, sy] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        let sum = arena.sum(0.0, &[(a, sx), (b, sy)]);
        let scaled = arena.scale(c, sum);
        let ratio = arena.product(&[(scaled, k), (sum, -k)]);
        let at = |s: Symbol| [x, y][s.0 as usize];
        let plain = a * x + b * y;
        prop_assume!(plain.abs() > 1e-6 * ((a * x).abs() + (b * y).abs()) && plain != 0.0);
        let found = arena.evaluate(ratio, at);
        prop_assert!((found / c.powi(k) - 1.0).abs() < 1e-8, "{found} {}", c.powi(k));
        // multiplied by a signed power of two, a sum keeps its base
        let halved = arena.scale(-0.5, sum);
        let ratio = arena.product(&[(halved, k), (sum, -k)]);
        prop_assert_eq!(arena.constant_value(ratio), Some((-0.5f64).powi(k)));
    }

    #[test]
    fn parity(x in value(), f in prop::sample::select(FUNCTIONS.to_vec())) {
        let mut arena = Arena::new();
        let sx = arena.symbol(Symbol(0));
        let minus = arena.neg(sx);
        let mirrored = arena.call(f, minus);
        let (found, expected) = (arena.evaluate(mirrored, |_| x), f.evaluate(-x));
        prop_assert!(same(found, expected) || rounded(f, -x, found - expected), "{f:?} {x}: {found} {expected}");
        let shifted = arena.sum(1.0, &[(-2.0, sx)]);
        let mirrored = arena.call(f, shifted);
        let (found, expected) = (arena.evaluate(mirrored, |_| x), f.evaluate(1.0 - 2.0 * x));
        prop_assert!(same(found, expected) || rounded(f, 1.0 - 2.0 * x, found - expected), "{f:?} {x}: {found} {expected}");
    }

    #[test]
    fn roots_in_pairs(x in value(), y in value(), k in -6..7i32) {
        let mut arena = Arena::new();
        let [sx, sy] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        let at = |s: Symbol| [x, y][s.0 as usize];
        for radicand in [arena.product(&[(sx, 2), (sy, 1)]), sx, arena.add(sx, sy), arena.pow(sx, 2), arena.pow(sx, -2)] {
            let root = arena.call(Function::Sqrt, radicand);
            let power = arena.pow(root, k);
            let expected = arena.evaluate(radicand, at).sqrt().powi(k);
            if expected.is_finite() && expected != 0.0 {
                let found = arena.evaluate(power, at);
                prop_assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
            }
        }
        // √(x²) is |x|, not x
        let square = arena.pow(sx, 2);
        let modulus = arena.call(Function::Sqrt, square);
        prop_assert_eq!(arena.evaluate(modulus, at), (x * x).sqrt());
        let derivative = arena.diff(modulus, Symbol(0));
        if x != 0.0 {
            prop_assert!((arena.evaluate(derivative, at) - x.signum()).abs() < 1e-12);
        }
    }

    #[test]
    fn constant_powers(x in 0.01..100.0f64, quarters in -40..41i32, exponent in -3.0..3.0f64) {
        let mut arena = Arena::new();
        let sx = arena.symbol(Symbol(0));
        for exponent in [f64::from(quarters) / 4.0, exponent] {
            let e = arena.constant(exponent);
            let power = arena.call2(Binary::Pow, sx, e);
            let found = arena.evaluate(power, |_| x);
            prop_assert!((found / x.powf(exponent) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn derivatives_of_functions(x in -3.0..3.0f64, f in prop::sample::select(FUNCTIONS.to_vec()), e in -2.0..3.0f64) {
        let mut arena = Arena::new();
        let sx = arena.symbol(Symbol(0));
        for f in [f, Function::Powf(Bits::new(e))] {
            let value = arena.call(f, sx);
            let derivative = arena.diff(value, Symbol(0));
            let expected = slope(|x| f.evaluate(x), x, 1e-4);
            let rough = slope(|x| f.evaluate(x), x, 2e-4);
            // if the difference does not converge, a singularity is near
            if expected.is_finite() && (expected - rough).abs() < 1e-8 * (1.0 + expected.abs()) {
                let found = arena.evaluate(derivative, |_| x);
                prop_assert!((found - expected).abs() < 1e-7 * (1.0 + expected.abs()), "{f:?} {x}: {found} {expected}");
            }
        }
    }

    #[test]
    fn derivatives_of_binaries(x in -3.0..3.0f64, y in -3.0..3.0f64, f in prop::sample::select(BINARIES.to_vec())) {
        let mut arena = Arena::new();
        let [sx, sy] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        let value = arena.call2(f, sx, sy);
        let at = |s: Symbol| [x, y][s.0 as usize];
        for (i, along) in [&(|x| f.evaluate(x, y)) as &dyn Fn(f64) -> f64, &|y| f.evaluate(x, y)].into_iter().enumerate() {
            let derivative = arena.diff(value, Symbol(i as u32));
            let here = [x, y][i];
            let (expected, rough) = (slope(along, here, 1e-4), slope(along, here, 2e-4));
            if expected.is_finite() && (expected - rough).abs() < 1e-8 * (1.0 + expected.abs()) {
                let found = arena.evaluate(derivative, at);
                prop_assert!((found - expected).abs() < 1e-7 * (1.0 + expected.abs()), "{f:?} {x} {y}: {found} {expected}");
            }
        }
    }

    #[test]
    fn an_expression_is_itself(recipe in recipe(), at in prop::collection::vec(value(), SYMBOLS)) {
        let mut arena = Arena::new();
        let first = build(&recipe, &at, &mut arena);
        let again = build(&recipe, &at, &mut arena);
        for (a, b) in first.iter().zip(&again) {
            prop_assert_eq!(a.0, b.0);
            let difference = arena.sub(a.0, b.0);
            if arena.is_finite(a.0) {
                prop_assert!(arena.is_zero(difference));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, max_global_rejects: 100_000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn construction_agrees_with_evaluation(recipe in recipe(), at in prop::collection::vec(value(), SYMBOLS)) {
        let mut arena = Arena::new();
        let made = build(&recipe, &at, &mut arena);
        prop_assume!(moderate(&made));
        let size = made.iter().fold(0.0f64, |m, (_, x)| m.max(x.abs()));
        for (expr, plain) in made {
            let found = arena.evaluate(expr, |s| at[s.0 as usize]);
            // conditioning of tan, powers and reciprocals of numbers above 1e-2
            prop_assert!((found - plain).abs() <= 1e-8 * (1.0 + size), "{found} for {plain}");
        }
    }
}

#[test]
fn substitution_agrees_with_evaluation() {
    let mut sharp = 0;
    for seed in 0..500 {
        let random = &mut Random(seed);
        let at: Vec<f64> = (0..SYMBOLS).map(|_| random.uniform(0.2, 1.5)).collect();
        let mut arena = Arena::new();
        let inner = grow(random, &at, 10);
        let (by, here) = *build(&inner, &at, &mut arena).last().expect("one");
        let replaced = [here, at[1], at[2]];
        let outer = grow(random, &replaced, 12);
        let made = build(&outer, &replaced, &mut arena);
        let (expr, plain) = *made.last().expect("one");
        let new = arena.substitute(expr, &HashMap::from([(Symbol(0), by)]));
        let at = |s: Symbol| Bounded::of(at[s.0 as usize]);
        let found = recipe::values(&arena, &[new], at)[0];
        // the same composition, evaluated with an error bound
        let start: Vec<Bounded> = (0..SYMBOLS as u32).map(|i| at(Symbol(i))).collect();
        let here = *recipe::evaluate(&inner, &start).last().expect("one");
        let expected = recipe::evaluate(&outer, &[here, start[1], start[2]]);
        let expected = *expected.last().expect("one");
        assert_eq!(expected.value, plain);
        if found.is_sharp() && expected.is_sharp() {
            sharp += 1;
            assert!(
                found.agrees(expected),
                "seed {seed}: {found:?} {expected:?}"
            );
        }
    }
    assert!(sharp > 450, "{sharp}");
}
