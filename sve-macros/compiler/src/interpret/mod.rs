//! Bodies → expressions, by symbolic execution. Reports semantic errors.
//!
//! Input: the annotated block. Output: the [`Model`]. A body is executed with expressions in place
//! of numbers. Loops are unrolled and helpers inlined; arrays, tuples, vectors and matrices are
//! values. After a mistake, the execution continues with a poisoned value: each mistake is reported
//! once, and independent mistakes are reported together. A function that evaluates returns `None`
//! after a mistake that it has reported; a variable or an entry then has the value
//! [`Value::Poison`].
//!
//! In a scene, whose lengths are known when the program runs, the output is a [`Scene`]: loops over
//! them are executed once and kept as sums (`scenes/`).

mod adapters;
mod branches;
mod calls;
mod closures;
mod constants;
mod conversions;
mod entries;
mod expressions;
mod fields;
mod floats;
mod frames;
mod helpers;
mod indices;
mod inputs;
mod integers;
mod matrices;
mod methods;
mod names;
mod operators;
mod pattern;
mod places;
mod references;
mod results;
mod roles;
mod scenes;
mod sequences;
mod statements;
mod types;
mod value;

use std::fmt::Display;

use proc_macro2::TokenStream;
use syn::spanned::Spanned;

use crate::algebra::{Arena, Expr};
use crate::errors::Errors;
use crate::model::scene::Scene;
use crate::model::{Model, Symbols};
use crate::syntax::parse::Annotated;
use branches::LoopExit;
use calls::Argument;
use fields::{Fields, Known};
use frames::Frame;
use helpers::Calls;
use scenes::Building;
use value::Value;

/// Largest number of statements and expressions that one expansion may execute.
const STEPS: usize = 2_000_000;

/// Largest number of algebraic expressions that the execution of bodies may create.
const NODES: usize = 30_000;

/// The state of the symbolic execution of a block.
pub(crate) struct Lowering<'a> {
    block: &'a Annotated,
    arena: &'a mut Arena,
    symbols: Symbols,
    errors: Errors,
    fields: Fields,
    /// The paths that are read as constants of `std::f64::consts` and may refer to something else.
    constants: Vec<(TokenStream, f64)>,
    calls: Calls,
    /// The argument `u`, if a function has it.
    input: Option<inputs::Input>,
    /// The function or closure that is being executed.
    frame: Frame,
    /// Set by `continue` and `break` until the loop handles it.
    leaving: Option<LoopExit>,
    scene: Building,
    limits: Limits,
}

/// The amounts of the limits that an execution has used.
struct Limits {
    steps: usize,
    /// Number of expressions in the arena before the execution.
    initial_nodes: usize,
    /// Nesting of the expression being evaluated.
    depth: usize,
}

/// Executes all functions with roles. Mistakes are added to `errors`.
pub(crate) fn interpret(
    block: &Annotated,
    arena: &mut Arena,
    errors: &mut Errors,
) -> Option<Model> {
    #[allow(clippy::redundant_closure_for_method_calls)] // the path has one lifetime only
    let (symbols, model) = executed(block, arena, errors, |lowering| lowering.model())?;
    Some(Model { symbols, ..model })
}

/// Executes all functions with roles of a scene. Mistakes are added to `errors`.
pub(crate) fn scene(block: &Annotated, arena: &mut Arena, errors: &mut Errors) -> Option<Scene> {
    #[allow(clippy::redundant_closure_for_method_calls)] // the path has one lifetime only
    let (symbols, scene) = executed(block, arena, errors, |lowering| lowering.scene())?;
    Some(Scene { symbols, ..scene })
}

/// Executes the functions of a block with `run`, and returns the symbols and the result.
///
/// Some properties of fields are known only after the fields have been used ([`Known`]). The block
/// is then executed again with this knowledge.
fn executed<T>(
    block: &Annotated,
    arena: &mut Arena,
    errors: &mut Errors,
    run: impl Fn(&mut Lowering<'_>) -> Option<T>,
) -> Option<(Symbols, T)> {
    let mut lowering = Lowering::new(block, arena, Known::default());
    let mut result = run(&mut lowering);
    while let Some(known) = lowering.learnt() {
        lowering = Lowering::new(block, lowering.arena, known);
        result = run(&mut lowering);
    }
    errors.append(lowering.errors);
    let symbols = lowering.symbols;
    if result.is_none() && errors.count() == 0 {
        errors.push(
            block.lagrangian.name.span(),
            "this Lagrangian cannot be read",
        );
    }
    result.map(|result| (symbols, result))
}

impl<'a> Lowering<'a> {
    /// Returns the initial state of an execution with this knowledge of fields.
    fn new(block: &'a Annotated, arena: &'a mut Arena, known: Known) -> Self {
        Self {
            limits: Limits {
                steps: 0,
                initial_nodes: arena.len(),
                depth: 0,
            },
            block,
            arena,
            symbols: Symbols::default(),
            errors: Errors::new(),
            input: None,
            fields: Fields::new(known),
            constants: Vec::new(),
            calls: Calls::default(),
            frame: Frame::default(),
            leaving: None,
            scene: Building::default(),
        }
    }
}

impl Lowering<'_> {
    /// Reports a mistake.
    fn refuse<T>(&mut self, at: &impl Spanned, message: impl Display) -> Option<T> {
        self.errors.push(at.span(), message);
        None
    }

    /// Returns the value of a constant.
    fn constant(&mut self, value: f64) -> Value {
        Value::Scalar(self.arena.constant(value))
    }

    /// Returns the expression of a number, or reports an error at `at`.
    fn scalar(&mut self, value: &Value, at: &impl Spanned) -> Option<Expr> {
        let hint = match value {
            Value::Scalar(expr) => return Some(*expr),
            Value::Poison => return None,
            Value::Field(path) if path.is_self() => {
                return self.refuse(
                    at,
                    "`self` is not a number: write one of its fields, `self.name`",
                );
            }
            Value::Field(path) => return Some(self.parameter(path)),
            Value::Converted(inner) => {
                return match &**inner {
                    Value::Int(i) => Some(self.arena.constant(i.value as f64)),
                    Value::Index(i) => Some(self.number_of(*i)),
                    inner => self.scalar(inner, at),
                };
            }
            Value::Place(_) => {
                return match self.frame.followed(value).clone() {
                    Value::Place(_) => None,
                    inner => self.scalar(&inner, at),
                };
            }
            Value::Generated(_) => return self.refuse(at, conversions::NO_LENGTH),
            Value::Int(i) => return self.refuse(at, integer(i.value)),
            Value::Index(i) => {
                let text = self.scene.integers.text(*i);
                let text = if text.contains(' ') {
                    format!("({text})")
                } else {
                    text
                };
                return self.refuse(
                    at,
                    format!("an integer stands where an `f64` belongs: write `{text} as f64`"),
                );
            }
            Value::Stream(_) => ": take an entry, such as `q[i]`, or end with `.sum::<f64>()`",
            Value::Array(_) => ": take an entry, such as `x[0]`",
            Value::Matrix(m) if m.ty.is_vector() => {
                ": take an entry, such as `v[0]`, or a number such as `v.norm_squared()`"
            }
            Value::Matrix(_) => ": take an entry, such as `m[(0, 0)]`",
            Value::Tuple(_) => ": take an entry, such as `x.0`",
            Value::Sequence(_) => ": end with `.sum::<f64>()`",
            Value::Closure(_) => ": call it, `f(x)`",
            Value::Unit => ": end with the value, without `;`",
            Value::Unset => ": assign to it first",
        };
        let message = format!("expected an `f64`, found {}{hint}", value.kind());
        self.refuse(at, message)
    }

    /// Returns the expressions of numbers, or reports an error for each value that is not a number.
    fn scalars(&mut self, values: &[Argument]) -> Option<Vec<Expr>> {
        let numbers: Vec<Option<Expr>> = values
            .iter()
            .map(|argument| self.scalar(&argument.value, &argument.at))
            .collect();
        numbers.into_iter().collect()
    }

    /// Returns a computed number, or reports an error if a constant overflows.
    fn finite(&mut self, number: Expr, at: &impl Spanned) -> Option<Value> {
        if self.arena.is_finite(number) {
            Some(Value::Scalar(number))
        } else {
            self.refuse(at, OVERFLOW)
        }
    }

    /// Counts a statement or expression. Returns `None` beyond the limit.
    fn tick(&mut self, at: &impl Spanned) -> Option<()> {
        self.work(1, at)
    }

    /// Counts `amount` steps. Returns `None` beyond the limit, and reports an error the first time.
    fn work(&mut self, amount: usize, at: &impl Spanned) -> Option<()> {
        let Limits {
            steps,
            initial_nodes,
            ..
        } = &mut self.limits;
        if *steps >= STEPS {
            return None;
        }
        *steps += amount;
        let is_within = *steps < STEPS;
        if is_within && self.arena.len() - *initial_nodes <= NODES {
            return Some(());
        }
        *steps = STEPS;
        let what = if is_within {
            format!("more than {NODES} expressions, the limit of what is differentiated")
        } else {
            format!("more than {STEPS} steps of evaluation, the limit")
        };
        let message = format!("this unrolls to {what}; use fewer or shorter loops");
        self.refuse(at, message)
    }
}

/// The message for constants whose result is too large.
const OVERFLOW: &str = "the constants here overflow an `f64`";

/// Returns the message for an integer where an `f64` is expected.
fn integer(i: i64) -> String {
    format!("an integer stands where an `f64` belongs: write `{i}.0`")
}
