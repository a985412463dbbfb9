//! Every rewriting rule of the constructors, one row each, over signs, zeros of both signs,
//! subnormal and huge numbers.
//!
//! Plain arithmetic evaluates a formula, and the algebra builds it. The value of the built
//! expression equals the plain value to rounding, underflow included, or it is not finite: no rule
//! may give a wrong number. At moderate arguments it is finite if the plain value is. Outside of
//! the domain of the formula it is not a number, except for the rules marked as wider.

use super::formula::Formula;
use super::number::{Bounded, Number};
use super::recipe::{Random, values};
use crate::algebra::{Arena, Symbol};
use crate::tests::rows;

type X = Bounded;

/// The rules by name, each with a formula that it rewrites, and whether the result is `equal` to
/// the formula or has a `wider` domain.
const RULES: &str = r"
// sums
c + d folds → 0.1 + 0.2 → equal
x + 0 → x + 0.0 → equal
like terms → 2.0 * x + y + -0.75 * x → equal
x − x → x - x → wider
0·x → 0.0 * x → wider
sums open → x + -0.5 * (3.0 * y + 2.0) + z → equal
// products
c·d folds → 3.0 * (x * 0.7) → equal
c^k folds → x / 3.0.powi(2) → equal
x^j x^k → x.powi(3) * x.powi(-2) → wider
x/x → x / x → wider
x⁰ → x.powi(0) → equal
x¹ → x.powi(1) → equal
products open → (x * y.powi(2)).powi(2) * z → equal
(c x)^k → (-3.0 * x).powi(3) * y → equal
1/(c x) → y / (-4.0 * x) → equal
sums in products lead with [1, 2) → (-6.0 * x + y).powi(3) * z → equal
(x − y)/(y − x) → (x - y) / (y - x) → wider
0·product → x * 0.0 * y → wider
// roots
√x² → x.sqrt().powi(2) → wider
√x³ → x.sqrt().powi(3) → equal
√x⁻³ → x.sqrt().powi(-3) → equal
x/√x → x / x.sqrt() → wider
√x/x → x.sqrt() / x → wider
x² y³/√(x² y) → x.powi(2) * y.powi(3) / (x.powi(2) * y).sqrt() → wider
(x − y)/√(y − x) → (x - y) / (y - x).sqrt() → wider
√(x²) stays → x.powi(2).sqrt() → equal
// functions
f(c) folds → 0.7.exp() → equal
x^(integer) is a product → x.powf(-3.0) → equal
x^(half-integer) is √ and a product → x.powf(2.5) → equal
x^(−½) is 1/√x → x.powf(-0.5) → equal
x^(quarter) is roots and a product → x.powf(0.75) → equal
x^(−quarter) → x.powf(-1.25) → equal
x^c is powf → x.powf(1.3) → equal
named results are what they are of → (x + y).named().named() + y → equal
";

/// Returns a random number: signed, zero, at the ends of the range, a power of two, or any other.
fn number(random: &mut Random) -> f64 {
    let special = [
        0.0,
        1.0,
        1.0 + f64::EPSILON,
        1.0 - f64::EPSILON / 2.0,
        2.0,
        3.0,
        0.5,
        f64::from_bits(1),
        f64::MIN_POSITIVE,
        f64::MIN_POSITIVE * 0.75,
        1e-160,
        1e160,
        1e300,
        f64::MAX,
    ];
    let size = match random.below(3) {
        0 => random.of(&special),
        1 => random.uniform(0.0, 3.0),
        _ => random.uniform(-700.0, 700.0).exp(),
    };
    size * random.of(&[1.0, -1.0])
}

/// Returns whether a rule's intermediate results can neither overflow nor underflow.
fn is_moderate(x: f64) -> bool {
    x == 0.0 || (1e-40..1e40).contains(&x.abs())
}

#[test]
fn hold_over_signs_zeros_and_ranges() {
    let random = &mut Random(3);
    for [name, formula, domain] in rows(RULES) {
        let formula = Formula::new(formula);
        let mut arena = Arena::new();
        let right = formula.build(&mut arena);
        let (mut compared, mut outside) = (0, 0);
        for _ in 0..3000 {
            let at = [(); 3].map(|()| number(random));
            let left = formula.evaluate(at.map(X::of));
            let found = values(&arena, &[right], |s| X::of(at[s.0 as usize]))[0];
            let what = || format!("{name}: {found:?} for {left:?} at {at:?}");
            if left.value.is_nan() && at.iter().all(|&x| is_moderate(x)) {
                outside += 1;
                assert!(domain == "wider" || found.value.is_nan(), "{}", what());
            }
            if !left.value.is_finite() || !left.error.is_finite() {
                continue;
            }
            if at.iter().all(|&x| is_moderate(x)) {
                assert!(found.value.is_finite(), "{}", what());
            }
            if found.value.is_finite() {
                compared += 1;
                // a bound that is not finite would accept anything
                assert!(!found.error.is_finite() || found.agrees(left), "{}", what());
            }
        }
        println!("{name:36} {compared} compared, {outside} outside of the domain");
        assert!(compared > 500, "{name}: {compared}");
    }
}

/// Even and odd functions take signs out of their arguments of all sizes, and other functions do
/// not.
#[test]
fn parity_over_signs_zeros_and_ranges() {
    let random = &mut Random(5);
    for &function in super::recipe::FUNCTIONS {
        let mut arena = Arena::new();
        let x = arena.symbol(Symbol(0));
        let minus = arena.neg(x);
        let mirrored = arena.call(function, minus);
        for _ in 0..1000 {
            let at = number(random);
            // Not every odd function of the standard library is odd: next to a singularity its
            // value may belong to an argument that is rounded differently.
            let mut argument = X::of(-at);
            argument.error = f64::EPSILON * at.abs();
            let left = argument.call(function);
            let found = values(&arena, &[mirrored], |_| X::of(at))[0];
            if left.value.is_finite() {
                // at the end of a domain the slope is infinite, so the values must be equal
                let agrees = found.agrees(left) || found.value == left.value;
                assert!(agrees, "{function:?}: {found:?} {left:?} at {at}");
            } else {
                let same = found.value.is_nan() == left.value.is_nan();
                assert!(
                    same && !found.value.is_finite(),
                    "{function:?}: {found:?} {left:?} at {at}"
                );
            }
        }
    }
}
