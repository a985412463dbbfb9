//! Rows of a scene, ranges with bounds known when the program runs, and iterators over them.

use std::rc::Rc;

use syn::Expr as Syntax;
use syn::spanned::Spanned;

use super::Lowering;
use super::kept::Body;
use crate::interpret::branches::{Truth, Undecided};
use crate::interpret::calls::Argument;
use crate::interpret::fields::FieldPath;
use crate::interpret::methods::Call;
use crate::interpret::value::Value;
use crate::model::scene::{Comparison, Int, IntNode};

/// The message for a `Vec` that is made in another way.
pub(in crate::interpret) const NO_VEC: &str = "a `Vec` is made in one piece here: `q.iter().map(|x| …).collect()`, or `(0..q.len()).map(|i| …).collect()`";

/// The value at an index.
type Item = Rc<dyn Fn(&mut Lowering<'_>, Int) -> Option<Value>>;

/// Values at the indices `from..to`: a row of numbers or bodies, a range, or an iterator.
#[derive(Clone)]
pub(in crate::interpret) struct Stream {
    pub(super) from: Int,
    pub(super) to: Int,
    pub(super) item: Item,
    /// The closure and the iterator of `filter`: a value is skipped if the closure refuses it.
    pub(super) filter: Option<(Syntax, Item)>,
    /// True for arguments and fields, which have indices.
    is_row: bool,
}

impl Stream {
    pub(super) fn new(
        from: Int,
        to: Int,
        item: impl Fn(&mut Lowering<'_>, Int) -> Option<Value> + 'static,
    ) -> Self {
        Self {
            from,
            to,
            item: Rc::new(item),
            filter: None,
            is_row: false,
        }
    }

    pub(super) fn row(self) -> Self {
        Self {
            is_row: true,
            ..self
        }
    }

    /// Returns the values with others in their place.
    fn with(&self, item: impl Fn(&mut Lowering<'_>, Int) -> Option<Value> + 'static) -> Self {
        Self {
            item: Rc::new(item),
            is_row: false,
            ..self.clone()
        }
    }
}

impl Lowering<'_> {
    /// Returns an array or iterator whose length is known when the program runs; `None` for other
    /// values.
    pub(in crate::interpret) fn stream(&mut self, value: &Value) -> Option<Stream> {
        match value {
            Value::Stream(stream) => Some(stream.clone()),
            Value::Field(path) if self.scene.is_scene() && !path.is_self() => {
                let (from, to) = (self.scene.integers.constant(0), self.scene.length_of(path));
                Some(field(path, from, to))
            }
            _ => None,
        }
    }

    /// Returns the range of two integers of which one is known when the program runs only.
    pub(in crate::interpret) fn running_range(
        &mut self,
        range: &syn::ExprRange,
        bounds: [&Value; 2],
    ) -> Option<Value> {
        if let [Value::Int(_), Value::Int(_)] = bounds {
            return None;
        }
        let (from, to) = self.running(bounds[0]).zip(self.running(bounds[1]))?;
        let to = match range.limits {
            syn::RangeLimits::HalfOpen(_) => to,
            syn::RangeLimits::Closed(_) => self.scene.shifted(to, 1),
        };
        let counter = |x: &mut Lowering<'_>, index| Some(x.index_value_of(index));
        Some(Value::Stream(Stream::new(from, to, counter)))
    }

    /// Evaluates `x[A..B]`.
    pub(in crate::interpret) fn stream_slice(
        &mut self,
        stream: &Stream,
        range: &syn::ExprRange,
    ) -> Option<Value> {
        let mut bound = |bound: &Option<Box<Syntax>>| {
            let Some(bound) = bound else {
                return Some(None);
            };
            let value = self.value(bound);
            self.integer_at(&value, bound).map(Some)
        };
        let (start, end) = bound(&range.start).zip(bound(&range.end))?;
        let base = stream.from;
        let scene = &mut self.scene;
        let from = start.map_or(base, |start| scene.binary(IntNode::Add, base, start));
        let to = match (end, &range.limits) {
            (None, _) => stream.to,
            (Some(end), syn::RangeLimits::HalfOpen(_)) => scene.binary(IntNode::Add, base, end),
            (Some(end), syn::RangeLimits::Closed(_)) => {
                let last = scene.binary(IntNode::Add, base, end);
                scene.shifted(last, 1)
            }
        };
        let stream = stream.clone();
        Some(Value::Stream(Stream { from, to, ..stream }))
    }

    /// Returns an entry of an array.
    pub(in crate::interpret) fn stream_entry(
        &mut self,
        stream: &Stream,
        index: &Value,
        at: &impl Spanned,
    ) -> Option<Value> {
        if !stream.is_row {
            return self.refuse(at, "an iterator cannot be indexed");
        }
        let index = self.integer_at(index, at)?;
        let index = self.scene.binary(IntNode::Add, stream.from, index);
        (stream.item)(self, index)
    }

    fn rounds_of(&mut self, stream: &Stream) -> Int {
        self.scene.binary(IntNode::Sub, stream.to, stream.from)
    }

    /// Returns whether a stream has no entries.
    pub(in crate::interpret) fn is_empty(&mut self, stream: &Stream) -> Truth {
        let (length, zero) = (self.rounds_of(stream), self.scene.integers.constant(0));
        self.compared(Comparison::Equal, length, zero)
    }

    /// Returns the stream of a call of a method.
    fn receiver(&mut self, call: &Call<'_>) -> Option<Stream> {
        let stream = self.stream(&call.receiver.value)?;
        let name = call.syntax.method.to_string();
        if stream.filter.is_some() && !["map", "sum", "copied", "cloned"].contains(&name.as_str()) {
            let message = format!(
                "`{name}` behind `filter` is not understood, only `map` and `sum` are: write the condition into the closure, `if … {{ … }} else {{ 0.0 }}`"
            );
            return self.refuse(&call.syntax.method, message);
        }
        Some(stream)
    }
}

/// Returns the entries of a field.
pub(super) fn field(path: &FieldPath, from: Int, to: Int) -> Stream {
    let path = path.clone();
    let item = move |x: &mut Lowering<'_>, index| {
        let text = x.scene.integers.text(index);
        let entry = match x.scene.integers.value(index) {
            Some(index) => path.index(usize::try_from(index).ok()?),
            None => path.at(index, &text),
        };
        Some(x.known_integer(Value::Field(entry)))
    };
    Stream::new(from, to, item).row()
}

pub(in crate::interpret) fn length(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let stream = x.receiver(call)?;
    let length = x.rounds_of(&stream);
    Some(x.index_value_of(length))
}

/// Evaluates `iter`, `copied`, `collect` and their like.
pub(in crate::interpret) fn same(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    x.receiver(call).map(Value::Stream)
}

pub(in crate::interpret) fn map(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let stream = x.receiver(call)?;
    let function = call.given.functions[0].clone();
    let captured = match &function {
        Syntax::Closure(closure) => match x.capture(closure)? {
            Value::Closure(closure) => Some(closure),
            _ => None,
        },
        _ => None,
    };
    let inner = Rc::clone(&stream.item);
    let item = move |x: &mut Lowering<'_>, index| {
        let argument = Argument {
            value: inner(x, index)?,
            at: function.span(),
        };
        match &captured {
            Some(closure) => x.call_closure(closure, vec![argument], &function),
            None => x.apply(&function, vec![argument]),
        }
    };
    Some(Value::Stream(stream.with(item)))
}

pub(in crate::interpret) fn filter(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let stream = x.receiver(call)?;
    let function = call.given.functions[0].clone();
    if !matches!(function, Syntax::Closure(_)) {
        return x.refuse(
            &function,
            "`filter` takes a closure, as in `.filter(|&j| j != i)`",
        );
    }
    let filter = Some((function, Rc::clone(&stream.item)));
    Some(Value::Stream(Stream { filter, ..stream }))
}

pub(in crate::interpret) fn enumerate(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let stream = x.receiver(call)?;
    let (inner, from) = (Rc::clone(&stream.item), stream.from);
    let item = move |x: &mut Lowering<'_>, index| {
        let number = x.scene.binary(IntNode::Sub, index, from);
        let number = x.index_value_of(number);
        Some(Value::Tuple(vec![number, inner(x, index)?]))
    };
    Some(Value::Stream(stream.with(item)))
}

pub(in crate::interpret) fn zip(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (stream, other) = (x.receiver(call)?, &call.given.values[0]);
    let Some(other) = x.stream(&other.value) else {
        let message = format!(
            "the other iterator has no length known when the program runs: this is {}",
            other.value.kind()
        );
        return x.refuse(&other.at, message);
    };
    let (first, second) = (Rc::clone(&stream.item), Rc::clone(&other.item));
    let scene = &mut x.scene;
    let offset = scene.binary(IntNode::Sub, other.from, stream.from);
    let end = scene.binary(IntNode::Sub, other.to, offset);
    let to = scene.binary(IntNode::Min, stream.to, end);
    let item = move |x: &mut Lowering<'_>, index| {
        let there = x.scene.binary(IntNode::Add, index, offset);
        Some(Value::Tuple(vec![first(x, index)?, second(x, there)?]))
    };
    let stream = stream.with(item);
    Some(Value::Stream(Stream { to, ..stream }))
}

pub(in crate::interpret) fn rev(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let stream = x.receiver(call)?;
    let sum = x.scene.binary(IntNode::Add, stream.from, stream.to);
    let sum = x.scene.shifted(sum, -1);
    let inner = Rc::clone(&stream.item);
    let item = move |x: &mut Lowering<'_>, index| {
        let index = x.scene.binary(IntNode::Sub, sum, index);
        inner(x, index)
    };
    Some(Value::Stream(stream.with(item)))
}

/// Evaluates `skip` and `take`.
pub(in crate::interpret) fn part(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (stream, count) = (x.receiver(call)?, &call.given.values[0]);
    let count = x.integer_at(&count.value, &count.at)?;
    let at = x.scene.binary(IntNode::Add, stream.from, count);
    let stream = if call.syntax.method == "skip" {
        Stream { from: at, ..stream }
    } else {
        let to = x.scene.binary(IntNode::Min, stream.to, at);
        Stream { to, ..stream }
    };
    Some(Value::Stream(stream))
}

pub(in crate::interpret) fn windows(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (stream, n) = (x.receiver(call)?, call.given.counts[0]);
    let at = &call.syntax.args[0];
    if n == 0 {
        return x.refuse(at, "pieces of length 0 do not end: write 1 or more");
    }
    x.work(n, at)?;
    let to = x.scene.shifted(stream.to, 1 - n as i64);
    let inner = Rc::clone(&stream.item);
    let item = move |x: &mut Lowering<'_>, index| {
        let entries = (0..n as i64).map(|k| {
            let index = x.scene.shifted(index, k);
            inner(x, index)
        });
        entries.collect::<Option<_>>().map(Value::Array)
    };
    let stream = stream.with(item);
    Some(Value::Stream(Stream { to, ..stream }))
}

pub(in crate::interpret) fn sum(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let stream = x.receiver(call)?;
    let at = call.syntax.method.span();
    let body = Body::none("i");
    match x.rounds(&stream, at, &body, |_, value| Some(value))? {
        Value::Unit => Some(x.constant(0.0)),
        total => Some(total),
    }
}

impl Lowering<'_> {
    /// Returns whether the closure of a `filter` keeps a value.
    pub(super) fn is_kept(&mut self, closure: &Syntax, value: Value) -> Option<Truth> {
        let Syntax::Closure(closure) = closure else {
            return None;
        };
        let decision = self.scoped(|x| {
            if let Some(pattern) = closure.inputs.first() {
                x.bind(pattern, value);
            }
            x.decide(&closure.body)
        });
        match decision {
            Ok(truth) => Some(truth),
            Err(Undecided::Reported) => None,
            Err(Undecided::Unknown) => self.refuse(
                &closure.body,
                "what `filter` keeps is a condition on indices or a cut-off, as in `j != i`",
            ),
        }
    }
}
