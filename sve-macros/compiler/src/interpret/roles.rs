//! Functions with roles → the [`Model`]. Each function is executed with symbols for its arguments;
//! its result becomes an expression.

use syn::spanned::Spanned;

use super::Lowering;
use super::frames::Scope;
use super::names::names;
use super::types::Shape;
use super::value::Value;
use crate::algebra::{Expr, Symbol};
use crate::model::configuration::Configuration;
use crate::model::time_scale::in_scaled_time;
use crate::model::{Constraint, Generator, Meaning, Model, NoiseKind, NoiseTerm, Symbols};
use crate::syntax::parse::RoleFunction;
use crate::syntax::readable;
use crate::syntax::roles::Role;

/// The shapes of the parts of the configuration, and of their velocities and momenta.
pub(super) struct Space {
    pub(super) shapes: Vec<Shape>,
    pub(super) velocities: Vec<Shape>,
}

impl Space {
    /// Returns the parts of a quantity, each with its number and its symbols. Quantity 0 is the
    /// configuration; the others have the shape of the velocity.
    pub(super) fn parts<'a>(
        &'a self,
        quantity: usize,
        symbols: &'a [Symbol],
    ) -> impl Iterator<Item = (&'a Shape, usize, &'a [Symbol])> {
        let shapes = if quantity == 0 {
            &self.shapes
        } else {
            &self.velocities
        };
        let mut first = 0;
        shapes.iter().enumerate().map(move |(number, shape)| {
            let from = first;
            first += shape.len();
            (shape, number, &symbols[from..first])
        })
    }
}

impl Lowering<'_> {
    /// Returns the model without its symbol table, which the caller adds.
    pub(super) fn model(&mut self) -> Option<Model> {
        let block = self.block;
        let function = &block.lagrangian;
        let space = self.space()?;
        let n = self.symbols.configuration.directions();
        let entries = self.symbols.configuration.entries();
        let time = self.symbols.declare(Meaning::Time);
        let q = self.symbols.declare_all(entries, Meaning::Position);
        let v = self.symbols.declare_all(n, Meaning::Velocity);
        let p = self.symbols.declare_all(n, Meaning::Momentum);
        let parameters = self.symbols.configuration.parameters();
        let attitude = self.symbols.declare_all(parameters, Meaning::Attitude);
        let names = names(function, &space.shapes, !block.arguments.is_reduced);
        self.declare_inputs();
        self.declare_energy();

        let result = self.run(function, &space, time, &[&q, &v]);
        let mut lagrangian = self.scalar_result(function, &result);
        let noises = self.noises(&space, time, [&q, &v, &p]);
        let force = self.force(&space, time, &[&q, &v]);
        let symmetries = self.symmetries(&space, time, &q);
        let constraints = self.constraints(&space, time, &q);
        let time_scale = self.time_scale(&space, time, &q);
        if let (Some(value), Some(scale), Some(energy)) =
            (lagrangian, time_scale, self.symbols.energy)
        {
            lagrangian = Some(in_scaled_time(value, scale, energy, &v, self.arena));
        }
        self.check_fields_beside_inputs();
        Some(Model {
            symbols: Symbols::default(),
            time,
            q,
            v,
            p,
            attitude,
            names,
            lagrangian: lagrangian?,
            noises,
            force,
            symmetries,
            constraints,
            time_scale,
            constants: std::mem::take(&mut self.constants),
        })
    }

    /// Returns the noises in the order of their processes.
    fn noises(&mut self, space: &Space, time: Symbol, [q, v, p]: [&[Symbol]; 3]) -> Vec<NoiseTerm> {
        let block = self.block;
        let mut noises = Vec::new();
        for noise in &block.noises {
            let arguments: &[&[Symbol]] = match noise.role {
                Role::Gamma => &[q],
                Role::NoiseForce => &[q, v],
                _ => &[q, p],
            };
            let result = self.run(noise, space, time, arguments);
            match noise.role {
                Role::NoiseForce => noises.extend(self.noise_force(noise, &result, space)),
                _ => self.noise_terms(noise, &result, &mut noises),
            }
        }
        noises
    }

    /// Returns the generators of the symmetries.
    fn symmetries(&mut self, space: &Space, time: Symbol, q: &[Symbol]) -> Vec<Generator> {
        let block = self.block;
        let functions = block.symmetries.iter();
        let generators = functions.filter_map(|function| {
            let result = self.run(function, space, time, &[q]);
            let field = self.vector_result(function, &result, space)?;
            let name = function.name.to_string();
            Some(Generator { name, field })
        });
        generators.collect()
    }

    /// Returns the constraints.
    fn constraints(&mut self, space: &Space, time: Symbol, q: &[Symbol]) -> Vec<Constraint> {
        let block = self.block;
        let mut constraints = Vec::new();
        for function in &block.constraints {
            let result = self.run(function, space, time, &[q]);
            self.constraint_terms(function, &result, &mut constraints);
        }
        constraints
    }

    /// Returns s, if there is a time scale.
    fn time_scale(&mut self, space: &Space, time: Symbol, q: &[Symbol]) -> Option<Expr> {
        let function = self.block.time_scale.as_ref()?;
        let result = self.run(function, space, time, &[q]);
        self.scalar_result(function, &result)
    }

    /// Returns the sum of the forces, if there are any.
    fn force(&mut self, space: &Space, time: Symbol, arguments: &[&[Symbol]]) -> Option<Vec<Expr>> {
        let block = self.block;
        let mut force: Option<Vec<Expr>> = None;
        for function in &block.forces {
            let result = self.run(function, space, time, arguments);
            let Some(more) = self.vector_result(function, &result, space) else {
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
        force
    }

    /// Returns the noise of a force that acts with a Wiener process.
    fn noise_force(
        &mut self,
        function: &RoleFunction,
        value: &Value,
        space: &Space,
    ) -> Option<NoiseTerm> {
        let force = self.vector_result(function, value, space)?;
        let name = function.name.to_string();
        if force.iter().all(|&f| self.arena.is_zero(f)) {
            let message =
                format!("the force of the noise `{name}` is zero, so it moves nothing: remove it");
            self.errors.push(function.name.span(), message);
        }
        Some(NoiseTerm {
            name,
            kind: NoiseKind::Force,
            hamiltonian: self.arena.constant(0.0),
            force: Some(force),
        })
    }

    /// Returns the shapes of the configuration and adds its space to the symbols; or reports an
    /// error.
    fn space(&mut self) -> Option<Space> {
        let block = self.block;
        let mut shapes = Vec::new();
        let mut factors = Vec::new();
        for ty in block.configuration() {
            let shape = self.configuration_shape(ty)?;
            shape.factors(&mut factors);
            shapes.push(shape);
        }
        let configuration = Configuration::new(factors);
        if configuration.directions() == 0 {
            let message = "a system needs at least one coordinate";
            return self.refuse(block.coordinates(), message);
        }
        self.symbols.configuration = configuration;
        let velocities = shapes.iter().map(Shape::velocity).collect();
        Some(Space { shapes, velocities })
    }

    /// Executes a function with symbols for its arguments.
    fn run(
        &mut self,
        function: &RoleFunction,
        space: &Space,
        time: Symbol,
        vectors: &[&[Symbol]],
    ) -> Value {
        self.executed(function, |this| {
            this.bind_arguments(function, space, time, vectors);
        })
    }

    /// Executes a function whose arguments `bind` binds.
    pub(super) fn executed(
        &mut self,
        function: &RoleFunction,
        bind: impl FnOnce(&mut Self),
    ) -> Value {
        self.frame.scopes = vec![Scope::new()];
        self.calls.active = vec![function.name.to_string()];
        self.fields.taken_for_number = None;
        let outer = self.errors.enter(&function.name.to_string());
        bind(self);
        let mistakes = self.errors.count();
        let value = self.block_value(&function.item.block);
        let value = value.unwrap_or(Value::Poison);
        let value = self.awaited(value, &function.output, &function.item.sig.output);
        let value = self.ascribed(value, &function.output);
        if self.errors.count() > mistakes {
            self.calls.broken.insert(function.name.to_string());
        }
        self.errors.leave(outer);
        value
    }

    /// Binds the arguments of a function to symbols. Reports arguments whose types differ from the
    /// types of the coordinates.
    fn bind_arguments(
        &mut self,
        function: &RoleFunction,
        space: &Space,
        time: Symbol,
        vectors: &[&[Symbol]],
    ) {
        let mut arguments = function.arguments.iter();
        if function.is_timed
            && let Some((pattern, _)) = arguments.next()
        {
            let t = self.arena.symbol(time);
            self.bind(pattern, Value::Scalar(t));
        }
        let mut is_reported = false;
        let vectors = vectors.iter().enumerate();
        let mut places = vectors.flat_map(|(quantity, symbols)| space.parts(quantity, symbols));
        for (pattern, ty) in arguments {
            let Some((shape, there, symbols)) = places.next() else {
                self.report_other_type(function, ty, None, &space.shapes[0], 0);
                self.bind(pattern, Value::Poison);
                continue;
            };
            let found = self.configuration_shape(ty);
            if found.as_ref() != Some(shape) {
                if found.is_some() && !is_reported {
                    self.report_other_type(function, ty, found.as_ref(), shape, there);
                    is_reported = true;
                }
                self.bind(pattern, Value::Poison);
                continue;
            }
            let mut symbols = symbols.iter();
            let mut next = || {
                let symbol = symbols.next().map(|&symbol| self.arena.symbol(symbol));
                symbol.map_or(Value::Poison, Value::Scalar)
            };
            let value = shape.fill(&mut next);
            self.bind(pattern, value);
        }
        if let Some((pattern, ty)) = &function.input {
            let value = self.input_of(ty);
            self.bind(pattern, value);
        }
        if places.next().is_some() {
            let expected = function.role.signature_with_rotations(space.shapes.len());
            let message = format!(
                "`{}` needs an argument for each part of the configuration: expected `{expected}`",
                function.name
            );
            self.errors.push(function.name.span(), message);
        }
    }

    /// Reports an argument whose type differs from the types of the coordinates.
    fn report_other_type(
        &mut self,
        function: &RoleFunction,
        ty: &syn::Type,
        found: Option<&Shape>,
        shape: &Shape,
        there: usize,
    ) {
        if self.symbols.configuration.has_rotations() {
            self.report_other_part(ty);
            return;
        }
        let whose = match function.role {
            Role::Lagrangian => "positions and velocities",
            _ => "this and the arguments of `lagrangian`",
        };
        let what = if shape.has_vectors() || found.is_some_and(Shape::has_vectors) {
            "type"
        } else {
            "length"
        };
        let here = readable(ty);
        let there = readable(self.block.configuration().nth(there).unwrap_or(ty));
        self.errors.push(
            ty.span(),
            format!("{whose} must be of the same {what}: here `{here}`, there `{there}`"),
        );
    }

    /// Appends the noises that a function returns.
    fn noise_terms(&mut self, function: &RoleFunction, value: &Value, noises: &mut Vec<NoiseTerm>) {
        let Some(shape) = self.shape(&function.output) else {
            return;
        };
        if let (Shape::Array(..) | Shape::Vector(_), Value::Field(_)) = (&shape, value) {
            return self.report_constant_noise(function, &function.name.to_string());
        }
        for (name, value) in self.named_results(function, &shape, value) {
            let is_moving = |s| {
                let meaning = self.symbols.meaning(s);
                matches!(meaning, Meaning::Position(_) | Meaning::Momentum(_))
            };
            if !self.arena.symbols_of(value).any(is_moving) {
                self.report_constant_noise(function, &name);
            }
            let (kind, hamiltonian) = match function.role {
                Role::Gamma => (NoiseKind::Gamma, self.arena.neg(value)),
                Role::TangentH1 => (NoiseKind::TangentH1, value),
                _ => (NoiseKind::H1, value),
            };
            noises.push(NoiseTerm {
                name,
                kind,
                hamiltonian,
                force: None,
            });
        }
    }

    /// Appends the constraints that a function returns.
    fn constraint_terms(
        &mut self,
        function: &RoleFunction,
        value: &Value,
        constraints: &mut Vec<Constraint>,
    ) {
        let Some(shape) = self.shape(&function.output) else {
            return;
        };
        for (name, value) in self.named_results(function, &shape, value) {
            let is_position = |s| matches!(self.symbols.meaning(s), Meaning::Position(_));
            if !self.arena.symbols_of(value).any(is_position) {
                let message = format!(
                    "the constraint `{name}` does not depend on q, so it restricts no motion: remove it, or write what shall vanish along the motion, such as a length less its value"
                );
                self.errors.push(function.name.span(), message);
            }
            constraints.push(Constraint { name, value });
        }
    }

    pub(super) fn report_constant_noise(&mut self, function: &RoleFunction, name: &str) {
        self.errors.push(
            function.name.span(),
            format!("the noise `{name}` depends on neither q nor p, so it moves nothing: its derivative is zero; did you mean to multiply by a coordinate?"),
        );
    }
}
