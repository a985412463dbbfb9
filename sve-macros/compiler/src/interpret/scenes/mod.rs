//! Scenes: the arguments are slices, so lengths, indices and bounds of loops are integers that are
//! known only when the program runs.
//!
//! Reads with such an index are symbols, equal ones the same symbol. A loop over a range with such
//! a bound is executed once and kept as a sum (`kept.rs`, branches in `branches.rs`); rows and
//! iterators over them are functions of an index (`streams.rs`). Whether a field is a number or an
//! integer follows from its uses; the block is executed again if a use shows this too late
//! ([`Known`](super::fields::Known)).

mod assigned;
mod branches;
mod kept;
mod on_sites;
mod roots;
pub(super) mod streams;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use proc_macro2::Span;
use syn::Member;
use syn::spanned::Spanned;

use super::Lowering;
use super::branches::Truth;
use super::fields::{FieldPath, FieldStep};
use super::types::Shape;
use super::value::Value;
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;
use crate::model::scene::{Access, Array, Head, Int, IntNode, Integers, Slot, SlotArray, Step};
pub(super) use kept::Nest;

/// The parts of a scene that are known so far.
#[derive(Default)]
pub(super) struct Building {
    /// The shape of a row; `None` if the block is no scene.
    shape: Option<Shape>,
    pub(super) integers: Integers,
    slots: Vec<Slot>,
    symbols: HashMap<Slot, Symbol>,
    /// The sums in the order in which they end, each with a symbol that stands for it until the
    /// sums have their final places.
    sums: Vec<(Symbol, Kept)>,
    /// The loops and branches that are being executed.
    nests: Vec<Nest>,
    /// The names of the counters of the kept loops that are being executed.
    counters: Vec<String>,
    /// True if the rest of the body of the loop is executed, after a `continue`.
    rest: Truth,
}

/// A kept loop.
struct Kept {
    head: Head,
    summand: Expr,
    at: Span,
}

impl Building {
    /// Returns the name of a counter, or another one if a loop around it has that name.
    fn free_name(&self, wanted: &str) -> String {
        let names = [wanted, "j", "k", "l", "m"].into_iter();
        let mut free = names.filter(|name| !self.counters.iter().any(|taken| taken == name));
        free.next().unwrap_or(wanted).to_owned()
    }

    pub(super) fn is_scene(&self) -> bool {
        self.shape.is_some()
    }

    pub(super) fn is_in_kept_loop(&self) -> bool {
        self.nests.contains(&Nest::Kept)
    }

    /// Returns the innermost loop or branch that is being executed.
    pub(super) fn nest(&self) -> Option<Nest> {
        self.nests.last().copied()
    }

    /// Returns whether the rest of a block is executed, if a `continue` has come before it.
    pub(super) fn rest(&mut self) -> Option<Truth> {
        match &self.rest {
            Truth::Known(true) => None,
            _ => Some(std::mem::take(&mut self.rest)),
        }
    }

    pub(super) fn binary(&mut self, node: fn(Int, Int) -> IntNode, a: Int, b: Int) -> Int {
        self.integers.integer(node(a, b))
    }

    /// Returns `a + count`.
    fn shifted(&mut self, a: Int, count: i64) -> Int {
        let count = self.integers.constant(count);
        self.binary(IntNode::Add, a, count)
    }

    /// Returns the path of a field. `into` needs no function of the runtime here: an entry of an
    /// array and of a vector are read alike.
    fn access(&mut self, path: &FieldPath) -> Access {
        let mut constant = |i: usize| self.integers.constant(i as i64);
        let steps = path.steps().iter().map(|step| match *step {
            FieldStep::Named(ref name) => Step::Member(Member::Named(name.clone())),
            FieldStep::Numbered(index) => Step::Member(Member::from(index as usize)),
            FieldStep::Index(index, _) => Step::Index(constant(index)),
            FieldStep::Pair(row, column, _) | FieldStep::Read(_, row, column) => {
                Step::Pair(constant(row), constant(column))
            }
            FieldStep::At(index, _) => Step::Index(index),
            FieldStep::AtPair(row, column, _) => Step::Pair(row, column),
        });
        Access {
            steps: steps.collect(),
        }
    }

    fn length_of(&mut self, path: &FieldPath) -> Int {
        let access = self.access(path);
        self.integers.integer(IntNode::Length(Array::Field(access)))
    }
}

impl Lowering<'_> {
    /// Calls `run` for a round of a loop that is not kept.
    pub(super) fn unrolled(&mut self, run: impl FnOnce(&mut Self)) {
        self.scene.nests.push(Nest::Unrolled);
        self.scoped(run);
        self.scene.nests.pop();
    }

    /// Returns the symbol of a read.
    fn slot(&mut self, array: SlotArray, component: usize) -> Expr {
        let Building { slots, symbols, .. } = &mut self.scene;
        let slot = Slot { array, component };
        let symbol = *symbols.entry(slot.clone()).or_insert_with(|| {
            slots.push(slot);
            self.symbols.declare(Meaning::Slot(slots.len() - 1))
        });
        self.arena.symbol(symbol)
    }

    /// Returns the symbol of a number that a field holds, whose path has an index known when the
    /// program runs.
    pub(super) fn field_slot(&mut self, path: &FieldPath) -> Expr {
        let access = self.scene.access(path);
        self.slot(SlotArray::Field(access), 0)
    }

    /// Returns an integer as a number.
    pub(super) fn number_of(&mut self, integer: Int) -> Expr {
        match self.scene.integers.value(integer) {
            Some(value) => self.arena.constant(value as f64),
            None => self.slot(SlotArray::Number(integer), 0),
        }
    }

    /// Returns the integer nearest to a number, a constant for derivatives.
    pub(super) fn rounded(&mut self, number: Expr, at: Span) -> Option<Value> {
        if let Some(value) = self.arena.constant_value(number) {
            return Some(Value::Scalar(self.arena.constant(value.round())));
        }
        for symbol in self.arena.symbols_of(number).collect::<Vec<_>>() {
            let what = match self.symbols.meaning(symbol) {
                Meaning::Partial => "of a sum or of a variable that a loop changes",
                Meaning::Slot(slot)
                    if matches!(
                        self.scene.slots[*slot].array,
                        SlotArray::Velocity(_) | SlotArray::Momentum(_)
                    ) =>
                {
                    "of a velocity or momentum"
                }
                _ => continue,
            };
            let message = format!(
                "`round` {what} is not understood: it counts the periods between two sites, `d - self.side * (d / self.side).round()`"
            );
            return self.refuse(&at, message);
        }
        let number = self.slot(SlotArray::Rounded(number), 0);
        Some(Value::Scalar(number))
    }

    /// Returns the value of an integer: known at compile time if it can be.
    pub(super) fn index_value_of(&self, integer: Int) -> Value {
        match self.scene.integers.value(integer) {
            Some(value) => Value::Int(value.into()),
            None => Value::Index(integer),
        }
    }

    /// Returns the integer that a field of a scene holds, if a use has shown that it is one.
    pub(super) fn known_integer(&mut self, value: Value) -> Value {
        match &value {
            Value::Field(path) if self.scene.is_scene() && self.fields.is_integer(path) => {
                let access = self.scene.access(path);
                Value::Index(self.scene.integers.integer(IntNode::Field(access)))
            }
            _ => value,
        }
    }

    /// Returns a value of a scene as an integer; `None` if it is none. A field becomes an integer,
    /// and so do the fields of an expression of fields alone.
    pub(super) fn running(&mut self, value: &Value) -> Option<Int> {
        if !self.scene.is_scene() {
            return None;
        }
        match value {
            Value::Int(i) => Some(self.scene.integers.constant(i.value)),
            Value::Index(integer) => Some(*integer),
            Value::Converted(inner) => self.running(inner),
            Value::Field(path) if path.is_self() || path.is_outside() => None,
            Value::Field(path) => {
                self.fields.learn_integer(path);
                let access = self.scene.access(path);
                Some(self.scene.integers.integer(IntNode::Field(access)))
            }
            Value::Scalar(number) => {
                let symbols: Vec<Symbol> = self.arena.symbols_of(*number).collect();
                let paths = symbols.iter().map(|&symbol| self.fields.path_of(symbol));
                let paths: Vec<FieldPath> = paths.collect::<Option<_>>()?;
                for path in &paths {
                    self.fields.learn_integer(path);
                }
                // a placeholder, since the block is executed again
                (!paths.is_empty()).then(|| self.scene.integers.constant(0))
            }
            _ => None,
        }
    }

    /// Returns a value as an integer, or reports an error at `at`.
    pub(super) fn integer_at(&mut self, value: &Value, at: &impl Spanned) -> Option<Int> {
        if let Value::Poison = value {
            return None;
        }
        self.running(value).or_else(|| {
            let message = format!("an integer belongs here, and this is {}", value.kind());
            self.refuse(at, message)
        })
    }

    /// Computes with two values of which one is an integer known when the program runs; `None` if
    /// neither is, or the other is none.
    pub(super) fn running_pair(&mut self, left: &Value, right: &Value) -> Option<(Int, Int)> {
        let is_integer = |value: &Value| matches!(value, Value::Int(_) | Value::Index(_));
        let is_known = |value: &Value| matches!(value, Value::Int(_));
        let both_known = is_known(left) && is_known(right);
        if both_known || !(is_integer(left) || is_integer(right)) {
            return None;
        }
        self.running(left).zip(self.running(right))
    }

    /// Computes with two integers of which one is known when the program runs only.
    pub(super) fn running_arithmetic(&mut self, op: char, a: Int, b: Int) -> Value {
        let node = match op {
            '+' => IntNode::Add,
            '-' => IntNode::Sub,
            '*' => IntNode::Mul,
            '%' => IntNode::Rem,
            _ => IntNode::Div,
        };
        let result = self.scene.binary(node, a, b);
        self.index_value_of(result)
    }

    /// Calls a method of integers; `None` if there is no such method, or an operand is no integer.
    pub(super) fn running_method(&mut self, name: &str, values: &[&Value]) -> Option<Value> {
        let [a, b] = values else { return None };
        let (a, b) = self.running_pair(a, b)?;
        let scene = &mut self.scene;
        let result = match name {
            "min" => scene.binary(IntNode::Min, a, b),
            "max" => scene.binary(IntNode::Max, a, b),
            "abs_diff" | "saturating_sub" => {
                let there = scene.binary(IntNode::Sub, a, b);
                let back = match name {
                    "abs_diff" => scene.binary(IntNode::Sub, b, a),
                    _ => scene.integers.constant(0),
                };
                scene.binary(IntNode::Max, there, back)
            }
            _ => return None,
        };
        Some(self.index_value_of(result))
    }

    /// Returns the row of the configuration or the velocity at an index.
    fn row(&mut self, array: fn(Int) -> SlotArray, index: Int) -> Value {
        let shape = self.scene.shape.clone().unwrap_or(Shape::Scalar);
        let components = (0..shape.len()).map(|at| self.slot(array(index), at));
        let components: Vec<Expr> = components.collect();
        let mut components = components.into_iter();
        shape.fill(&mut || components.next().map_or(Value::Poison, Value::Scalar))
    }
}
