//! Derivatives of random expressions, first and second, against forward-mode evaluation of their
//! descriptions; and forward-mode evaluation against differences.

use super::number::{Bounded, Dual, Number};
use super::recipe::{Make, Random, build, evaluate, grow, values};
use crate::algebra::{Arena, Symbol};

/// Numbers of variables.
const SYMBOLS: usize = 3;

const CASES: u64 = 1500;

/// Returns a random expression with a point.
fn case(seed: u64) -> (Vec<Make>, Vec<f64>) {
    let random = &mut Random(seed);
    let at: Vec<f64> = (0..SYMBOLS)
        .map(|_| random.uniform(0.2, 1.5) * random.of(&[1.0, 1.0, -1.0]))
        .collect();
    let length = 3 + random.below(34);
    let recipe = grow(random, &at, length);
    (recipe, at)
}

/// Returns the value of the last entry, its derivatives in two variables and its mixed second
/// derivative.
fn forward<T: Number>(recipe: &[Make], at: &[T], i: usize, j: usize) -> [T; 4] {
    let unit = |a: usize, b: usize| f64::from(u8::from(a == b));
    let at: Vec<_> = (0..SYMBOLS)
        .map(|k| Dual {
            value: Dual::new(at[k], unit(k, i)),
            slope: Dual::of(unit(k, j)),
        })
        .collect();
    let all = evaluate(recipe, &at);
    let last = all[all.len() - 1];
    [
        last.value.value,
        last.value.slope,
        last.slope.value,
        last.slope.slope,
    ]
}

#[test]
fn agree_with_forward_evaluation() {
    let (mut compared, mut sharp) = (0, 0);
    for seed in 0..CASES {
        let (recipe, at) = case(seed);
        let exact: Vec<Bounded> = at.iter().map(|&x| Bounded::of(x)).collect();
        let mut arena = Arena::new();
        let symbols: Vec<Symbol> = (0..SYMBOLS as u32).map(Symbol).collect();
        let whole = *build(&recipe, &symbols, &mut arena).last().expect("one");
        let (i, j) = (seed as usize % SYMBOLS, seed as usize / SYMBOLS % SYMBOLS);
        let first = arena.diff(whole, symbols[i]);
        let other = arena.diff(whole, symbols[j]);
        let second = arena.diff(first, symbols[j]);
        let found = values(&arena, &[whole, first, other, second], |s| {
            exact[s.0 as usize]
        });
        let expected = forward(&recipe, &exact, i, j);
        for (order, (found, expected)) in found.iter().zip(&expected).enumerate() {
            compared += 1;
            if !(found.is_sharp() && expected.is_sharp()) {
                continue;
            }
            sharp += 1;
            assert!(
                found.agrees(*expected),
                "seed {seed}, entry {order}: {found:?} for {expected:?}\n{recipe:?} at {at:?}"
            );
        }
    }
    println!("{sharp} of {compared} comparisons are sharp");
    assert!(10 * sharp > 8 * compared, "{sharp} of {compared}");
}

/// Returns the derivative by central differences with two Richardson extrapolations, and the change
/// by the last extrapolation.
fn richardson(f: impl Fn(f64) -> f64, x: f64) -> (f64, f64) {
    let central = |h: f64| (f(x + h) - f(x - h)) / (2.0 * h);
    let [a, b, c] = [1.0, 0.5, 0.25].map(|k| central(k * 2e-3));
    let (ab, bc) = ((4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0);
    let best = (16.0 * bc - ab) / 15.0;
    (best, (best - bc).abs())
}

#[test]
fn forward_evaluation_agrees_with_differences() {
    let (mut compared, mut converged) = (0, 0);
    for seed in 0..CASES {
        let (recipe, at) = case(seed);
        let (i, j) = (seed as usize % SYMBOLS, seed as usize / SYMBOLS % SYMBOLS);
        let moved = |x: f64| {
            let mut at = at.clone();
            at[j] = x;
            forward(&recipe, &at, i, j)
        };
        let expected = moved(at[j]);
        // the derivative in j of the value, and of the derivative in i
        for (of, is) in [(0, 2), (1, 3)] {
            compared += 1;
            let (found, change) = richardson(|x| moved(x)[of], at[j]);
            // skipped if a singularity is so near that the differences do not converge
            if change.is_nan() || change > 1e-4 * (1.0 + found.abs()) {
                continue;
            }
            converged += 1;
            let bound = 1e-9 * (1.0 + expected[of].abs() + found.abs()) + change;
            assert!(
                (found - expected[is]).abs() <= bound,
                "seed {seed}: {found} for {}",
                expected[is]
            );
        }
    }
    println!("{converged} of {compared} differences converge");
    assert!(10 * converged > 6 * compared, "{converged} of {compared}");
}
