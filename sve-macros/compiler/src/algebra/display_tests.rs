//! Printed formulas have the same value as their expressions: a reader with the usual rules of
//! precedence evaluates them.

use std::collections::HashMap;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::display::Notation;
use super::reader::read;
use super::tests::formula::Formula;
use super::tests::{SYMBOLS, build, close, moderate, recipe};
use super::{Arena, Expr, Function, Sum, Symbol};
use crate::tests::rows;

const NAMES: [&str; SYMBOLS] = ["x", "y", "z"];

/// Letters for symbols, and a name for at most one expression.
struct Letters(Option<Expr>);

impl Notation for Letters {
    fn symbol(&self, symbol: Symbol) -> String {
        NAMES[symbol.0 as usize].to_owned()
    }

    fn place(&self, _: Symbol) -> u8 {
        0
    }

    fn name(&self, expr: Expr) -> Option<&str> {
        (self.0 == Some(expr)).then_some("w")
    }
}

/// Returns the values of the letters.
fn letters(at: &[f64]) -> HashMap<String, f64> {
    let names = NAMES.into_iter().map(ToOwned::to_owned);
    names.zip(at.iter().copied()).collect()
}

/// Returns the value of a formula. All of its names must be known.
fn value_of(text: &str, values: &HashMap<String, f64>) -> f64 {
    read(text, values).unwrap_or_else(|| panic!("what is in {text}?"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, max_global_rejects: 100_000, rng_seed: RngSeed::Fixed(23), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_formula_means_its_expression(recipe in recipe(), at in prop::collection::vec(-3.0..3.0f64, SYMBOLS)) {
        let mut arena = Arena::new();
        let made = build(&recipe, &at, &mut arena);
        prop_assume!(moderate(&made));
        let (root, value) = made[made.len() - 1];
        let Some(text) = arena.display(root, 2000, &Letters(None)) else { return Ok(()) };
        let read = value_of(&text.text, &letters(&at));
        prop_assert!(close(read, value, 1e3), "{} is {read}, not {value}", text.text);
    }

    /// One of the subexpressions is named, in the whole and in the parts of a sum.
    #[test]
    fn names_stand_for_their_expressions(recipe in recipe(), at in prop::collection::vec(-3.0..3.0f64, SYMBOLS), which in 0..1000usize) {
        let mut arena = Arena::new();
        let made = build(&recipe, &at, &mut arena);
        prop_assume!(moderate(&made));
        let (root, value) = made[made.len() - 1];
        let (named, w) = made[which % made.len()];
        let notation = Letters(Some(named));
        let mut values = letters(&at);
        values.insert("w".to_owned(), w);
        let definition = arena.display_definition(named, 2000, &notation);
        let Some(definition) = definition else { return Ok(()) };
        let read = value_of(&definition.text, &values);
        prop_assert!(close(read, w, 1e3), "{} is {read}, not {w}", definition.text);

        let Some(text) = arena.display(root, 2000, &notation) else { return Ok(()) };
        let read = value_of(&text.text, &values);
        prop_assert!(close(read, value, 1e3), "{} is {read}, not {value}", text.text);
        prop_assert_eq!(text.text.contains('w'), text.named.contains(&named));

        // a named sum is not expanded into its parts
        prop_assume!(named != root);
        let mut sum = Sum::default();
        sum.add(-3.0, root, &arena);
        sum.add(4.0, root, &arena);
        let Some(text) = arena.display_sum(&sum, 2000, &notation) else { return Ok(()) };
        let read = value_of(&text.text, &values);
        prop_assert!(close(read, value, 1e3), "{} is {read}, not {value}", text.text);

        let Some((negative, factor)) = arena.display_factor(&sum, 2000, &notation) else { return Ok(()) };
        let sign = if negative { -1.0 } else { 1.0 };
        let read = sign * value_of(&format!("2·{}", factor.text), &values) / 2.0;
        prop_assert!(close(read, value, 1e3), "{} is {read}, not {value}", factor.text);
    }

    #[test]
    fn numbers_are_themselves(c in prop_oneof![
        1e-9..1e-3f64, 1e-3..1e3f64, 1e3..1e12f64,
        (1..100u32, 1..100u32).prop_map(|(a, b)| f64::from(a) / f64::from(b)),
        (1..10u32, 1..10u32).prop_map(|(a, b)| f64::from(a) * std::f64::consts::PI / f64::from(b)),
    ], negative in any::<bool>()) {
        let c = if negative { -c } else { c };
        let mut arena = Arena::new();
        let x = arena.symbol(Symbol(0));
        let term = arena.scale(c, x);
        let text = arena.display(term, 2000, &Letters(None)).unwrap().text;
        let read = value_of(&text, &letters(&[1.0, 0.0, 0.0]));
        prop_assert!((read - c).abs() <= 4.0 * f64::EPSILON * c.abs(), "{text} is not {c}");
    }
}

/// Formulas are printed in the usual notation.
#[test]
fn the_usual_way_of_writing() {
    for [formula, expected] in rows(
        "0.5 * (x.powi(2) / y) - 0.5 * z → x²/(2·y) − z/2
        -x + 2.0 * y → 2·y − x
        -1.0 * (1.0 / y / z) → −1/(y·z)
        1.5 * x - 1.0 → 1.5·x − 1
        x / (1.0 + y - 3.0 * z).powi(2) * x.sin().powi(3) → x·sin(x)³/(1 + y − 3·z)²
        x.sqrt() * x / (1.0 + y - 3.0 * z).sqrt() → x·√x/√(1 + y − 3·z)
        6.283185307179586 * x → 2·π·x
        0.6666666666666666 * x → 2·x/3
        1.38e-23 * x → 1.38·10⁻²³·x
        0.0 → 0",
    ) {
        let mut arena = Arena::new();
        let expr = Formula::new(formula).build(&mut arena);
        let found = arena.display(expr, 100, &Letters(None)).unwrap().text;
        assert_eq!(found, expected, "{formula}");
    }
}

/// A limit is kept to the character, and a deep expression is not walked as a tree.
#[test]
fn limits() {
    let mut arena = Arena::new();
    let x = arena.symbol(Symbol(0));
    let y = arena.symbol(Symbol(1));
    let sum = arena.add(x, y);
    let letters = Letters(None);
    assert_eq!(arena.display(sum, 5, &letters).unwrap().text, "x + y");
    assert!(arena.display(sum, 4, &letters).is_none());
    let mut tower = sum;
    for _ in 0..10_000 {
        let sine = arena.call(Function::Sin, tower);
        let cosine = arena.call(Function::Cos, tower);
        tower = arena.mul(sine, cosine);
    }
    assert!(arena.display(tower, usize::MAX, &letters).is_none());
    assert_eq!(arena.operations(&[tower]), 30_001);
}
