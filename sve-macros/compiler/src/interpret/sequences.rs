//! Iterators over values that are known at compile time.
//!
//! An iterator is the list of its items. The items are computed at once and not on demand. The
//! results are the same, since closures that assign to captured variables are refused.

use syn::spanned::Spanned;
use syn::{Expr as Syntax, ExprMethodCall};

use super::Lowering;
use super::adapters;
use super::calls::Argument;
use super::fields::FieldPath;
use super::integers::Integer;
use super::methods::Call;
use super::value::Value;

pub(super) fn length(call: &Call<'_>) -> Value {
    Value::count(call.receiver.value.items().len())
}

pub(super) fn iterator(call: &Call<'_>) -> Value {
    Value::Sequence(call.receiver.value.items().to_vec())
}

pub(super) fn array(call: &Call<'_>) -> Value {
    Value::Array(call.receiver.value.items().to_vec())
}

/// Returns `map` of an array.
pub(super) fn map(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let items = call.receiver.value.items().to_vec();
    x.mapped(items, call.given.functions[0]).map(Value::Array)
}

pub(super) fn for_each(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    map(x, call).map(|_| Value::Unit)
}

pub(super) fn as_flattened(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let items = call.receiver.value.items().to_vec();
    adapters::flatten(x, items, call).map(Value::Array)
}

pub(super) fn fold(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (start, function) = (&call.given.values[0], call.given.functions[0]);
    let mut value = start.value.clone();
    let mistakes = x.errors.count();
    for item in call.receiver.value.items() {
        let start = Argument {
            value,
            at: start.at,
        };
        let arguments = vec![start, argument(item.clone(), function)];
        value = x.apply(function, arguments).unwrap_or(Value::Poison);
        if x.errors.count() > mistakes {
            return None;
        }
        x.tick(function)?;
    }
    Some(value)
}

/// Evaluates `windows`, `chunks` and `chunks_exact`.
pub(super) fn chunks(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (items, n) = (call.receiver.value.items(), call.given.counts[0]);
    let at = &call.syntax.args[0];
    if n == 0 {
        return x.refuse(at, "pieces of length 0 do not end: write 1 or more");
    }
    let array = |piece: &[Value]| Value::Array(piece.to_vec());
    let chunks: Vec<Value> = match call.syntax.method.to_string().as_str() {
        "windows" => items.windows(n).map(array).collect(),
        "chunks" => items.chunks(n).map(array).collect(),
        _ => items.chunks_exact(n).map(array).collect(),
    };
    x.work(n.saturating_mul(chunks.len()), at)?;
    Some(Value::Sequence(chunks))
}

/// Evaluates `sum` and `product` of numbers or of integers.
pub(super) fn total(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (items, call) = (call.receiver.value.items(), call.syntax);
    let is_sum = call.method == "sum";
    if is_sum && let Some(ty) = x.type_of_sum(call, items) {
        return x.sum_of_matrices(call, items, ty);
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
            let next = x.computed(next, i.kind.or(total.kind), &call.method)?;
            let Value::Int(next) = next else { return None };
            total = next;
        }
        return Some(Value::Int(total));
    }
    let mut numbers = Vec::new();
    for item in items {
        numbers.push(x.scalar(item, &call.receiver)?);
    }
    Some(Value::Scalar(if is_sum {
        let terms: Vec<_> = numbers.into_iter().map(|x| (1.0, x)).collect();
        x.arena.sum(0.0, &terms)
    } else {
        let factors: Vec<_> = numbers.into_iter().map(|x| (x, 1)).collect();
        x.arena.product(&factors)
    }))
}

impl Lowering<'_> {
    /// Calls a method of a field, whose length the macro does not know. The length follows from an
    /// iterator with which it is zipped.
    pub(super) fn method_of_unsized(
        &mut self,
        call: &ExprMethodCall,
        path: &FieldPath,
    ) -> Option<Value> {
        let mut message = no_length(path);
        match (call.method.to_string().as_str(), call.args.first()) {
            ("iter" | "into_iter" | "copied" | "cloned", None) => {
                return Some(Value::Field(path.clone()));
            }
            ("zip", Some(other)) if call.args.len() == 1 => {
                let other = self.argument(other);
                let others = self.items(&other, None)?.into_iter().enumerate();
                let pair = |(i, item)| Value::Tuple(vec![Value::Field(path.index(i)), item]);
                return Some(Value::Sequence(others.map(pair).collect()));
            }
            ("map" | "fold", _) => {
                let vector = self.example_of_vector();
                let (name, field) = (path.name(), crate::syntax::readable(&path.access()));
                message = format!("{message} of a vector write `let {name}: {vector} = {field};`");
            }
            _ => {}
        }
        self.refuse(&call.method, message)
    }

    /// Returns the items of an array or iterator, and the first `length` entries of a field.
    pub(super) fn items(
        &mut self,
        argument: &Argument,
        length: Option<usize>,
    ) -> Option<Vec<Value>> {
        let message = match (&argument.value, length) {
            (value @ (Value::Array(_) | Value::Sequence(_) | Value::Matrix(_)), _) => {
                return Some(value.items().to_vec());
            }
            (Value::Field(path), Some(length)) => {
                return Some((0..length).map(|i| Value::Field(path.index(i))).collect());
            }
            (Value::Poison, _) => return None,
            (Value::Field(path), None) if !path.is_self() => no_length(path),
            (other, _) => format!(
                "a loop runs over a range `A..B` with bounds known at compile time or over an array, and this is {}",
                other.kind()
            ),
        };
        self.refuse(&argument.at, message)
    }

    /// Maps items by a closure that Rust runs only when the results are used.
    pub(super) fn mapped_lazily(
        &mut self,
        items: Vec<Value>,
        function: &Syntax,
    ) -> Option<Vec<Value>> {
        let is_lazy = std::mem::replace(&mut self.frame.is_lazy, true);
        let items = self.mapped(items, function);
        self.frame.is_lazy = is_lazy;
        items
    }

    /// Maps items by a closure.
    pub(super) fn mapped(&mut self, items: Vec<Value>, function: &Syntax) -> Option<Vec<Value>> {
        self.mapped_lists(items.into_iter().map(|item| vec![item]), function)
    }

    /// Calls a closure with each list of values. Returns `None` after the first mistake, which the
    /// next call would repeat.
    pub(super) fn mapped_lists(
        &mut self,
        lists: impl Iterator<Item = Vec<Value>>,
        function: &Syntax,
    ) -> Option<Vec<Value>> {
        let mistakes = self.errors.count();
        let mut results = Vec::new();
        for list in lists {
            let list = list.into_iter();
            let arguments = list.map(|value| argument(value, function)).collect();
            let result = self.apply(function, arguments);
            results.push(result.unwrap_or(Value::Poison));
            if self.errors.count() > mistakes {
                return None;
            }
            self.tick(function)?;
        }
        Some(results)
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
