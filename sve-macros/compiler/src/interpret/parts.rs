//! Functions with roles → the [`Model`]: each is run with symbols for its arguments, and its result is read.

use std::collections::HashMap;

use syn::spanned::Spanned;

use super::matrices::Matrix;
use super::types::Shape;
use super::value::Value;
use super::{Lowering, readable};
use crate::algebra::{Expr, Symbol};
use crate::syntax::parse::Part;
use crate::syntax::roles::Role;
use crate::system::model::{Generator, Meaning, Model, NoiseTerm, Symbols};

impl Lowering<'_> {
    /// The model without its symbol table, which the caller moves in.
    pub(super) fn model(&mut self) -> Option<Model> {
        let block = self.block;
        let part = &block.lagrangian;
        let shape = self.shape(block.coordinates())?;
        let n = shape.len();
        if n == 0 {
            self.errors.push(
                block.coordinates().span(),
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
            constants: std::mem::take(&mut self.constants),
        })
    }

    /// Runs a part with symbols for its arguments.
    fn run(&mut self, part: &Part, shape: &Shape, time: Symbol, vectors: &[&[Symbol]]) -> Value {
        self.scopes = vec![HashMap::new()];
        self.active = vec![part.name.to_string()];
        self.taken_for_number = None;
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
                        self.differs(part, ty, found.as_ref(), shape);
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
        let value = self.ascribed(value, &part.output);
        if self.errors.count() > mistakes {
            self.broken.insert(part.name.to_string());
        }
        self.errors.leave(outer);
        value
    }

    /// Reports an argument of another type than the coordinates have.
    fn differs(&mut self, part: &Part, ty: &syn::Type, found: Option<&Shape>, shape: &Shape) {
        let whose = match part.role {
            Role::Lagrangian => "positions and velocities",
            _ => "this and the arguments of `lagrangian`",
        };
        let what = if shape.has_vectors() || found.is_some_and(Shape::has_vectors) {
            "type"
        } else {
            "length"
        };
        let here = readable(ty);
        let there = readable(self.block.coordinates());
        self.errors.push(
            ty.span(),
            format!("{whose} must be of the same {what}: here `{here}`, there `{there}`"),
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
            let coordinates = self.block.coordinates();
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
            (Shape::Vector(ty), Value::Field(path)) => {
                for entry in &Matrix::of_field(path, *ty).entries {
                    out.push(self.scalar(entry, at)?);
                }
            }
            (Shape::Vector(ty), Value::Matrix(matrix)) if matrix.ty == *ty => {
                for entry in &matrix.entries {
                    out.push(self.scalar(entry, at)?);
                }
            }
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
            (shape, other) => {
                let expected = match shape {
                    Shape::Vector(ty) => format!("a `{ty}`"),
                    shape => format!("an array of {}", shape.outer_length()),
                };
                let message = format!("expected {expected}, found {}", other.kind());
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
        let indexed = |values: Vec<Value>| {
            let named = |(i, value)| (format!("{}[{i}]", part.name), value);
            values.into_iter().enumerate().map(named).collect()
        };
        let components: Vec<(String, Value)> = match (shape, value) {
            (_, Value::Poison) => return,
            (Shape::Array(..) | Shape::Vector(_), Value::Field(_)) => {
                self.idle(part, &part.name.to_string());
                return;
            }
            (Shape::Scalar, value) => vec![(part.name.to_string(), value)],
            (Shape::Array(_, inner), Value::Array(values)) if *inner == Shape::Scalar => {
                indexed(values)
            }
            (Shape::Vector(ty), Value::Matrix(matrix)) if matrix.ty == ty => {
                indexed(matrix.entries)
            }
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
}
