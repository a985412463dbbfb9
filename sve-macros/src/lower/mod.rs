//! Bodies → expressions, by symbolic execution; the errors of meaning.
//!
//! Input: the annotated block. Output: the [`Model`]. A body is run with expressions for numbers: loops are unrolled, helpers
//! inlined, arrays and tuples are values. After a mistake the run goes on with a poisoned value, so that each mistake is
//! reported once and independent ones together.

mod calls;
mod expressions;
mod pattern;
mod places;
mod statements;
mod value;

use std::collections::{HashMap, HashSet};

use quote::ToTokens;
use syn::spanned::Spanned;

use crate::errors::Errors;
use crate::model::{Meaning, Model, NoiseTerm, Symbols};
use crate::parse::{Annotated, Part, Role};
use crate::symbolic::{Arena, Expr, Symbol};
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
    /// Helpers in which a mistake has been reported.
    broken: HashSet<String>,
    steps: usize,
    /// Nesting of the expression being evaluated.
    depth: usize,
}

/// Runs all parts of the block.
pub(crate) fn lower(block: &Annotated, arena: &mut Arena) -> syn::Result<Model> {
    let mut lowering = Lowering {
        arena,
        symbols: Symbols::default(),
        parameters: HashMap::new(),
        parameter_names: HashSet::new(),
        block,
        errors: Errors::new(),
        scopes: Vec::new(),
        active: Vec::new(),
        broken: HashSet::new(),
        steps: 0,
        depth: 0,
    };
    let model = lowering.model();
    let Lowering {
        errors, symbols, ..
    } = lowering;
    let parts = errors.finish(model)?;
    parts
        .map(|parts| Model { symbols, ..parts })
        .ok_or_else(|| {
            syn::Error::new(
                block.lagrangian.name.span(),
                "this Lagrangian cannot be read",
            )
        })
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
        Some(Model {
            symbols: Symbols::default(),
            time,
            q,
            v,
            p,
            lagrangian: lagrangian?,
            noises,
        })
    }

    /// Runs a part with symbols for its arguments.
    fn run(&mut self, part: &Part, shape: &Shape, time: Symbol, vectors: &[&[Symbol]]) -> Value {
        self.scopes = vec![HashMap::new()];
        self.active = vec![part.name.to_string()];
        let mut arguments = part.arguments.iter();
        if part.timed
            && let Some((pattern, _)) = arguments.next()
        {
            let t = self.arena.symbol(time);
            self.bind(pattern, Value::Scalar(t));
        }
        for ((pattern, ty), symbols) in arguments.zip(vectors) {
            match self.shape(ty) {
                Some(found) if found == *shape => {}
                found => {
                    if found.is_some() {
                        self.differs(part, ty);
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
        if self.errors.count() > mistakes {
            self.broken.insert(part.name.to_string());
        }
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
                format!("`{}` must return `f64`", part.name),
            );
            return None;
        }
        self.scalar(value, &part.name)
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
            let Some(value) = self.scalar(&value, &part.name) else {
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
            Value::Field(path) => Some(self.parameter(path)),
            Value::Poison => None,
            Value::Int(i) => {
                self.errors.push(
                    at.span(),
                    format!("an integer stands where an `f64` belongs: write `{i}.0`"),
                );
                None
            }
            Value::Array(_) | Value::Tuple(_) | Value::Unit => {
                self.errors.push(
                    at.span(),
                    format!("expected an `f64`, found {}", value.kind()),
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
        self.steps = STEPS;
        self.errors.push(
            at.span(),
            format!("this body is too large to unroll: more than {STEPS} steps or {NODES} expressions; use fewer or shorter loops"),
        );
        false
    }
}

/// Source text of a type, for messages.
fn readable(ty: &impl ToTokens) -> String {
    ty.to_token_stream()
        .to_string()
        .replace(" ;", ";")
        .replace(" [", "[")
        .replace("& ", "&")
        .replace(" . ", ".")
}
