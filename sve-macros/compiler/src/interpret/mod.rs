//! Bodies → expressions, by symbolic execution; the errors of meaning.
//!
//! Input: the annotated block. Output: the [`Model`]. A body is run with expressions for numbers: loops are unrolled, helpers
//! inlined, arrays and tuples are values. After a mistake the run goes on with a poisoned value, so that each mistake is
//! reported once and independent ones together.

mod branches;
mod calls;
mod closures;
mod conversions;
mod expressions;
mod floats;
mod integers;
mod pattern;
mod places;
mod references;
mod sequences;
mod statements;
mod value;

use std::collections::{HashMap, HashSet};

use quote::ToTokens;
use syn::spanned::Spanned;

use crate::algebra::{Arena, Expr, Symbol};
use crate::errors::Errors;
use crate::syntax::parse::{Annotated, Part};
use crate::syntax::roles::Role;
use crate::system::model::{Generator, Meaning, Model, NoiseTerm, Symbols};
use branches::Leaving;
use value::{Shape, Value};

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
    steps: usize,
    /// Nesting of the expression being evaluated.
    depth: usize,
}

/// Runs all parts of the block; mistakes join those that `errors` has already.
pub(crate) fn interpret(
    block: &Annotated,
    arena: &mut Arena,
    errors: &mut Errors,
) -> Option<Model> {
    let mut lowering = Lowering {
        arena,
        symbols: Symbols::default(),
        parameters: HashMap::new(),
        parameter_names: HashSet::new(),
        block,
        errors: std::mem::take(errors),
        scopes: Vec::new(),
        floor: 0,
        frame: 0,
        frames: 0,
        is_lazy: false,
        leaving: None,
        active: Vec::new(),
        broken: HashSet::new(),
        steps: 0,
        depth: 0,
    };
    let model = lowering.model();
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

impl Lowering<'_> {
    /// The model without its symbol table, which the caller moves in.
    fn model(&mut self) -> Option<Model> {
        let block = self.block;
        let part = &block.lagrangian;
        let offset = usize::from(part.timed);
        let shape = self.shape(&part.arguments[offset].1)?;
        let n = shape.len();
        if n == 0 {
            self.errors.push(
                part.arguments[offset].1.span(),
                "a system needs at least one coordinate",
            );
            return None;
        }
        let time = self.symbols.declare(Meaning::Time);
        let q = self.symbols.declare_all(n, Meaning::Position);
        let v = self.symbols.declare_all(n, Meaning::Velocity);
        let p = self.symbols.declare_all(n, Meaning::Momentum);

        let result = self.run(part, &shape, time, &[&q, &v]);
        let lagrangian = self.scalar_result(part, &result);
        let mut noises = Vec::new();
        for noise in &block.noises {
            let arguments: &[&[Symbol]] = if noise.role == Role::Gamma {
                &[&q]
            } else {
                &[&q, &p]
            };
            let result = self.run(noise, &shape, time, arguments);
            self.noise_terms(noise, result, &mut noises);
        }
        let mut force: Option<Vec<Expr>> = None;
        for part in &block.forces {
            let result = self.run(part, &shape, time, &[&q, &v]);
            let Some(more) = self.vector_result(part, &result, &shape) else {
                continue;
            };
            force = Some(match force {
                Some(sum) => {
                    let pairs = sum.into_iter().zip(more);
                    pairs.map(|(a, b)| self.arena.add(a, b)).collect()
                }
                None => more,
            });
        }
        let mut symmetries = Vec::new();
        for part in &block.symmetries {
            let result = self.run(part, &shape, time, &[&q]);
            if let Some(field) = self.vector_result(part, &result, &shape) {
                let name = part.name.to_string();
                symmetries.push(Generator { name, field });
            }
        }
        Some(Model {
            symbols: Symbols::default(),
            time,
            q,
            v,
            p,
            lagrangian: lagrangian?,
            noises,
            force,
            symmetries,
        })
    }

    /// Runs a part with symbols for its arguments.
    fn run(&mut self, part: &Part, shape: &Shape, time: Symbol, vectors: &[&[Symbol]]) -> Value {
        self.scopes = vec![HashMap::new()];
        self.active = vec![part.name.to_string()];
        let outer = self.errors.enter(&part.name.to_string());
        let mut arguments = part.arguments.iter();
        if part.timed
            && let Some((pattern, _)) = arguments.next()
        {
            let t = self.arena.symbol(time);
            self.bind(pattern, Value::Scalar(t));
        }
        let mut differs = false;
        for ((pattern, ty), symbols) in arguments.zip(vectors) {
            match self.shape(ty) {
                Some(found) if found == *shape => {}
                found => {
                    if found.is_some() && !differs {
                        self.differs(part, ty);
                        differs = true;
                    }
                    self.bind(pattern, Value::Poison);
                    continue;
                }
            }
            let mut expressions = symbols
                .iter()
                .map(|&s| self.arena.symbol(s))
                .collect::<Vec<_>>()
                .into_iter();
            let value = shape.fill(&mut || expressions.next().map_or(Value::Poison, Value::Scalar));
            self.bind(pattern, value);
        }
        let mistakes = self.errors.count();
        let value = self.block_value(&part.function.block);
        let value = self.awaited(value, &part.output, &part.function.sig.output);
        if self.errors.count() > mistakes {
            self.broken.insert(part.name.to_string());
        }
        self.errors.leave(outer);
        value
    }

    fn differs(&mut self, part: &Part, ty: &syn::Type) {
        let lagrangian = &self.block.lagrangian;
        let whose = match part.role {
            Role::Lagrangian => "positions and velocities",
            _ => "this and the arguments of `lagrangian`",
        };
        let there = &lagrangian.arguments[usize::from(lagrangian.timed)].1;
        self.errors.push(
            ty.span(),
            format!(
                "{whose} must be of the same length: here `{}`, there `{}`",
                readable(ty),
                readable(there),
            ),
        );
    }

    fn scalar_result(&mut self, part: &Part, value: &Value) -> Option<Expr> {
        if self.shape(&part.output)? != Shape::Scalar {
            self.errors.push(
                part.output.span(),
                format!("`{}` must return `f64`, one number: the energy of motion less that of position", part.name),
            );
            return None;
        }
        self.result(part, value)
    }

    /// The expression of what a part returns, or an error at its last expression.
    fn result(&mut self, part: &Part, value: &Value) -> Option<Expr> {
        let outer = self.errors.enter(&part.name.to_string());
        let result = match part.function.block.stmts.last() {
            Some(syn::Stmt::Expr(_, Some(semicolon))) => self.scalar(value, semicolon),
            Some(last) => self.scalar(value, last),
            None => self.scalar(value, &part.name),
        };
        self.errors.leave(outer);
        result
    }

    /// A vector of the shape of the coordinates.
    fn vector_result(&mut self, part: &Part, value: &Value, shape: &Shape) -> Option<Vec<Expr>> {
        let arguments = &part.arguments[usize::from(part.timed)..];
        if arguments
            .iter()
            .any(|(_, ty)| self.shape(ty).as_ref() != Some(shape))
        {
            // reported there
            return None;
        }
        if self.shape(&part.output)? != *shape {
            let lagrangian = &self.block.lagrangian;
            let coordinates = &lagrangian.arguments[usize::from(lagrangian.timed)].1;
            self.errors.push(
                part.output.span(),
                format!(
                    "`{}` must return a vector like the coordinates, `{}`",
                    part.name,
                    readable(coordinates)
                ),
            );
            return None;
        }
        let mut entries = Vec::new();
        self.entries(value, shape, &part.name, &mut entries)?;
        Some(entries)
    }

    /// The numbers of a value of a known shape, in memory order.
    fn entries(
        &mut self,
        value: &Value,
        shape: &Shape,
        at: &impl Spanned,
        out: &mut Vec<Expr>,
    ) -> Option<()> {
        match (shape, value) {
            (Shape::Scalar, value) => out.push(self.scalar(value, at)?),
            (Shape::Array(n, inner), Value::Field(path)) => {
                for i in 0..*n {
                    self.entries(&Value::Field(path.index(i)), inner, at, out)?;
                }
            }
            (Shape::Array(n, inner), Value::Array(values)) if values.len() == *n => {
                for value in values {
                    self.entries(value, inner, at, out)?;
                }
            }
            (_, Value::Poison) => return None,
            (Shape::Array(n, _), other) => {
                let message = format!("expected an array of {n}, found {}", other.kind());
                self.errors.push(at.span(), message);
                return None;
            }
        }
        Some(())
    }

    fn noise_terms(&mut self, part: &Part, value: Value, noises: &mut Vec<NoiseTerm>) {
        let Some(shape) = self.shape(&part.output) else {
            return;
        };
        let components: Vec<(String, Value)> = match (shape, value) {
            (_, Value::Poison) => return,
            (Shape::Array(..), Value::Field(_)) => {
                self.idle(part, &part.name.to_string());
                return;
            }
            (Shape::Scalar, value) => vec![(part.name.to_string(), value)],
            (Shape::Array(_, inner), Value::Array(values)) if *inner == Shape::Scalar => values
                .into_iter()
                .enumerate()
                .map(|(i, value)| (format!("{}[{i}]", part.name), value))
                .collect(),
            _ => {
                self.errors.push(
                    part.output.span(),
                    format!(
                        "`{}` must return `f64` or `[f64; M]`, one entry a Wiener process",
                        part.name
                    ),
                );
                return;
            }
        };
        for (name, value) in components {
            let Some(value) = self.result(part, &value) else {
                continue;
            };
            let moves = self.arena.symbols_of(value).any(|s| {
                matches!(
                    self.symbols.meaning(s),
                    Meaning::Position(_) | Meaning::Momentum(_)
                )
            });
            if !moves {
                self.idle(part, &name);
            }
            let is_gamma = part.role == Role::Gamma;
            let hamiltonian = if is_gamma {
                self.arena.neg(value)
            } else {
                value
            };
            noises.push(NoiseTerm {
                name,
                is_gamma,
                hamiltonian,
            });
        }
    }

    fn idle(&mut self, part: &Part, name: &str) {
        self.errors.push(
            part.name.span(),
            format!("the noise `{name}` depends on neither q nor p, so it moves nothing: its derivative is zero; did you mean to multiply by a coordinate?"),
        );
    }

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
            | Value::Tuple(_)
            | Value::Sequence(_)
            | Value::Closure(_)
            | Value::Unit
            | Value::Unset => {
                let hint = match value {
                    Value::Array(_) => ": take an entry, such as `x[0]`",
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

    /// The symbol of a field of the user's struct.
    fn parameter(&mut self, path: &value::FieldPath) -> Expr {
        let key = path.access();
        let symbol = match self.parameters.get(&key.to_string()) {
            Some(&symbol) => symbol,
            None => {
                // `self.a_b` and `self.a.b` are two parameters
                let mut name = path.name();
                while !self.parameter_names.insert(name.clone()) {
                    name.push('_');
                }
                let meaning = Meaning::Parameter {
                    name,
                    access: key.clone(),
                };
                let symbol = self.symbols.declare(meaning);
                self.parameters.insert(key.to_string(), symbol);
                symbol
            }
        };
        self.arena.symbol(symbol)
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
        if self.steps < STEPS && self.arena.len() <= NODES {
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
