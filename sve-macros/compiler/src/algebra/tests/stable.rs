//! The stable forms: every rule, computed as emitted code does, against numbers of 106 bits.
//!
//! A form may be less accurate than the plain expression by at most two units in the last place, or
//! three with hypot. It must be accurate to a few units if the plain expression cancels.

use std::collections::HashMap;

use super::formula::Formula;
use super::number::{Bounded, Number};
use super::recipe::{FUNCTIONS, Make, Random, build, evaluate, grow, values};
use crate::algebra::elementary::{Double, of};
use crate::algebra::{Arena, Expr, Function, Node, Purpose, Symbol};
use crate::program::Scheduler;
use crate::program::tests::{run, symbols};
use crate::tests::rows;

/// Every row of the table in `stable`: a formula f and a value, the difference of both in a form
/// that does not cancel, and the points (x, y) near which the plain difference cancels. If the
/// value is 0, the formula is a whole expression.
const RULES: &str = r"
x.cos() → 1 → -2.0 * (0.5 * x).sin().powi(2) → 0 1
x.cos().powi(2) → 1 → -x.sin().powi(2) → 0 1
x.sin().powi(2) → 1 → -x.cos().powi(2) → 1.5707963267948966 1
x.cosh() → 1 → 2.0 * (0.5 * x).sinh().powi(2) → 0 1
x.cosh().powi(2) → 1 → x.sinh().powi(2) → 0 1
x.tanh().powi(2) → 1 → -1.0 / x.cosh().powi(2) → 16 1
x.sinh().powi(2) / x.cosh().powi(2) → 1 → -1.0 / x.cosh().powi(2) → 16 1
x.exp() → 1 → x.exp_m1() → 0 1
x.exp().powi(2) → 1 → (2.0 * x).exp_m1() → 0 1
x.exp().powi(-1) → 1 → (-x).exp_m1() → 0 1
(1.0 + x * y).sqrt() → 1 → x * y / ((1.0 + x * y).sqrt() + 1.0) → 0 1
(4.0 + x * y).sqrt() → 2 → x * y / ((4.0 + x * y).sqrt() + 2.0) → 0 1
(1.0 + x * y).sqrt().powi(-1) → 1 → -(x * y) / ((1.0 + x * y).sqrt() + 1.0) / (1.0 + x * y).sqrt() → 0 1
x.powi(2) / x.hypot(y).powi(2) → 1 → -y.powi(2) / (x.powi(2) + y.powi(2)) → 1.5 0
y.powi(2) / x.hypot(y).powi(2) → 1 → -x.powi(2) / (x.powi(2) + y.powi(2)) → 0 1
x.powi(2) / (-2.0 * x).hypot(y).powi(2) → 0.25 → -0.25 * (y.powi(2) / ((2.0 * x).powi(2) + y.powi(2))) → 1.5 0
x * y / (-2.0 * x).hypot(y).powi(2) → 0 → x * y / ((2.0 * x).powi(2) + y.powi(2)) → nowhere
(1.0 + x).ln() → 0 → x.ln_1p() → 0 1
(1.0 - x.powi(2)).ln() → 0 → (-x.powi(2)).ln_1p() → 0 1
x.cosh().ln() → 0 → (2.0 * (0.5 * x).sinh().powi(2)).ln_1p() → 0 1
1.0 - x.powi(2) → 0 → (1.0 - x) * (1.0 + x) → 1 1, -1 1
x.sinh() / x.cosh() → 0 → x.tanh() → nowhere
x * y / x.hypot(y).powi(2) → 0 → x * y / (x.powi(2) + y.powi(2)) → nowhere
";

/// The points of a row.
fn points(text: &str) -> Vec<(f64, f64)> {
    let point = |text: &str| {
        let (x, y) = text.split_once(' ')?;
        Some((x.parse().expect("x"), y.parse().expect("y")))
    };
    text.split(", ").filter_map(point).collect()
}

/// Returns `c (a f − value a)` in the expanded form, where `a` is a product of powers of the two
/// symbols.
fn difference(arena: &mut Arena, (f, value): (Expr, f64), c: f64, common: &[(Expr, i32)]) -> Expr {
    let common = arena.product(common);
    let product = arena.mul(common, f);
    arena.sum(0.0, &[(c, product), (-c * value, common)])
}

/// Returns the value of an expression as emitted code computes it.
pub(super) fn computed(arena: &Arena, expr: Expr, at: &[f64; 4]) -> f64 {
    let (table, inputs) = symbols();
    let mut scheduler = Scheduler::new(arena, &table, HashMap::new(), &[expr]);
    let value = scheduler.value(expr);
    let program = scheduler.finish(&[value]);
    let at = |s: Symbol| {
        inputs
            .iter()
            .position(|&i| i == s)
            .map_or(f64::NAN, |i| at[i])
    };
    run(&program, &at)[&value]
}

/// Returns tiny, usual and large arguments of both signs, and marked ones next to points where
/// plain forms cancel.
fn arguments(random: &mut Random, cancels: &[(f64, f64)]) -> Vec<(f64, f64, bool)> {
    let mut found = vec![(0.0, 1.0, false), (-0.0, 1.0, false)];
    for k in 0..220 {
        let sign = random.of(&[1.0, -1.0]);
        let x = match k % 4 {
            0 => random.uniform(-3.5, 3.5),
            1 => 2f64.powi(-(random.below(60) as i32)),
            2 => random.uniform(-40.0, 40.0),
            _ => random.uniform(0.0, 340.0),
        };
        let y = match k % 3 {
            0 => 1.0,
            1 => random.uniform(-2.0, 2.0),
            _ => 2f64.powi(random.below(40) as i32 - 20),
        };
        found.push((sign * x, y, false));
    }
    for &(x, y) in cancels {
        for k in 0..24 {
            let by = 2f64.powi(-2 * k - 2) * random.uniform(0.7, 1.4) * random.of(&[1.0, -1.0]);
            // if y is 0 at the point, y approaches the point, otherwise x does
            let (x, y) = if y == 0.0 { (x, by) } else { (x + by, y) };
            found.push((x, y, true));
        }
    }
    found
}

/// Returns the error of a value in units of 2⁻⁵² of the exact one.
pub(super) fn units(found: f64, exact: Double) -> f64 {
    let size = exact.nearest().abs();
    ((of(found) - exact).nearest() / size).abs() / f64::EPSILON
}

#[test]
fn no_worse_anywhere_and_exact_where_plain_forms_cancel() {
    let random = &mut Random(7);
    for [name, value, exact, cancels] in rows(RULES) {
        let (formula, exact) = (Formula::new(name), Formula::new(exact));
        let (value, cancels): (f64, _) = (value.parse().expect("a value"), points(cancels));
        let (mut worst_plain, mut worst): (f64, f64) = (0.0, 0.0);
        for (c, powers) in [(1.0, [0, 0]), (-2.5, [0, 0]), (1.0, [1, 0]), (3.0, [1, 2])] {
            let mut arena = Arena::new();
            let [a, b] = [2, 3].map(|i| arena.symbol(Symbol(i)));
            let f = formula.build(&mut arena);
            let common = [(a, powers[0]), (b, powers[1])];
            let plain = difference(&mut arena, (f, value), c, &common);
            let mut form = plain;
            arena.stabilise(Purpose::Values, vec![&mut form]);
            if powers == [0, 0] || value != 0.0 {
                assert_ne!(form, plain, "{name} is left as it is");
            }
            for (x, y, near) in arguments(random, &cancels) {
                let (a, b) = (random.uniform(-2.0, 2.0), random.uniform(0.5, 2.0));
                let at = [x, y, a, b];
                let common = of(a).power(powers[0]) * of(b).power(powers[1]);
                let exact = of(c) * common * exact.evaluate([x, y, 0.0].map(of));
                let (before, after) = (computed(&arena, plain, &at), computed(&arena, form, &at));
                let size = exact.nearest();
                if !size.is_finite() || size.abs() < 1e-290 {
                    // outside of a function's domain, or too small to keep its digits
                    assert!(
                        size.is_nan() || after.abs() < 1e-289 || !before.is_finite(),
                        "{name}: {after} for {size} at {at:?}"
                    );
                    continue;
                }
                let (before, after) = (units(before, exact), units(after, exact));
                // the library's hypot is good to a unit only, and enters twice
                let more = if name.contains("hypot") { 3.0 } else { 2.0 };
                assert!(
                    after <= before + more || before.is_nan(),
                    "{name}: {after} units for {before} at {at:?}"
                );
                if near {
                    worst_plain = worst_plain.max(before);
                    worst = worst.max(after);
                }
            }
        }
        println!("{name:44} {worst_plain:10.2e} → {worst:.2}");
        // three or four roundings, two of them of functions
        assert!(worst <= 4.0, "{name}: {worst} units");
        assert!(cancels.is_empty() || worst_plain > 1e4, "{name}");
    }
}

/// Several differences share one constant: `2 − cos x − cos y`; also with a constant that is
/// rounded.
#[test]
fn several_differences_in_one_sum() {
    for (c, d) in [(1.0, 1.0), (9.8, 9.8), (0.1, 0.2), (0.7, 0.1)] {
        let mut arena = Arena::new();
        let [x, y] = [0, 1].map(|i| arena.symbol(Symbol(i)));
        let [cx, cy] = [x, y].map(|x| arena.call(Function::Cos, x));
        let mut sum = arena.sum(c + d, &[(-c, cx), (-d, cy)]);
        arena.stabilise(Purpose::Values, vec![&mut sum]);
        let found = computed(&arena, sum, &[1e-9, 3e-9, 0.0, 0.0]);
        let expected = (c + 9.0 * d) * 0.5e-18;
        assert!((found / expected - 1.0).abs() < 1e-15, "{found} {expected}");
        // no difference cancels if the constants do not add up
        let mut other = arena.sum(c + d + 1e-9, &[(-c, cx), (-d, cy)]);
        let before = other;
        arena.stabilise(Purpose::Values, vec![&mut other]);
        assert_eq!(other, before);
    }
}

/// Stable forms are equal to the plain functions, for random expressions that contain differences.
#[test]
fn are_the_same_functions() {
    let mut changed = 0;
    for seed in 0..600 {
        let random = &mut Random(seed);
        let at: Vec<f64> = (0..3).map(|_| random.uniform(0.2, 1.5)).collect();
        let mut recipe = grow(random, &at, 12);
        for _ in 0..4 {
            let len = 3 + recipe.len();
            let (a, x) = (random.below(len), random.below(len));
            let f = if random.below(6) == 0 {
                recipe.push(Make::Sum(1.0, vec![(1.0, x)]));
                Make::Call(Function::Sqrt, len)
            } else {
                Make::Call(random.of(FUNCTIONS), x)
            };
            recipe.push(f);
            let f = 2 + recipe.len();
            let power = random.of(&[1, 1, 2, -1, 3]);
            recipe.push(Make::Product(vec![(a, random.of(&[0, 1, 1])), (f, power)]));
            recipe.push(Make::Product(vec![(a, random.of(&[0, 1, 1]))]));
            let c = random.of(&[1.0, -2.0, 0.5]);
            recipe.push(Make::Sum(0.0, vec![(c, f + 1), (-c, f + 2), (1.0, x)]));
        }
        let exact: Vec<Bounded> = at.iter().map(|&x| Bounded::of(x)).collect();
        let expected = evaluate(&recipe, &exact);
        let mut arena = Arena::new();
        let variables: Vec<Symbol> = (0..3).map(Symbol).collect();
        let plain = build(&recipe, &variables, &mut arena);
        for purpose in [Purpose::Values, Purpose::Step] {
            let mut forms = plain.clone();
            arena.stabilise(purpose, forms.iter_mut().collect());
            changed += plain.iter().zip(&forms).filter(|(a, b)| a != b).count();
            let found = values(&arena, &forms, |s| exact[s.0 as usize]);
            for (found, expected) in found.iter().zip(&expected) {
                // a form may be sharp where the plain expression is not
                if expected.value.is_finite() && expected.error < 1e-6 && found.error < 1e-6 {
                    assert!(
                        found.agrees(*expected),
                        "seed {seed}: {found:?} for {expected:?}"
                    );
                }
            }
            if purpose == Purpose::Step {
                let (before, after) = (calls(&arena, &plain), calls(&arena, &forms));
                assert!(after <= before, "seed {seed}: {after} calls for {before}");
            }
        }
    }
    assert!(changed > 300, "{changed}");
}

/// Returns the number of calls of functions, except functions of angles.
fn calls(arena: &Arena, exprs: &[Expr]) -> usize {
    let counts = |&e: &Expr| match arena.node(e) {
        Node::Call(function, _) => !matches!(function, Function::Sin | Function::Cos),
        Node::Call2(..) => true,
        _ => false,
    };
    arena
        .reachable(exprs, |_| true)
        .iter()
        .filter(|e| counts(e))
        .count()
}

/// In a step, an exponential that is needed anyway is also used for its difference from one.
#[test]
fn steps_call_nothing_new() {
    let mut arena = Arena::new();
    let x = arena.symbol(Symbol(0));
    for function in [Function::Exp, Function::Cosh] {
        let value = arena.call(function, x);
        let difference = arena.sum(-1.0, &[(1.0, value)]);
        let plain = arena.mul(value, difference);
        for (purpose, root, same) in [
            (Purpose::Step, plain, true),
            (Purpose::Values, plain, false),
            (Purpose::Step, difference, false),
        ] {
            let mut form = root;
            arena.stabilise(purpose, vec![&mut form]);
            assert_eq!(form == root, same, "{function:?} for {purpose:?}");
        }
    }
}
