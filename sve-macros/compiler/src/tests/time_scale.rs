//! The Lagrangian in a scaled time, and the time of a step: the derivative of the discrete action
//! by the energy.

use std::collections::HashMap;

use crate::algebra::{Arena, Symbol};
use crate::backend::rust::nodes_between;
use crate::catalogue::{Nodes, Rule};
use crate::errors::Errors;
use crate::interpret;
use crate::model::{Family, Meaning, Model, Unknown};
use crate::rules::action::{Terms, discretise};
use crate::rules::gauss::Quadrature;
use crate::syntax::parse;
use crate::tests::tokens;

const SYSTEM: &str = "impl P {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] + q[0].exp() * v[1] * v[1] + q[1] * v[0] - self.k * q[0].cos()
            - (1.0 - 0.01 * v[0] * v[0]).sqrt() + 3.0
    }
    #[time_scale]
    fn scale(&self, q: [f64; 2]) -> f64 { 1.0 + q[0] * q[0] + (0.5 * q[1]).exp() }
}";

fn model(source: &str, arena: &mut Arena) -> Model {
    let block = syn::parse2(tokens(source)).expect("a block");
    let mut errors = Errors::new();
    let read = parse::annotated(tokens("midpoint"), block, &mut errors);
    let model = read.and_then(|block| interpret::interpret(&block, arena, &mut errors));
    errors.finish(model).expect("no mistake").expect("a model")
}

/// A value for each symbol.
fn at(symbol: Symbol) -> f64 {
    0.3 + 0.4 * f64::sin(f64::from(symbol.0) * 1.7)
}

#[test]
fn the_lagrangian_is_that_of_the_scaled_time() {
    let mut arena = Arena::new();
    let scaled = model(SYSTEM, &mut arena);
    let plain = model(&SYSTEM.replace("#[time_scale]", ""), &mut arena);
    let scale = scaled.time_scale.expect("a time scale");
    let energy = scaled.symbols.energy.expect("an energy");
    let s = arena.evaluate(scale, at);
    // the symbols of another model, by their meanings
    let value = |symbol: Symbol| match plain.symbols.meaning(symbol) {
        Meaning::Position(i) => at(scaled.q[*i]),
        Meaning::Velocity(i) => at(scaled.v[*i]) / s,
        _ => at(k(&scaled)),
    };
    let lagrangian = arena.evaluate(plain.lagrangian, value);
    let expected = s * (lagrangian + at(energy));
    let found = arena.evaluate(scaled.lagrangian, at);
    assert!((found - expected).abs() < 1e-14, "{found} {expected}");
}

/// The parameter k.
fn k(model: &Model) -> Symbol {
    let is_k = |&s: &Symbol| model.symbols.name(s) == "k";
    model.symbols.parameters().find(is_k).expect("k")
}

#[test]
fn the_time_of_a_step_is_the_derivative_of_its_action_by_the_energy() {
    for rule in Rule::all() {
        if matches!(rule.nodes, Nodes::Taylor) {
            continue;
        }
        let mut arena = Arena::new();
        let model = model(SYSTEM, &mut arena);
        let mut symbols = model.symbols.clone();
        let action = discretise(rule, &model, None, Terms::NONE, &mut symbols, &mut arena);
        let energy = model.symbols.energy.expect("an energy");
        let slope = arena.diff(action.value, energy);
        let found = arena.evaluate(slope, at);
        let h = at(action.h);
        let is_velocity = |&s: &Symbol| {
            let meaning = symbols.meaning(s);
            matches!(
                meaning,
                Meaning::Unknown(Unknown {
                    family: Family::StageVelocity,
                    ..
                })
            )
        };
        let all = (0..symbols.meanings().len() as u32).map(Symbol);
        let velocities: Vec<Symbol> = all.filter(is_velocity).collect();
        let nodes: Vec<(f64, [f64; 2])> = match rule.nodes {
            Nodes::Gauss { stages } => {
                let Quadrature { a, b, .. } = Quadrature::new(stages);
                let place = |i: usize, n: usize| {
                    let moves = (0..stages).map(|j| a[i][j] * at(velocities[2 * j + n]));
                    at(action.start_q[n]) + h * moves.sum::<f64>()
                };
                let node = |i| (b[i], [place(i, 0), place(i, 1)]);
                (0..stages).map(node).collect()
            }
            _ => {
                let between = nodes_between(rule).into_iter();
                let place =
                    |c: f64, n: usize| at(action.start_q[n]) + c * at(action.displacement[n]);
                between
                    .map(|(b, c)| (b, [place(c, 0), place(c, 1)]))
                    .collect()
            }
        };
        let scale = model.time_scale.expect("a time scale");
        let of_q = |q: [f64; 2]| {
            let by: HashMap<Symbol, f64> = model.q.iter().copied().zip(q).collect();
            arena.evaluate(scale, |symbol| by[&symbol])
        };
        let expected: f64 = nodes.iter().map(|&(b, q)| h * b * of_q(q)).sum();
        let error = (found - expected).abs();
        assert!(error < 1e-14, "{}: {found} {expected}", rule.name());
    }
}

/// Terms that are quadratic in velocities are divided by s, not multiplied by s and divided by s².
#[test]
fn kinetic_energies_are_divided_once() {
    let mut arena = Arena::new();
    let source = "impl P {
        fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * self.m * v * v - q * q }
        #[time_scale]
        fn scale(&self, q: f64) -> f64 { 1.0 + q * q }
    }";
    let model = model(source, &mut arena);
    let text = model.symbols.formula(model.lagrangian, 200, &arena);
    let text = text.expect("a short formula");
    assert!(!text.contains("(1 + q²)²"), "{text}");
}
