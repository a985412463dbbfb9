//! Loops and branches that are kept: the body is executed once and adds a sum to each variable
//! around it that it changes.
//!
//! In a loop, each number of an outer variable that the body assigns is a new symbol at the start
//! of a round. At the end of the round its value must be this symbol plus something free of it,
//! which is the summand. In a branch the number keeps its value, and the summand is the difference.

use std::collections::HashMap;

use proc_macro2::Span;
use syn::visit::Visit;

use super::assigned::assigned;
use super::streams::Stream;
use super::{Kept, Lowering};
use crate::algebra::{Expr, Symbol};
use crate::interpret::branches::{LoopExit, Truth};
use crate::interpret::frames::Place;
use crate::interpret::value::Value;
use crate::model::Meaning;
use crate::model::scene::Head;

/// A loop or branch that is being executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::interpret) enum Nest {
    Unrolled,
    Kept,
    Branch,
}

/// The facts that a kept body needs of its source.
pub(in crate::interpret) struct Body {
    /// The name of the counter, for messages.
    counter: String,
    /// The variables that are assigned, each with the place of its first assignment.
    assigned: Vec<(String, Span)>,
}

impl Body {
    /// Returns a body that assigns to no variable.
    pub(super) fn none(counter: &str) -> Self {
        Self {
            counter: counter.to_owned(),
            assigned: Vec::new(),
        }
    }

    /// Returns the body of a `for` loop.
    fn of_loop(pattern: &syn::Pat, block: &syn::Block) -> Self {
        let counter = match pattern {
            syn::Pat::Ident(name) => name.ident.to_string(),
            _ => "i".to_owned(),
        };
        Self {
            counter,
            assigned: assigned(|names| names.visit_block(block)),
        }
    }
}

/// An outer variable that a body assigns.
struct Target {
    name: String,
    place: Place,
    at: Span,
    before: Value,
    start: Value,
}

/// The numbers at the start of a body, by whether the body changes them.
#[derive(Default)]
struct Numbers {
    /// The symbols of numbers that the body does not change, with their values.
    unchanged: HashMap<Symbol, Expr>,
    changed: Vec<Symbol>,
}

impl Lowering<'_> {
    /// Executes a `for` loop whose rounds are not known at compile time.
    pub(in crate::interpret) fn kept_loop(
        &mut self,
        stream: &Stream,
        for_loop: &syn::ExprForLoop,
    ) -> Option<Value> {
        let body = Body::of_loop(&for_loop.pat, &for_loop.body);
        let at = for_loop.for_token.span;
        self.rounds(stream, at, &body, |x, value| {
            x.bind(&for_loop.pat, value);
            x.block_value(&for_loop.body);
            Some(Value::Unit)
        })
    }

    /// Executes a body for a value of a stream. The numbers that it returns are summed.
    pub(super) fn rounds(
        &mut self,
        stream: &Stream,
        at: Span,
        body: &Body,
        run: impl FnOnce(&mut Self, Value) -> Option<Value>,
    ) -> Option<Value> {
        self.tick(&at)?;
        let name = self.scene.free_name(&body.counter);
        let (counter, index) = self.scene.integers.counter(name.clone());
        let head = Head::For {
            counter,
            from: stream.from,
            to: stream.to,
        };
        self.scene.counters.push(name);
        let value = self.kept(Nest::Kept, &head, at, &body.assigned, |x| {
            let Some((closure, of)) = &stream.filter else {
                let value = (stream.item)(x, index)?;
                return run(x, value);
            };
            let value = of(x, index)?;
            match x.is_kept(closure, value)? {
                Truth::Known(false) => Some(Value::Unit),
                Truth::Known(true) => {
                    let value = (stream.item)(x, index)?;
                    run(x, value)
                }
                Truth::Running(condition) => {
                    let head = Head::If(condition);
                    x.kept(Nest::Branch, &head, at, &body.assigned, |x| {
                        let value = (stream.item)(x, index)?;
                        run(x, value)
                    })
                }
            }
        });
        self.scene.counters.pop();
        value
    }

    /// Ends a round of a loop, whose body may have skipped its rest.
    pub(in crate::interpret) fn end_round(&mut self) -> Option<LoopExit> {
        self.scene.rest = Truth::default();
        self.leaving.take()
    }

    /// Executes a body once. Each number that it changes becomes a sum with this head, and so does
    /// each number of the value that it returns.
    pub(super) fn kept(
        &mut self,
        nest: Nest,
        head: &Head,
        at: Span,
        names: &[(String, Span)],
        run: impl FnOnce(&mut Self) -> Option<Value>,
    ) -> Option<Value> {
        let (first, mistakes) = (self.scene.sums.len(), self.errors.count());
        let targets = self.targets(nest, names);
        self.scene.nests.push(nest);
        let value = self.scoped(run);
        self.scene.nests.pop();
        if nest == Nest::Kept {
            self.end_round();
        }
        if self.errors.count() > mistakes || value.is_none() {
            for target in &targets {
                self.set_target(target, Value::Poison);
            }
            return None;
        }
        let mut numbers = Numbers::default();
        for target in &targets {
            let after = self.frame.at(&target.place)?.clone();
            let values = [&target.before, &target.start, &after];
            let summed = self.leaves(values, &mut |x, values| {
                x.summed(target, head, at, values, &mut numbers)
            });
            self.set_target(target, summed.unwrap_or(Value::Poison));
        }
        if self.errors.count() > mistakes {
            return None;
        }
        if nest == Nest::Kept {
            self.check_order(first, &targets, &numbers)?;
            self.replace(first, &numbers.unchanged);
        }
        let value = value?;
        self.leaves([&value; 3], &mut |x, [value, ..]| match value {
            Value::Unit => Some(Value::Unit),
            // the whole `if` reports an integer that depends on its condition
            Value::Int(_) | Value::Index(_) if nest == Nest::Branch => Some(value.clone()),
            value => {
                let number = x.scalar(value, &at)?;
                Some(Value::Scalar(x.sum(head, number, at)))
            }
        })
    }

    fn set_target(&mut self, target: &Target, value: Value) {
        if let Some(place) = self.frame.at_mut(&target.place) {
            *place = value;
        }
    }

    /// Returns the outer variables of these names. In a loop their numbers become symbols.
    fn targets(&mut self, nest: Nest, names: &[(String, Span)]) -> Vec<Target> {
        let mut targets = Vec::new();
        for (name, at) in names {
            let Some(place) = self.frame.place(name) else {
                continue;
            };
            let place = self.frame.referenced(&place).unwrap_or(place);
            let Some(before) = self.frame.at(&place).cloned() else {
                continue;
            };
            let start = match nest {
                Nest::Kept => self.fresh(&before),
                _ => before.clone(),
            };
            let target = Target {
                name: name.clone(),
                place,
                at: *at,
                before,
                start,
            };
            self.set_target(&target, target.start.clone());
            targets.push(target);
        }
        targets
    }

    /// Returns a value with new symbols as its numbers.
    fn fresh(&mut self, value: &Value) -> Value {
        match value {
            Value::Scalar(_) | Value::Field(_) => {
                let symbol = self.symbols.declare(Meaning::Partial);
                Value::Scalar(self.arena.symbol(symbol))
            }
            _ => {
                let mut value = value.clone();
                for entry in value.list_mut().into_iter().flatten() {
                    *entry = self.fresh(entry);
                }
                value
            }
        }
    }

    /// Returns the value of a number after all rounds of a loop, or after a branch. The values are
    /// those before it, at the start and at the end of a round.
    fn summed(
        &mut self,
        target: &Target,
        head: &Head,
        at: Span,
        [before, start, after]: [&Value; 3],
        numbers: &mut Numbers,
    ) -> Option<Value> {
        match (before, start, after) {
            (_, _, Value::Poison) => return None,
            (Value::Unset, ..) if matches!(head, Head::For { .. }) => return Some(Value::Unset),
            (_, Value::Int(a), Value::Int(b)) if a.value == b.value => return Some(before.clone()),
            (_, Value::Index(a), Value::Index(b)) if a == b => return Some(before.clone()),
            (_, Value::Int(_) | Value::Index(_), _) => {
                let message = format!(
                    "the integer `{}` changes in a kept loop: compute it from the counters, on a ring with `%`, as in `(i + 1) % n`",
                    target.name
                );
                return self.refuse(&target.at, message);
            }
            (_, Value::Scalar(_) | Value::Field(_), _) => {}
            _ => return self.adds_only(target),
        }
        let before_number = self.scalar(before, &target.at)?;
        let start = self.scalar(start, &target.at)?;
        let end = self.scalar(after, &target.at)?;
        let symbol = match head {
            Head::For { .. } => self.arena.symbols_of(start).next(),
            Head::If(_) => None,
        };
        if start == end {
            numbers.unchanged.extend(symbol.map(|s| (s, before_number)));
            return Some(before.clone());
        }
        let summand = self.arena.sub(end, start);
        if symbol.is_some_and(|symbol| self.arena.contains(summand, symbol)) {
            return self.adds_only(target);
        }
        numbers.changed.extend(symbol);
        let sum = self.sum(head, summand, at);
        Some(Value::Scalar(self.arena.add(before_number, sum)))
    }

    fn adds_only<T>(&mut self, target: &Target) -> Option<T> {
        let name = &target.name;
        let message = format!(
            "a kept loop can only add to `{name}`: write `{name} += …` with terms that do not contain `{name}`"
        );
        self.refuse(&target.at, message)
    }

    /// Reports an error if a term contains a number that the loop accumulates.
    fn check_order(&mut self, first: usize, targets: &[Target], numbers: &Numbers) -> Option<()> {
        for &symbol in &numbers.changed {
            let contains = |expr: Expr| self.arena.contains(expr, symbol);
            let mut sums = self.scene.sums[first..].iter();
            let is_read = sums.any(|(_, sum)| {
                contains(sum.summand) || sum.head.numbers().into_iter().any(contains)
            });
            let number = self.arena.symbol(symbol);
            let is_target = |target: &&Target| has_number(&target.start, number);
            if is_read && let Some(target) = targets.iter().find(is_target) {
                return self.adds_only(target);
            }
        }
        Some(())
    }

    /// Replaces symbols in the sums of a body.
    fn replace(&mut self, first: usize, by: &HashMap<Symbol, Expr>) {
        if by.is_empty() {
            return;
        }
        for (_, sum) in &mut self.scene.sums[first..] {
            sum.summand = self.arena.substitute(sum.summand, by);
            let arena = &mut *self.arena;
            sum.head.replace(&mut |number| arena.substitute(number, by));
        }
    }

    /// Returns the symbol of a new sum.
    pub(super) fn sum(&mut self, head: &Head, summand: Expr, at: Span) -> Expr {
        if self.arena.constant_value(summand) == Some(0.0) {
            return summand;
        }
        let symbol = self.symbols.declare(Meaning::Partial);
        let kept = Kept {
            head: head.clone(),
            summand,
            at,
        };
        self.scene.sums.push((symbol, kept));
        self.arena.symbol(symbol)
    }

    /// Combines the entries of values of the same form.
    pub(super) fn leaves(
        &mut self,
        values: [&Value; 3],
        combine: &mut dyn FnMut(&mut Self, [&Value; 3]) -> Option<Value>,
    ) -> Option<Value> {
        let kind = std::mem::discriminant(values[2]);
        let length = values[2].items().len();
        let is_alike = |value: &&Value| {
            std::mem::discriminant(*value) == kind
                && value.list().is_some_and(|l| l.len() == length)
        };
        if !values.iter().all(is_alike) {
            return combine(self, values);
        }
        let mut result = values[2].clone();
        for (at, entry) in result.list_mut()?.iter_mut().enumerate() {
            *entry = self.leaves(values.map(|value| &value.items()[at]), combine)?;
        }
        Some(result)
    }
}

/// Returns whether a value has this number.
fn has_number(value: &Value, number: Expr) -> bool {
    match value {
        Value::Scalar(own) => *own == number,
        _ => value.items().iter().any(|entry| has_number(entry, number)),
    }
}
