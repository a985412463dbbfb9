//! Iterators over what is known at compile time.
//!
//! An iterator is the list of its items. The items are computed at once and not on demand. The results are the same, since closures
//! that assign to captured variables are refused.

use std::collections::HashMap;

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, ExprMethodCall};

use super::Lowering;
use super::branches::Undecided;
use super::calls::Argument;
use super::conversions::NO_LENGTH;
use super::fields::FieldPath;
use super::floats;
use super::integers::Integer;
use super::value::Value;

/// Methods of arrays and iterators that are understood.
const METHODS: &[&str] = &[
    "iter",
    "for_each",
    "into_iter",
    "copied",
    "cloned",
    "len",
    "as_flattened",
    "rev",
    "enumerate",
    "flatten",
    "zip",
    "chain",
    "map",
    "flat_map",
    "filter",
    "skip",
    "take",
    "step_by",
    "windows",
    "chunks",
    "chunks_exact",
    "sum",
    "product",
    "fold",
];

/// Returns whether arrays or iterators have a method of this name.
pub(super) fn is_method(name: &str) -> bool {
    METHODS.contains(&name)
}

impl Lowering<'_> {
    /// Calls a method of an array or an iterator; `None` if the receiver is neither.
    pub(super) fn sequence_method(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Argument,
    ) -> Option<Value> {
        let name = call.method.to_string();
        let known = METHODS.contains(&name.as_str());
        let items = match &receiver.value {
            Value::Array(items) | Value::Sequence(items) => items.clone(),
            Value::Field(path) if known => return Some(self.of_field(call, path)),
            Value::Generated(_) => return Some(self.refuse(&call.method, NO_LENGTH)),
            _ => return None,
        };
        if !known {
            return Some(self.refuse(&call.method, not_understood(&name)));
        }
        if !self.work(items.len(), call) {
            return Some(Value::Poison);
        }
        let is_array = matches!(receiver.value, Value::Array(_));
        let arguments: Vec<&Syntax> = call.args.iter().collect();
        Some(match (name.as_str(), arguments.as_slice()) {
            ("len", []) => Value::Int(Integer::count(items.len())),
            ("iter" | "into_iter" | "copied" | "cloned", []) => Value::Sequence(items),
            ("map", [function]) if is_array => match self.mapped(items, function) {
                Some(items) => Value::Array(items),
                None => Value::Poison,
            },
            ("map", [function]) => match self.mapped_lazily(items, function) {
                Some(items) => Value::Sequence(items),
                None => Value::Poison,
            },
            ("for_each", [function]) if !is_array => match self.mapped(items, function) {
                Some(_) => Value::Unit,
                None => Value::Poison,
            },
            ("windows" | "chunks" | "chunks_exact", [length]) => self.chunks(&name, &items, length),
            ("as_flattened", []) => match self.flattened(items, call.method.span()) {
                Some(items) => Value::Array(items),
                None => Value::Poison,
            },
            ("sum" | "product", []) => self.total(call, items),
            ("fold", [start, function]) => self.fold(items, start, function),
            (_, arguments) => match self.adapted(call, items, arguments) {
                Some(items) => Value::Sequence(items),
                None => Value::Poison,
            },
        })
    }

    /// Calls a method that returns another iterator.
    fn adapted(
        &mut self,
        call: &ExprMethodCall,
        items: Vec<Value>,
        arguments: &[&Syntax],
    ) -> Option<Vec<Value>> {
        let name = call.method.to_string();
        Some(match (name.as_str(), arguments) {
            ("rev", []) => items.into_iter().rev().collect(),
            ("enumerate", []) => items
                .into_iter()
                .enumerate()
                .map(|(i, item)| Value::Tuple(vec![Value::Int(Integer::count(i)), item]))
                .collect(),
            ("flatten", []) => self.flattened(items, call.method.span())?,
            ("flat_map", [function]) => {
                let items = self.mapped_lazily(items, function)?;
                self.flattened(items, call.method.span())?
            }
            ("zip", [other]) => {
                let other = self.argument(other);
                let others = self.items(&other, Some(items.len()))?;
                items
                    .into_iter()
                    .zip(others)
                    .map(|(a, b)| Value::Tuple(vec![a, b]))
                    .collect()
            }
            ("chain", [other]) => {
                let other = self.argument(other);
                let others = self.items(&other, None)?;
                items.into_iter().chain(others).collect()
            }
            ("filter", [function]) => self.filtered(items, function)?,
            ("skip", [count]) => {
                let count = self.index_value(count)?;
                items.into_iter().skip(count).collect()
            }
            ("take", [count]) => {
                let count = self.index_value(count)?;
                items.into_iter().take(count).collect()
            }
            ("step_by", [count]) => match self.index_value(count)? {
                0 => {
                    self.refuse(
                        count,
                        "a step of 0 does not end: write `.step_by(1)` or more",
                    );
                    return None;
                }
                count => items.into_iter().step_by(count).collect(),
            },
            _ => {
                let message = format!("`{name}` does not take {} arguments", arguments.len());
                self.refuse(&call.method, message);
                return None;
            }
        })
    }

    /// Calls a method of a field, whose length the macro does not know. The length follows from an iterator with which it is zipped.
    fn of_field(&mut self, call: &ExprMethodCall, path: &FieldPath) -> Value {
        let arguments: Vec<&Syntax> = call.args.iter().collect();
        match (call.method.to_string().as_str(), arguments.as_slice()) {
            ("iter" | "into_iter" | "copied" | "cloned", []) => Value::Field(path.clone()),
            ("zip", [other]) => {
                let other = self.argument(other);
                let Some(others) = self.items(&other, None) else {
                    return Value::Poison;
                };
                let pair = |(i, item)| Value::Tuple(vec![Value::Field(path.index(i)), item]);
                Value::Sequence(others.into_iter().enumerate().map(pair).collect())
            }
            ("map" | "fold", _) => {
                let vector = self.example_of_vector();
                let (name, field) = (path.name(), crate::syntax::readable(&path.access()));
                let of_vector = format!(" of a vector write `let {name}: {vector} = {field};`");
                self.refuse(&call.method, no_length(path) + &of_vector)
            }
            _ => self.refuse(&call.method, no_length(path)),
        }
    }

    /// Returns the items of an array or iterator, and the first `length` entries of a field.
    pub(super) fn items(
        &mut self,
        argument: &Argument,
        length: Option<usize>,
    ) -> Option<Vec<Value>> {
        match (&argument.value, length) {
            (Value::Array(items) | Value::Sequence(items), _) => Some(items.clone()),
            (Value::Matrix(matrix), _) => Some(matrix.entries.clone()),
            (Value::Field(path), Some(length)) => {
                Some((0..length).map(|i| Value::Field(path.index(i))).collect())
            }
            (Value::Field(path), None) if !path.is_self() => {
                self.refuse(&argument.at, no_length(path));
                None
            }
            (Value::Poison, _) => None,
            (other, _) => {
                let message = format!(
                    "a loop runs over a range `A..B` with bounds known at compile time or over an array, and this is {}",
                    other.kind()
                );
                self.refuse(&argument.at, message);
                None
            }
        }
    }

    fn flattened(&mut self, items: Vec<Value>, at: Span) -> Option<Vec<Value>> {
        let mut flat = Vec::new();
        for value in items {
            flat.extend(self.items(&Argument { value, at }, None)?);
        }
        self.work(flat.len(), &at).then_some(flat)
    }

    /// Maps items by a closure that Rust runs only when the results are used.
    fn mapped_lazily(&mut self, items: Vec<Value>, function: &Syntax) -> Option<Vec<Value>> {
        let is_lazy = std::mem::replace(&mut self.is_lazy, true);
        let items = self.mapped(items, function);
        self.is_lazy = is_lazy;
        items
    }

    pub(super) fn mapped(&mut self, items: Vec<Value>, function: &Syntax) -> Option<Vec<Value>> {
        let mistakes = self.errors.count();
        let mut results = Vec::new();
        for item in items {
            results.push(self.apply(function, vec![argument(item, function)]));
            if self.errors.count() > mistakes || !self.tick(function) {
                // the next item would repeat the error
                return None;
            }
        }
        Some(results)
    }

    fn filtered(&mut self, items: Vec<Value>, function: &Syntax) -> Option<Vec<Value>> {
        let Syntax::Closure(closure) = function else {
            self.refuse(
                function,
                "`filter` takes a closure, as in `.filter(|&j| j != i)`",
            );
            return None;
        };
        let mut kept = Vec::new();
        for item in items {
            self.scopes.push(HashMap::new());
            if let Some(pattern) = closure.inputs.first() {
                self.bind(pattern, item.clone());
            }
            let decision = self.decide(&closure.body);
            self.scopes.pop();
            match decision {
                Ok(true) => kept.push(item),
                Ok(false) => {}
                Err(Undecided::Reported) => return None,
                Err(Undecided::Unknown) => {
                    self.refuse(&closure.body, "what `filter` keeps must be known at compile time: compare indices, as in `j != i`");
                    return None;
                }
            }
        }
        Some(kept)
    }

    pub(super) fn fold(&mut self, items: Vec<Value>, start: &Syntax, function: &Syntax) -> Value {
        let mut value = self.eval(start);
        let mistakes = self.errors.count();
        for item in items {
            let arguments = vec![argument(value, start), argument(item, function)];
            value = self.apply(function, arguments);
            if self.errors.count() > mistakes || !self.tick(function) {
                return Value::Poison;
            }
        }
        value
    }

    /// Evaluates `sum` and `product` of numbers or of integers.
    fn total(&mut self, call: &ExprMethodCall, items: Vec<Value>) -> Value {
        let is_sum = call.method == "sum";
        if is_sum && let Some(sum) = self.sum_of_matrices(call, &items) {
            return sum;
        }
        let named = call.turbofish.as_ref().map(crate::syntax::readable);
        let floats = match &named {
            Some(name) => name.contains("f64") || name.contains('_'),
            None => items.is_empty(),
        };
        if !floats && items.iter().all(|item| matches!(item, Value::Int(_))) {
            let mut total = Integer::from(i64::from(!is_sum));
            for item in items {
                let Value::Int(i) = item else { continue };
                let next = if is_sum {
                    total.value.checked_add(i.value)
                } else {
                    total.value.checked_mul(i.value)
                };
                let Value::Int(next) = self.computed(next, i.kind.or(total.kind), &call.method)
                else {
                    return Value::Poison;
                };
                total = next;
            }
            return Value::Int(total);
        }
        let mut numbers = Vec::new();
        for item in items {
            let Some(number) = self.scalar(&item, &call.receiver) else {
                return Value::Poison;
            };
            numbers.push(number);
        }
        Value::Scalar(if is_sum {
            let terms: Vec<_> = numbers.into_iter().map(|x| (1.0, x)).collect();
            self.arena.sum(0.0, &terms)
        } else {
            let factors: Vec<_> = numbers.into_iter().map(|x| (x, 1)).collect();
            self.arena.product(&factors)
        })
    }

    /// Evaluates `windows`, `chunks` and `chunks_exact`.
    fn chunks(&mut self, name: &str, items: &[Value], length: &Syntax) -> Value {
        let n = match self.index_value(length) {
            Some(0) => {
                return self.refuse(length, "pieces of length 0 do not end: write 1 or more");
            }
            Some(n) => n,
            None => return Value::Poison,
        };
        let chunks: Vec<Value> = match name {
            "windows" => items.windows(n).map(|w| Value::Array(w.to_vec())).collect(),
            "chunks" => items.chunks(n).map(|w| Value::Array(w.to_vec())).collect(),
            _ => items
                .chunks_exact(n)
                .map(|w| Value::Array(w.to_vec()))
                .collect(),
        };
        if self.work(n.saturating_mul(chunks.len()), length) {
            Value::Sequence(chunks)
        } else {
            Value::Poison
        }
    }
}

fn argument(value: Value, at: &Syntax) -> Argument {
    Argument {
        value,
        at: at.span(),
    }
}

fn no_length(path: &FieldPath) -> String {
    let name = crate::syntax::readable(&path.access());
    format!(
        "the length of `{name}` is not known to the macro: write `for i in 0..N` and `{name}[i]`, zip it with the coordinates, or name its type, `let a: [f64; N] = {name};`"
    )
}

fn not_understood(name: &str) -> String {
    let instead = match name {
        "collect" => {
            "fill an array in a loop, `let mut a = [0.0; N]; for i in 0..N { a[i] = …; }`, or use `map` of an array"
        }
        "first" | "last" => "write `x[0]` or `x[x.len() - 1]`",
        "split_at" | "split_first" | "split_last" => "write pieces, `&x[..2]` and `&x[2..]`",
        "try_into" => "write the array, `[x[0], x[1]]`",
        "cycle" | "scan" | "take_while" | "skip_while" | "last_mut" => {
            "write a loop over indices; the next on a ring is `x[(i + 1) % N]`"
        }
        "for_each" => "write a loop over indices, `for i in 0..N { a[i] = …; }`",
        "max" | "min" | "max_by" | "min_by" | "any" | "all" | "position" | "find" => {
            "it is not smooth in the entries"
        }
        _ if floats::is_smooth_method(name) => {
            return format!(
                "`{name}` is a function of one number: take an entry, `x[i].{name}(…)`, or write `.map(|x| x.{name}(…))`"
            );
        }
        "dot" | "norm" | "norm_squared" | "dist" | "length" => {
            "arrays have no such method: write the sum, `a[0] * b[0] + a[1] * b[1]`, as a function of this block"
        }
        _ => "write a loop, `let mut sum = 0.0; for i in 0..N { sum += …; }`",
    };
    format!("`{name}` of an array or iterator is not understood: {instead}")
}
