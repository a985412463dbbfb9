//! A scheduled program, run by a small interpreter, computes the values of its expressions.

use std::collections::HashMap;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::algebra::tests::number::Number;
use crate::algebra::tests::recipe::{Make, build};
use crate::algebra::{Arena, Function, Symbol};
use crate::model::{Family, Meaning, Quantity, Symbols, Unknown};
use crate::program::{Operation, Program, Scheduler, Tier, Value, operands};

/// Runs all instructions in order. The type of numbers is generic.
pub(crate) fn run<T: Number>(program: &Program, at: &dyn Fn(Symbol) -> T) -> HashMap<Value, T> {
    let mut values: HashMap<Value, T> = HashMap::new();
    let mut pairs: HashMap<Value, (T, T)> = HashMap::new();
    for (value, instruction) in program.all() {
        for operand in operands(instruction.operation) {
            assert!(
                values.contains_key(&operand) || pairs.contains_key(&operand),
                "operands come first"
            );
            assert!(
                program.get(operand).tier.rank() <= instruction.tier.rank(),
                "operands are known"
            );
        }
        let of = |v: Value| values[&v];
        let sin_cos = |x: T| (x.call(Function::Sin), x.call(Function::Cos));
        let result = match instruction.operation {
            Operation::Constant(bits) => T::of(f64::from_bits(bits)),
            Operation::Input(symbol) => at(symbol),
            Operation::Add(a, b) => of(a).plus(of(b)),
            Operation::Sub(a, b) => of(a).minus(of(b)),
            Operation::Mul(a, b) => of(a).times(of(b)),
            Operation::Div(a, b) => of(a).over(of(b)),
            Operation::Neg(a) => of(a).scale(-1.0),
            Operation::Abs(a) => of(a).scale(of(a).value().signum()),
            Operation::Recip(a) => T::of(1.0).over(of(a)),
            Operation::Call(function, a) => of(a).call(function),
            Operation::Call2(function, a, b) => of(a).call2(function, of(b)),
            Operation::SinCos(a) => {
                pairs.insert(value, sin_cos(of(a)));
                continue;
            }
            Operation::AngleAddition(sin, cos, by) => {
                let (sin, cos, (s, c)) = (of(sin), of(cos), sin_cos(of(by)));
                let sum = (
                    sin.times(c).plus(cos.times(s)),
                    cos.times(c).minus(sin.times(s)),
                );
                pairs.insert(value, sum);
                continue;
            }
            Operation::SinOf(pair) => pairs[&pair].0,
            Operation::CosOf(pair) => pairs[&pair].1,
        };
        values.insert(value, result);
    }
    values
}

/// A symbol of each tier.
pub(crate) fn symbols() -> (Symbols, Vec<Symbol>) {
    let mut symbols = Symbols::default();
    let all = vec![
        symbols.declare(Meaning::Parameter {
            name: "m".to_owned(),
            access: quote::quote!(self.m),
            input: None,
        }),
        symbols.declare(Meaning::StepSize),
        symbols.declare(Meaning::Wiener(0)),
        symbols.declare(Meaning::Start(Quantity::Position, 0)),
        symbols.declare(Meaning::Start(Quantity::Momentum, 0)),
        symbols.declare(Unknown::of(Family::Velocity)(0)),
    ];
    (symbols, all)
}

fn make() -> impl Strategy<Value = Make> {
    let any = 0..1000usize;
    let coefficient = prop::sample::select(vec![1.0, -1.0, 0.5, 2.0, -3.0, 0.0]);
    let functions = vec![
        Function::Sin,
        Function::Cos,
        Function::Exp,
        Function::Tanh,
        Function::Atan,
    ];
    prop_oneof![
        4 => (coefficient.clone(), prop::collection::vec((coefficient, any.clone()), 0..6)).prop_map(|(c, t)| Make::Sum(c, t)),
        4 => prop::collection::vec((any.clone(), -3..4i32), 0..5).prop_map(Make::Product),
        2 => (prop::sample::select(functions), any.clone()).prop_map(|(f, x)| Make::Call(f, x)),
        1 => any.prop_map(Make::Opaque),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn program_agrees_with_evaluation(
        recipe in prop::collection::vec(make(), 1..20),
        at in prop::collection::vec(prop_oneof![0.3..2.0f64, -2.0..-0.3f64], 6),
    ) {
        let mut arena = Arena::new();
        let (table, inputs) = symbols();
        let made = build(&recipe, &inputs, &mut arena);
        let value = |s: Symbol| at[s.0 as usize];
        let expected: Vec<f64> = made.iter().map(|&e| arena.evaluate(e, value)).collect();
        let tame = |x: &f64| x.is_finite() && x.abs() < 1e3 && (*x == 0.0 || x.abs() > 1e-3);
        prop_assume!(expected.iter().all(tame));

        let tiers = HashMap::from([(inputs[5], Tier::Iterate(0))]);
        let mut scheduler = Scheduler::new(&arena, &table, tiers, &made);
        let results = scheduler.values(&made);
        let program = scheduler.finish(&results);
        let values = run(&program, &value);
        let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for (result, expected) in results.iter().zip(&expected) {
            let found = values[result];
            // reciprocals of numbers above 1e-3, cubed at most
            prop_assert!((found - expected).abs() <= 1e-7 * (1.0 + size), "{found} {expected}");
        }
    }
}
