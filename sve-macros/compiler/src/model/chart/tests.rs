//! The functions of the chart against those of the angle, and their rules of differentiation
//! against differences.

use super::{Chart, Momenta};
use crate::algebra::{Arena, Expr, Symbol};

/// Angles up to the limit of a step.
const ANGLES: [f64; 8] = [1e-9, 1e-3, 0.3, 1.0, 2.0, 3.0, 3.5, 4.0];

const AXIS: [f64; 3] = [0.48, -0.64, 0.6];

/// The chart at three symbols.
fn chart(arena: &mut Arena) -> (Vec<Expr>, Chart, Momenta) {
    let x: Vec<Expr> = (0..3).map(|k| arena.symbol(Symbol(k))).collect();
    let (chart, momenta) = (Chart::new(&x, arena), Momenta::new(&x, arena));
    (x, chart, momenta)
}

#[test]
fn the_functions_are_those_of_the_angle() {
    let mut arena = Arena::new();
    let (_, chart, momenta) = chart(&mut arena);
    for angle in ANGLES {
        let at = |s: Symbol| angle * AXIS[s.0 as usize];
        let a = if angle < 1e-6 {
            1.0
        } else {
            0.5 * angle / (0.5 * angle).tan()
        };
        let t = (0.25 * angle).tan() / angle;
        for (found, expected) in [
            (chart.t, t),
            (chart.momenta.a, a),
            (momenta.a, a),
            (chart.momenta.b, arena.evaluate(momenta.b, at)),
        ] {
            let found = arena.evaluate(found, at);
            let error = (found - expected).abs();
            assert!(
                error < 2e-15 * expected.abs().max(1.0),
                "{angle}: {found} {expected}"
            );
        }
    }
}

/// Compares derivatives along a line with differences. `of_line` has the numbers along it.
fn assert_derivatives(exprs: &[Expr], at: impl Fn(f64, Symbol) -> f64, arena: &mut Arena) {
    let step = 1e-3;
    for &expr in exprs {
        let slopes = [0, 1, 2].map(|k| arena.diff(expr, Symbol(k)));
        for angle in ANGLES {
            let value = |angle: f64| arena.evaluate(expr, |s| at(angle, s));
            let outer = (value(angle + step) - value(angle - step)) * 0.75;
            let middle = (value(angle + 2.0 * step) - value(angle - 2.0 * step)) * -0.15;
            let inner = (value(angle + 3.0 * step) - value(angle - 3.0 * step)) / 60.0;
            let expected = (outer + middle + inner) / step;
            let along = slopes.iter().enumerate().map(|(k, &slope)| {
                let rate = at(1.0, Symbol(k as u32)) - at(0.0, Symbol(k as u32));
                rate * arena.evaluate(slope, |s| at(angle, s))
            });
            let found: f64 = along.sum();
            let error = (found - expected).abs();
            assert!(
                error < 1e-11 * expected.abs().max(1.0),
                "{angle}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_rules_of_differentiation_are_those_of_differences() {
    let mut arena = Arena::new();
    let (x, chart, momenta) = chart(&mut arena);
    let middle = chart.midpoint(&x.repeat(3), &mut arena).entries;
    let (a, b) = (chart.momenta.a, chart.momenta.b);
    let mut all = vec![chart.u, chart.t, a, b, momenta.a, momenta.b];
    all.extend(middle);
    let at = |angle: f64, s: Symbol| angle * AXIS[s.0 as usize];
    assert_derivatives(&all, at, &mut arena);
}

/// An increment can depend on the attitude of another body, whose chart then stands within this
/// one.
#[test]
fn the_rules_hold_for_an_increment_that_contains_another_chart() {
    let mut arena = Arena::new();
    let (x, other, _) = chart(&mut arena);
    let inner = other.midpoint(&x.repeat(3), &mut arena).entries;
    let increment: Vec<Expr> = (0..3).map(|k| arena.add(x[k], inner[3 * k])).collect();
    let outer = Chart::new(&increment, &mut arena);
    let entries = outer.midpoint(&x.repeat(3), &mut arena).entries;
    let mut all = vec![outer.u, outer.t, outer.momenta.a, outer.momenta.b];
    all.extend(entries);
    let at = |angle: f64, s: Symbol| 0.3 * angle * AXIS[s.0 as usize];
    assert_derivatives(&all, at, &mut arena);
}
