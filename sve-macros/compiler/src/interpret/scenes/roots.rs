//! Functions of a scene → [`Scene`]: each function is executed with its rows as arguments, and its
//! sums get their places.

use std::collections::HashMap;

use proc_macro2::Span;
use syn::Type;
use syn::spanned::Spanned;

use super::streams::Stream;
use super::{Kept, Lowering};
use crate::algebra::{Expr, Node, Symbol};
use crate::interpret::names;
use crate::interpret::types::Shape;
use crate::interpret::value::Value;
use crate::model::scene::{
    Array, Head, Int, IntNode, Processes, Row, Scene, SceneNoise, SlotArray, Sum, SumId,
};
use crate::model::{Meaning, Symbols};
use crate::syntax::parse::RoleFunction;
use crate::syntax::readable;
use crate::syntax::roles::Role;
use crate::syntax::signature::{entry_of_slice, entry_of_vec};

/// Largest number of sums of a scene. A sum that is read in several loops is copied.
const SUMS: usize = 1000;

impl Lowering<'_> {
    /// Returns the scene without its symbol table, which the caller adds.
    pub(in crate::interpret) fn scene(&mut self) -> Option<Scene> {
        let block = self.block;
        let (row, shape) = self.row_type(block.coordinates())?;
        self.scene.shape = Some(shape);
        let time = self.symbols.declare(Meaning::Time);
        self.declare_inputs();
        let function = &block.lagrangian;
        let result = self.run_scene(function, time);
        let lagrangian = self.scalar_result(function, &result);
        let mut noises = Vec::new();
        let (noise_forces, others): (Vec<_>, Vec<_>) =
            (block.noises.iter()).partition(|function| function.role == Role::NoiseForce);
        for function in others {
            let result = self.run_scene(function, time);
            if let Some(processes) = self.processes(function, result) {
                noises.push((function, processes));
            }
        }
        let forces = self.on_sites(block.forces.iter().chain(noise_forces), time);
        let symmetries = self.on_sites(&block.symmetries, time);
        let mut sums = Vec::new();
        let lagrangian = self.root(lagrangian?, function.name.span(), &mut sums)?;
        let mut placed = Vec::new();
        for (function, processes) in noises {
            let at = function.name.span();
            let processes = match processes {
                Found::Listed(values) => {
                    let values = values.into_iter();
                    let values = values.map(|value| self.root(value, at, &mut sums));
                    Processes::Listed(values.collect::<Option<_>>()?)
                }
                Found::Each(components) => {
                    let components = components.into_iter();
                    let placed = components.map(|sum| self.placed_root(sum, &mut sums));
                    Processes::Each(placed.collect::<Option<_>>()?)
                }
            };
            let name = function.name.to_string();
            placed.push(SceneNoise {
                name,
                is_h1: function.role != Role::Gamma,
                processes,
            });
        }
        let forces = self.placed_on_sites(forces, &mut sums)?;
        let symmetries = self.placed_on_sites(symmetries, &mut sums)?;
        self.check_fields_beside_inputs();
        if self.errors.count() > 0 {
            return None;
        }
        Some(Scene {
            symbols: Symbols::default(),
            time,
            row,
            integers: std::mem::take(&mut self.scene.integers),
            slots: std::mem::take(&mut self.scene.slots),
            sums,
            lagrangian,
            noises: placed,
            forces,
            symmetries,
            constants: std::mem::take(&mut self.constants),
        })
    }

    /// Returns the type of the rows of a slice, or reports an error.
    fn row_type(&mut self, slice: &Type) -> Option<(Row, Shape)> {
        let entry = entry_of_slice(slice)?;
        let shape = self.shape(entry)?;
        let row = match &shape {
            Shape::Scalar => Row::Number,
            Shape::Vector(ty) => Row::Vector(ty.rows),
            Shape::Array(n, inner) if **inner == Shape::Scalar => Row::Array(*n),
            Shape::Array(..) => {
                let message =
                    "the rows of a scene are numbers, `[f64; D]` or vectors such as `Vector3<f64>`";
                return self.refuse(entry, message);
            }
        };
        if row.len() == 0 {
            return self.refuse(entry, "a system needs at least one coordinate");
        }
        Some((row, shape))
    }

    /// Executes a function with rows as its arguments.
    pub(super) fn run_scene(&mut self, function: &RoleFunction, time: Symbol) -> Value {
        let second = match function.role {
            Role::H1 => SlotArray::Momentum,
            _ => SlotArray::Velocity,
        };
        let rows: [fn(Int) -> SlotArray; 2] = [SlotArray::Configuration, second];
        self.executed(function, |this| {
            let mut arguments = function.arguments.iter();
            if function.is_timed
                && let Some((pattern, _)) = arguments.next()
            {
                let t = this.arena.symbol(time);
                this.bind(pattern, Value::Scalar(t));
            }
            if let Some((pattern, ty)) = &function.input {
                let u = this.input_of(ty);
                this.bind(pattern, u);
            }
            for ((pattern, ty), array) in arguments.zip(rows) {
                let shape = this.same_rows(ty);
                let value = shape.map_or(Value::Poison, |()| this.rows(array));
                this.bind(pattern, value);
            }
        })
    }

    /// Checks that the type of an argument is the type of the coordinates.
    fn same_rows(&mut self, ty: &Type) -> Option<()> {
        let coordinates = self.block.coordinates();
        let shape = match entry_of_slice(ty) {
            Some(entry) => Some(self.shape(entry)?),
            None => None,
        };
        if shape.is_some() && shape == self.scene.shape {
            return Some(());
        }
        let (here, there) = (readable(ty), readable(coordinates));
        let message = format!(
            "all functions of a block have arguments of one type: here `{here}`, there `{there}`"
        );
        self.refuse(ty, message)
    }

    fn rows(&mut self, array: fn(Int) -> SlotArray) -> Value {
        let integers = &mut self.scene.integers;
        let (from, to) = (
            integers.constant(0),
            integers.integer(IntNode::Length(Array::Sites)),
        );
        let item = move |x: &mut Lowering<'_>, index| Some(x.row(array, index));
        Value::Stream(Stream::new(from, to, item).row())
    }

    /// Returns the noise of each process.
    fn processes(&mut self, function: &RoleFunction, value: Value) -> Option<Found> {
        if let Some(entry) = entry_of_vec(&function.output) {
            let shape = self.shape(entry)?;
            let mut names = Vec::new();
            names::entries(&function.name.to_string(), &shape, &mut names);
            let sums = self.components_of_entries(function, value, &shape)?;
            let sums = names.into_iter().zip(sums).map(|(name, sum)| {
                let kept = sum.and_then(|symbol| self.kept_sum(symbol));
                if kept.is_some_and(|kept| self.moves(kept.summand)) {
                    return sum;
                }
                self.report_constant_noise(function, &name);
                None
            });
            return sums.collect::<Option<_>>().map(Found::Each);
        }
        let shape = self.shape(&function.output)?;
        let named = self.named_results(function, &shape, &value);
        for (name, value) in &named {
            if !self.moves(*value) {
                self.report_constant_noise(function, name);
            }
        }
        Some(Found::Listed(
            named.into_iter().map(|(_, value)| value).collect(),
        ))
    }

    /// Returns the entries of the `Vec` that a function returns, and their place.
    pub(super) fn collected(
        &mut self,
        function: &RoleFunction,
        value: Value,
    ) -> Option<(Stream, Span)> {
        let last = function.item.block.stmts.last();
        let at = last.map_or(name_span(function), Spanned::span);
        // a field is one once it is cloned
        let stream = self.stream(&value);
        match (value, stream) {
            (Value::Poison, _) => None,
            (_, Some(stream)) if stream.filter.is_none() => Some((stream, at)),
            (other, _) => {
                let message = format!(
                    "expected a `Vec` made by `collect`, `q.iter().map(|x| …).collect()`, found {}",
                    other.kind()
                );
                self.refuse(&at, message)
            }
        }
    }

    /// Appends a sum that is a root. Returns its number.
    pub(super) fn placed_root(&mut self, sum: Symbol, sums: &mut Vec<Sum>) -> Option<SumId> {
        let id = SumId(sums.len());
        self.placed(sum, None, sums)?;
        Some(id)
    }

    /// Returns whether a number depends on the configuration.
    fn moves(&self, number: Expr) -> bool {
        let symbols: Vec<Symbol> = self.arena.symbols_of(number).collect();
        symbols
            .into_iter()
            .any(|symbol| match self.symbols.meaning(symbol) {
                Meaning::Slot(at) => self.scene.slots[*at].array.moves(),
                Meaning::Partial => self.kept_sum(symbol).is_some_and(|sum| {
                    let numbers = sum.head.numbers();
                    self.moves(sum.summand) || numbers.into_iter().any(|number| self.moves(number))
                }),
                _ => false,
            })
    }

    pub(super) fn kept_sum(&self, symbol: Symbol) -> Option<&Kept> {
        let mut sums = self.scene.sums.iter();
        sums.find(|(own, _)| *own == symbol).map(|(_, sum)| sum)
    }

    /// Gives the sums of a root their places. Terms of rows outside of all loops become a loop of
    /// one round.
    fn root(&mut self, number: Expr, at: Span, sums: &mut Vec<Sum>) -> Option<Expr> {
        let is_read = |s: Symbol| matches!(self.symbols.meaning(s), Meaning::Slot(_));
        let reads = |e: Expr| self.arena.symbols_of(e).any(is_read);
        let number = if reads(number) {
            let (constant, terms) = match self.arena.node(number) {
                Node::Sum(constant, terms) => (constant.get(), terms.clone()),
                _ => (0.0, vec![(number, crate::algebra::Bits::new(1.0))]),
            };
            let terms: Vec<(f64, Expr)> = terms.iter().map(|&(e, c)| (c.get(), e)).collect();
            let (inside, mut outside): (Vec<_>, Vec<_>) =
                terms.into_iter().partition(|&(_, term)| reads(term));
            let summand = self.arena.sum(0.0, &inside);
            let (counter, _) = self.scene.integers.counter("once".to_owned());
            let [from, to] = [0, 1].map(|i| self.scene.integers.constant(i));
            let sum = self.sum(&Head::For { counter, from, to }, summand, at);
            outside.push((1.0, sum));
            self.arena.sum(constant, &outside)
        } else {
            number
        };
        self.with_places(number, None, sums)
    }

    /// Returns a number with the final symbols of its sums, which are appended to `sums`.
    fn with_places(
        &mut self,
        number: Expr,
        parent: Option<SumId>,
        sums: &mut Vec<Sum>,
    ) -> Option<Expr> {
        let symbols: Vec<Symbol> = self.arena.symbols_of(number).collect();
        let mut by = HashMap::new();
        for symbol in symbols {
            if let Meaning::Partial = self.symbols.meaning(symbol) {
                let sum = self.placed(symbol, parent, sums)?;
                by.insert(symbol, self.arena.symbol(sum));
            }
        }
        Some(self.arena.substitute(number, &by))
    }

    /// Appends a sum and the sums in it. Returns its final symbol.
    fn placed(
        &mut self,
        symbol: Symbol,
        parent: Option<SumId>,
        sums: &mut Vec<Sum>,
    ) -> Option<Symbol> {
        let Kept { head, summand, at } = self.kept_sum(symbol)?;
        let (head, summand, at) = (head.clone(), *summand, *at);
        if sums.len() >= SUMS {
            let message = format!(
                "this scene has more than {SUMS} loops and conditions, the limit; a sum that several loops read is counted for each"
            );
            return self.refuse(&at, message);
        }
        let is_sum = |s: Symbol| matches!(self.symbols.meaning(s), Meaning::Partial);
        let numbers = head.numbers().into_iter();
        if numbers.flat_map(|e| self.arena.symbols_of(e)).any(is_sum) {
            return self.refuse(&at, "a condition on the result of a loop is not understood: conditions in kept loops are of indices, coordinates and fields");
        }
        let id = sums.len();
        let place = Sum {
            parent,
            head,
            summand,
            at,
        };
        sums.push(place);
        sums[id].summand = self.with_places(summand, Some(SumId(id)), sums)?;
        Some(self.symbols.declare(Meaning::Sum(id)))
    }
}

/// The processes of a function before its sums have their places.
enum Found {
    Listed(Vec<Expr>),
    Each(Vec<Symbol>),
}

fn name_span(function: &RoleFunction) -> Span {
    function.name.span()
}
