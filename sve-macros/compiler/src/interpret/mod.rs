//! Bodies → expressions, by symbolic execution; the errors of meaning.
//!
//! Input: the annotated block. Output: the [`Model`]. A body is run with expressions for numbers: loops are unrolled, helpers
//! inlined, arrays, tuples, vectors and matrices are values. After a mistake the run goes on with a poisoned value, so that each mistake is
//! reported once and independent ones together.

mod branches;
mod calls;
mod closures;
mod constants;
mod conversions;
mod entries;
mod expressions;
mod fields;
mod floats;
mod helpers;
mod indices;
mod integers;
mod matrices;
mod operators;
mod parts;
mod pattern;
mod places;
mod references;
mod sequences;
mod statements;
mod types;
mod value;

use std::collections::{HashMap, HashSet};

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::spanned::Spanned;

use crate::algebra::{Arena, Expr, Symbol};
use crate::errors::Errors;
use crate::syntax::parse::Annotated;
use crate::system::model::{Model, Symbols};
use branches::Leaving;
use fields::FieldPath;
use matrices::MatrixType;
use value::Value;

/// Statements and expressions that one expansion may execute.
const STEPS: usize = 2_000_000;

/// Expressions that one expansion may create while bodies are run.
const NODES: usize = 30_000;

/// State of a run.
pub(crate) struct Lowering<'a> {
    arena: &'a mut Arena,
    symbols: Symbols,
    parameters: HashMap<String, Symbol>,
    parameter_names: HashSet<String>,
    /// Parameters in the order of their first use.
    paths: Vec<FieldPath>,
    /// The paths that are read as constants of `std::f64::consts` and may lead elsewhere.
    constants: Vec<(TokenStream, f64)>,
    /// Fields that are used as vectors or matrices of a known type.
    vectors: HashMap<String, MatrixType>,
    /// Entries of vectors and matrices that are written in several ways, each with the one way in which generated code reads it.
    spellings: HashMap<String, FieldPath>,
    block: &'a Annotated,
    errors: Errors,
    /// Variables, innermost scope last.
    scopes: Vec<HashMap<String, Value>>,
    /// Helpers and constants being evaluated, to notice recursion.
    active: Vec<String>,
    /// Scopes below this one are around the closure that is being run.
    floor: usize,
    /// The function or closure that is being run, by number: references of another one are out of sight.
    frame: usize,
    /// Numbers given to functions and closures.
    frames: usize,
    /// A closure of an iterator is being run, which Rust runs only where its results are taken.
    is_lazy: bool,
    /// The round of a loop is being left.
    leaving: Option<Leaving>,
    /// Helpers in which a mistake has been reported.
    broken: HashSet<String>,
    /// The last parameter that was an operand as a number.
    taken_for_number: Option<FieldPath>,
    steps: usize,
    /// Expressions that there were before this run.
    nodes: usize,
    /// Nesting of the expression being evaluated.
    depth: usize,
}

/// Runs all parts of the block; mistakes join those that `errors` has already.
///
/// The type of a field may show only after its entries have been read. If an entry was read in several ways, the block is run
/// once more with one symbol for the entry.
pub(crate) fn interpret(
    block: &Annotated,
    arena: &mut Arena,
    errors: &mut Errors,
) -> Option<Model> {
    let mut lowering = Lowering::new(block, arena, std::mem::take(errors));
    let mut model = lowering.model();
    lowering.spellings = lowering.one_spelling_an_entry();
    if lowering.errors.count() == 0 && !lowering.spellings.is_empty() {
        lowering = lowering.anew();
        model = lowering.model();
    }
    *errors = lowering.errors;
    let symbols = lowering.symbols;
    if model.is_none() && errors.count() == 0 {
        errors.push(
            block.lagrangian.name.span(),
            "this Lagrangian cannot be read",
        );
    }
    model.map(|parts| Model { symbols, ..parts })
}

impl<'a> Lowering<'a> {
    fn new(block: &'a Annotated, arena: &'a mut Arena, errors: Errors) -> Self {
        Self {
            nodes: arena.len(),
            arena,
            symbols: Symbols::default(),
            parameters: HashMap::new(),
            parameter_names: HashSet::new(),
            paths: Vec::new(),
            constants: Vec::new(),
            vectors: HashMap::new(),
            spellings: HashMap::new(),
            block,
            errors,
            scopes: Vec::new(),
            floor: 0,
            frame: 0,
            frames: 0,
            is_lazy: false,
            leaving: None,
            active: Vec::new(),
            broken: HashSet::new(),
            taken_for_number: None,
            steps: 0,
            depth: 0,
        }
    }

    /// The state before a run that knows the spellings of this one.
    fn anew(self) -> Self {
        Self {
            spellings: self.spellings,
            ..Self::new(self.block, self.arena, self.errors)
        }
    }
}

impl Lowering<'_> {
    /// The expression of a number, or an error at `at`.
    fn scalar(&mut self, value: &Value, at: &impl Spanned) -> Option<Expr> {
        match value {
            Value::Scalar(expr) => Some(*expr),
            Value::Field(path) if path.is_self() => {
                self.errors.push(
                    at.span(),
                    "`self` is not a number: write one of its fields, `self.name`",
                );
                None
            }
            Value::Field(path) => Some(self.parameter(path)),
            Value::Converted(inner) => match &**inner {
                Value::Int(i) => Some(self.arena.constant(i.value as f64)),
                inner => self.scalar(inner, at),
            },
            Value::Place(_) => {
                let inner = self.followed(value).clone();
                match inner {
                    Value::Place(_) => None,
                    inner => self.scalar(&inner, at),
                }
            }
            Value::Generated(_) => {
                self.errors.push(at.span(), conversions::NO_LENGTH);
                None
            }
            Value::Poison => None,
            Value::Int(i) => {
                self.errors.push(at.span(), integer(i.value));
                None
            }
            Value::Array(_)
            | Value::Matrix(_)
            | Value::Tuple(_)
            | Value::Sequence(_)
            | Value::Closure(_)
            | Value::Unit
            | Value::Unset => {
                let hint = match value {
                    Value::Array(_) => ": take an entry, such as `x[0]`",
                    Value::Matrix(m) if m.ty.is_vector() => {
                        ": take an entry, such as `v[0]`, or a number such as `v.norm_squared()`"
                    }
                    Value::Matrix(_) => ": take an entry, such as `m[(0, 0)]`",
                    Value::Tuple(_) => ": take an entry, such as `x.0`",
                    Value::Sequence(_) => ": end with `.sum::<f64>()`",
                    Value::Closure(_) => ": call it, `f(x)`",
                    Value::Unit => ": end with the value, without `;`",
                    _ => ": assign to it first",
                };
                self.errors.push(
                    at.span(),
                    format!("expected an `f64`, found {}{hint}", value.kind()),
                );
                None
            }
        }
    }

    /// Counts a statement or expression; false when there have been too many.
    fn tick(&mut self, at: &impl Spanned) -> bool {
        self.work(1, at)
    }

    /// Counts work; false, with an error once, when there is too much of it.
    fn work(&mut self, amount: usize, at: &impl Spanned) -> bool {
        if self.steps >= STEPS {
            return false;
        }
        self.steps += amount;
        if self.steps < STEPS && self.arena.len() - self.nodes <= NODES {
            return true;
        }
        let what = if self.steps < STEPS {
            format!("more than {NODES} expressions, the limit of what is differentiated")
        } else {
            format!("more than {STEPS} steps of evaluation, the limit")
        };
        self.steps = STEPS;
        self.errors.push(
            at.span(),
            format!("this unrolls to {what}; use fewer or shorter loops"),
        );
        false
    }
}

/// What to say of an integer among numbers.
fn integer(i: i64) -> String {
    format!("an integer stands where an `f64` belongs: write `{i}.0`")
}

/// Source text of a type, for messages.
pub(crate) fn readable(ty: &impl ToTokens) -> String {
    ty.to_token_stream()
        .to_string()
        .replace(" ;", ";")
        .replace(" [", "[")
        .replace("& ", "&")
        .replace(" < ", "<")
        .replace(" >", ">")
        .replace(" ::", "::")
        .replace(":: ", "::")
        .replace(" . ", ".")
}
