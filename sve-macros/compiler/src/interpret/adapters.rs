//! Adapters of iterators: methods that return another iterator.

use syn::Expr as Syntax;

use super::Lowering;
use super::branches::{Truth, Undecided};
use super::calls::Argument;
use super::methods::Call;
use super::value::Value;

type Items = Option<Vec<Value>>;

pub(super) fn map(x: &mut Lowering<'_>, items: Vec<Value>, call: &Call<'_>) -> Items {
    x.mapped_lazily(items, call.given.functions[0])
}

pub(super) fn flat_map(x: &mut Lowering<'_>, items: Vec<Value>, call: &Call<'_>) -> Items {
    let items = x.mapped_lazily(items, call.given.functions[0])?;
    flatten(x, items, call)
}

pub(super) fn flatten(x: &mut Lowering<'_>, items: Vec<Value>, call: &Call<'_>) -> Items {
    let at = call.syntax.method.span();
    let mut flat = Vec::new();
    for value in items {
        flat.extend(x.items(&Argument { value, at }, None)?);
    }
    x.work(flat.len(), &at)?;
    Some(flat)
}

pub(super) fn rev(call: &Call<'_>) -> Value {
    let items = call.receiver.value.items().iter().cloned();
    Value::Sequence(items.rev().collect())
}

pub(super) fn enumerate(call: &Call<'_>) -> Value {
    let items = call.receiver.value.items().iter().cloned().enumerate();
    Value::Sequence(items.map(|(i, item)| pair(Value::count(i), item)).collect())
}

pub(super) fn zip(x: &mut Lowering<'_>, items: Vec<Value>, call: &Call<'_>) -> Items {
    let others = x.items(&call.given.values[0], Some(items.len()))?;
    let pairs = items.into_iter().zip(others);
    Some(pairs.map(|(a, b)| pair(a, b)).collect())
}

pub(super) fn chain(x: &mut Lowering<'_>, mut items: Vec<Value>, call: &Call<'_>) -> Items {
    items.extend(x.items(&call.given.values[0], None)?);
    Some(items)
}

pub(super) fn skip(call: &Call<'_>) -> Value {
    let items = call.receiver.value.items().iter().cloned();
    Value::Sequence(items.skip(call.given.counts[0]).collect())
}

pub(super) fn take(call: &Call<'_>) -> Value {
    let items = call.receiver.value.items().iter().cloned();
    Value::Sequence(items.take(call.given.counts[0]).collect())
}

pub(super) fn step_by(x: &mut Lowering<'_>, items: Vec<Value>, call: &Call<'_>) -> Items {
    match call.given.counts[0] {
        0 => x.refuse(
            &call.syntax.args[0],
            "a step of 0 does not end: write `.step_by(1)` or more",
        ),
        count => Some(items.into_iter().step_by(count).collect()),
    }
}

pub(super) fn filter(x: &mut Lowering<'_>, items: Vec<Value>, call: &Call<'_>) -> Items {
    let function = call.given.functions[0];
    let Syntax::Closure(closure) = function else {
        return x.refuse(
            function,
            "`filter` takes a closure, as in `.filter(|&j| j != i)`",
        );
    };
    let mut kept = Vec::new();
    for item in items {
        let decision = x.scoped(|x| {
            if let Some(pattern) = closure.inputs.first() {
                x.bind(pattern, item.clone());
            }
            x.decide(&closure.body)
        });
        match decision {
            Ok(Truth::Known(true)) => kept.push(item),
            Ok(Truth::Known(false)) => {}
            Err(Undecided::Reported) => return None,
            Ok(Truth::Running(_)) | Err(Undecided::Unknown) => {
                return x.refuse(&closure.body, "what `filter` keeps must be known at compile time: compare indices, as in `j != i`");
            }
        }
    }
    Some(kept)
}

fn pair(a: Value, b: Value) -> Value {
    Value::Tuple(vec![a, b])
}
