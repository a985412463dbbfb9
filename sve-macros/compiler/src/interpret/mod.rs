//! Bodies → expressions, by symbolic execution. Reports semantic errors.
//!
//! Input: the annotated block. Output: the [`Model`]. A body is executed with expressions in place of numbers. Loops are unrolled and
//! helpers inlined; arrays, tuples, vectors and matrices are values. After a mistake, the execution continues with a poisoned value:
//! each mistake is reported once, and independent mistakes are reported together.

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
mod names;
mod operators;
mod pattern;
mod places;
mod references;
mod results;
mod roles;
mod sequences;
mod statements;
mod types;
mod value;

use std::collections::{HashMap, HashSet};

use proc_macro2::TokenStream;
use syn::spanned::Spanned;

use crate::algebra::{Arena, Expr, Symbol};
use crate::errors::Errors;
use crate::model::{Model, Symbols};
use crate::syntax::parse::Annotated;
use branches::LoopExit;
use fields::FieldPath;
use matrices::MatrixType;
use value::Value;

/// Largest number of statements and expressions that one expansion may execute.
const STEPS: usize = 2_000_000;

/// Largest number of algebraic expressions that the execution of bodies may create.
const NODES: usize = 30_000;

/// The state of the symbolic execution of a block.
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
    /// Types of fields that an earlier execution found.
    known_types: HashMap<String, MatrixType>,
    /// Entries of vectors and matrices that are written in several ways. Maps each spelling to the one that generated code reads.
    spellings: HashMap<String, FieldPath>,
    block: &'a Annotated,
    errors: Errors,
    /// Variables, innermost scope last.
    scopes: Vec<HashMap<String, Value>>,
    /// The helpers and constants that are being evaluated, by which recursion is detected.
    active: Vec<String>,
    /// Index of the first scope of the closure that is being run. The scopes before it enclose the closure.
    floor: usize,
    /// Number of the function or closure that is being run. Only references made in the same frame can be used.
    frame: usize,
    /// The last number of a frame.
    frames: usize,
    /// Whether a closure of an iterator adapter is being run. Rust runs such a closure only when the iterator's items are used.
    is_lazy: bool,
    /// Set by `continue` and `break` until the loop handles it.
    leaving: Option<LoopExit>,
    /// Helpers and constants in which a mistake has been reported.
    broken: HashSet<String>,
    /// The last parameter that was used as a number, for a hint in messages.
    taken_for_number: Option<FieldPath>,
    steps: usize,
    /// Number of expressions in the arena before the execution.
    initial_nodes: usize,
    /// Nesting of the expression being evaluated.
    depth: usize,
}

/// Executes all functions with roles. Mistakes are added to `errors`.
///
/// The type of a field may become known only after the field has been used. If a field of a type that is known at the end was taken for a number, the block is
/// executed once more with the types of all fields. If an entry was read in several ways, the block is executed once more with one symbol for the entry.
pub(crate) fn interpret(
    block: &Annotated,
    arena: &mut Arena,
    errors: &mut Errors,
) -> Option<Model> {
    let mut lowering = Lowering::new(block, arena);
    let mut model = lowering.model();
    if lowering.has_mistaken_types() {
        lowering = lowering.with_known_types();
        model = lowering.model();
    }
    lowering.spellings = lowering.unify_spellings();
    if lowering.errors.count() == 0 && !lowering.spellings.is_empty() {
        lowering = lowering.restarted();
        model = lowering.model();
    }
    errors.append(lowering.errors);
    let symbols = lowering.symbols;
    if model.is_none() && errors.count() == 0 {
        errors.push(
            block.lagrangian.name.span(),
            "this Lagrangian cannot be read",
        );
    }
    model.map(|model| Model { symbols, ..model })
}

impl<'a> Lowering<'a> {
    fn new(block: &'a Annotated, arena: &'a mut Arena) -> Self {
        Self {
            initial_nodes: arena.len(),
            arena,
            symbols: Symbols::default(),
            parameters: HashMap::new(),
            parameter_names: HashSet::new(),
            paths: Vec::new(),
            constants: Vec::new(),
            vectors: HashMap::new(),
            known_types: HashMap::new(),
            spellings: HashMap::new(),
            block,
            errors: Errors::new(),
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

    /// Returns the initial state of another execution, which uses the spellings and the types that earlier ones found.
    fn restarted(self) -> Self {
        Self {
            spellings: self.spellings,
            known_types: self.known_types,
            ..Self::new(self.block, self.arena)
        }
    }

    /// Returns whether another execution can do better that knows the types of fields from this one: a vector or matrix was taken for a number, or a mistake was
    /// reported that may come from an unknown type.
    fn has_mistaken_types(&self) -> bool {
        let is_number = |field| self.parameters.contains_key(field);
        !self.vectors.is_empty() && (self.errors.count() > 0 || self.vectors.keys().any(is_number))
    }

    /// Returns the initial state of an execution that knows the types of fields from this one. It finds the mistakes that are left anew.
    fn with_known_types(mut self) -> Self {
        self.known_types = std::mem::take(&mut self.vectors);
        self.restarted()
    }
}

impl Lowering<'_> {
    /// Returns the expression of a number, or reports an error at `at`.
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

    /// Counts a statement or expression. Returns `false` beyond the limit.
    fn tick(&mut self, at: &impl Spanned) -> bool {
        self.work(1, at)
    }

    /// Counts `amount` steps. Returns `false` beyond the limit, and reports an error the first time.
    fn work(&mut self, amount: usize, at: &impl Spanned) -> bool {
        if self.steps >= STEPS {
            return false;
        }
        self.steps += amount;
        if self.steps < STEPS && self.arena.len() - self.initial_nodes <= NODES {
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

/// Returns the message for an integer in the place of an `f64`.
fn integer(i: i64) -> String {
    format!("an integer stands where an `f64` belongs: write `{i}.0`")
}
