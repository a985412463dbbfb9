//! Reading and assigning variables and their entries: `x`, `x[1].0`, `self.body.mass`.
//!
//! An entry is read from the variable itself. A copy of the array for each of its entries would
//! take quadratic time.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, Member};

use super::Lowering;
use super::fields::FieldPath;
use super::matrices::MatrixType;
use super::value::Value;
use crate::model::scene::Int;

/// The selection of an entry or a member of a value.
pub(super) enum Pick<'e> {
    Index(usize, Span),
    /// Row and column.
    Pair(usize, usize, Span),
    /// An index known when the program runs.
    At(Int, Span),
    /// Row and column, of which one is known when the program runs only.
    AtPair(Int, Int, Span),
    Member(&'e Member),
}

/// An error that is not reported yet: its place and its message.
pub(super) type Mistake = (Span, String);

impl Lowering<'_> {
    /// Returns the value of a search, or reports the error of the search.
    pub(super) fn found<T>(&mut self, found: Result<T, Mistake>) -> Option<T> {
        match found {
            Ok(value) => Some(value),
            Err((span, message)) => self.refuse(&span, message),
        }
    }

    /// Evaluates `base[index]` or `base.member`.
    pub(super) fn entry(&mut self, expr: &Syntax) -> Option<Value> {
        let (base, picks) = self.picks(expr)?;
        let name = variable_name(base);
        let variable = name.and_then(|name| self.frame.variable(&name));
        let found = match variable {
            Some(variable) => self.read(variable, &picks),
            None => {
                let value = self.value(base);
                self.read(&value, &picks)
            }
        };
        let mut value = self.found(found)?;
        let mut rest = picks.as_slice();
        while let (Value::Stream(stream), Some(at)) = (&value.0, value.1) {
            let (index, span) = match &rest[at] {
                Pick::Index(index, span) => (Value::count(*index), *span),
                Pick::At(index, span) => (Value::Index(*index), *span),
                pick => {
                    let mistake = no_member(&value.0, pick);
                    return self.found(Err(mistake));
                }
            };
            let entry = self.stream_entry(stream, &index, &span)?;
            rest = &rest[at + 1..];
            let found = self.read(&entry, rest);
            value = self.found(found)?;
        }
        let value = value.0;
        self.work(value.entries(), expr)?;
        Some(value)
    }

    /// Assigns to a variable, an entry or a component.
    pub(super) fn store(&mut self, place: &Syntax, value: Value) {
        let value = self.shallow(value, place);
        match place {
            Syntax::Infer(_) => {}
            Syntax::Tuple(tuple) => self.store_list(place, &tuple.elems, value),
            Syntax::Array(array) => self.store_list(place, &array.elems, value),
            _ => self.store_at(place, value),
        }
    }

    /// Assigns to several places, `(a, b) = …` or `[a, b] = …`.
    fn store_list(
        &mut self,
        whole: &Syntax,
        places: &syn::punctuated::Punctuated<Syntax, syn::Token![,]>,
        value: Value,
    ) {
        let values = match (value, whole) {
            (Value::Tuple(values), Syntax::Tuple(_)) | (Value::Array(values), Syntax::Array(_))
                if values.len() == places.len() =>
            {
                values
            }
            (Value::Poison, _) => vec![Value::Poison; places.len()],
            (other, _) => {
                let (kind, count) = (other.kind(), places.len());
                let message = format!("{kind} cannot be assigned to these {count} places");
                self.errors.push(whole.span(), message);
                return;
            }
        };
        for (place, value) in places.iter().zip(values) {
            self.store(place, value);
        }
    }

    /// Evaluates `x[A..B]`.
    pub(super) fn slice(&mut self, base: &Syntax, range: &syn::ExprRange) -> Option<Value> {
        match self.eval(base)? {
            Value::Stream(stream) => self.stream_slice(&stream, range),
            value @ Value::Field(_) if self.scene.is_scene() => {
                let stream = self.stream(&value)?;
                self.stream_slice(&stream, range)
            }
            Value::Array(values) => {
                let (from, to) = self.range_within(range, values.len())?;
                Some(Value::Array(values[from..to].to_vec()))
            }
            Value::Field(path) => {
                let (from, to) = self.range_bounds(range)?;
                let Some(to) = to else {
                    return self.refuse(
                        range,
                        "the length of this field is not known to the macro: write both bounds",
                    );
                };
                self.work(to, range)?;
                let entries = (from..to).map(|i| Value::Field(path.index(i)));
                Some(Value::Array(entries.collect()))
            }
            other => self.refuse(base, format!("{} cannot be indexed", other.kind())),
        }
    }

    /// Returns the bounds of a range of entries. The second bound is exclusive; it is `None` if the
    /// source has no second bound.
    fn range_bounds(&mut self, range: &syn::ExprRange) -> Option<(usize, Option<usize>)> {
        let mut bound = |expr: &Option<Box<Syntax>>| match expr {
            Some(expr) => self.index_value(expr).map(Some),
            None => Some(None),
        };
        let (from, to) = bound(&range.start).zip(bound(&range.end))?;
        let to = match range.limits {
            syn::RangeLimits::Closed(_) => to.map(|to| to.saturating_add(1)),
            syn::RangeLimits::HalfOpen(_) => to,
        };
        Some((from.unwrap_or(0), to))
    }

    /// Returns the bounds of a range within `n` entries, or reports an error.
    pub(super) fn range_within(
        &mut self,
        range: &syn::ExprRange,
        n: usize,
    ) -> Option<(usize, usize)> {
        let (from, to) = self.range_bounds(range)?;
        let to = to.unwrap_or(n);
        if from <= to && to <= n {
            return Some((from, to));
        }
        let message = format!("this range is not within the array, which has {n} entries");
        self.refuse(range, message)
    }

    /// Splits an expression into its base and the selections from the base, innermost first.
    pub(super) fn picks<'e>(&mut self, expr: &'e Syntax) -> Option<(&'e Syntax, Vec<Pick<'e>>)> {
        let mut picks = Vec::new();
        let mut base = expr;
        loop {
            base = match base {
                Syntax::Index(index) if !matches!(*index.index, Syntax::Range(_)) => {
                    picks.push(self.index_pick(&index.index)?);
                    &index.expr
                }
                Syntax::Field(field) => {
                    picks.push(Pick::Member(&field.member));
                    &field.base
                }
                Syntax::Paren(inner) => &inner.expr,
                Syntax::Group(inner) => &inner.expr,
                Syntax::Unary(unary) if matches!(unary.op, syn::UnOp::Deref(_)) => &unary.expr,
                Syntax::Reference(reference) if reference.mutability.is_none() => &reference.expr,
                _ => break,
            };
        }
        picks.reverse();
        Some((base, picks))
    }

    /// Evaluates an index, or the row and column of a matrix.
    fn index_pick<'e>(&mut self, index: &'e Syntax) -> Option<Pick<'e>> {
        if let Syntax::Tuple(pair) = index
            && pair.elems.len() == 2
        {
            let (row, column) = (self.value(&pair.elems[0]), self.value(&pair.elems[1]));
            if let Some((row, column)) = self.running_indices(&row, &column) {
                return Some(Pick::AtPair(row, column, index.span()));
            }
            let row = self.index_of(&row, &pair.elems[0]);
            let column = self.index_of(&column, &pair.elems[1]);
            return Some(Pick::Pair(row?, column?, index.span()));
        }
        let value = self.eval(index)?;
        match self.running(&value) {
            Some(at) if !matches!(value, Value::Int(_)) => Some(Pick::At(at, index.span())),
            None if self.scene.is_scene() => self.integer_at(&value, index).and(None),
            _ => {
                let at = self.index_of(&value, index)?;
                Some(Pick::Index(at, index.span()))
            }
        }
    }

    /// Returns two indices as integers known when the program runs; `None` if both are known at
    /// compile time.
    fn running_indices(&mut self, row: &Value, column: &Value) -> Option<(Int, Int)> {
        if let (Value::Int(_), Value::Int(_)) = (row, column) {
            return None;
        }
        self.running(row).zip(self.running(column))
    }

    /// Evaluates an index or a length, or reports an error.
    pub(super) fn index_value(&mut self, expr: &Syntax) -> Option<usize> {
        let value = self.eval(expr)?;
        self.index_of(&value, expr)
    }

    /// Converts a value to an index, or reports an error at `expr`.
    pub(super) fn index_of(&mut self, value: &Value, expr: &impl Spanned) -> Option<usize> {
        let message = match value {
            Value::Int(i) if i.value >= 0 => return usize::try_from(i.value).ok(),
            Value::Poison => return None,
            Value::Int(i) => format!(
                "index {} is negative: begin the loop later, or write `(i + N - 1) % N` on a ring",
                i.value
            ),
            other => other.unseen().unwrap_or_else(|| format!(
                "an index must be known at compile time (a literal, a loop variable, a constant of this block), and this is {}",
                other.kind()
            )),
        };
        self.refuse(expr, message)
    }
}

pub(super) fn variable_name(expr: &Syntax) -> Option<String> {
    match expr {
        Syntax::Path(path) => path.path.get_ident().map(ToString::to_string),
        _ => None,
    }
}

impl Lowering<'_> {
    /// Selects an entry of a value. If an entry is a sequence whose length is known when the
    /// program runs, returns it with the number of the pick that selects from it.
    fn read(&self, value: &Value, picks: &[Pick<'_>]) -> Result<(Value, Option<usize>), Mistake> {
        let mut value = value;
        for (at, pick) in picks.iter().enumerate() {
            value = match (self.frame.followed(value), pick) {
                (Value::Poison, _) => return Ok((Value::Poison, None)),
                (Value::Field(path), _) => {
                    let path = self.field(path, &picks[at..])?;
                    return Ok((Value::Field(path), None));
                }
                (stream @ Value::Stream(_), _) => return Ok((stream.clone(), Some(at))),
                (
                    Value::Array(_) | Value::Matrix(_),
                    Pick::At(_, span) | Pick::AtPair(_, _, span),
                ) => {
                    return Err(fixed_size(*span));
                }
                (Value::Array(values), Pick::Index(i, span)) => values
                    .get(*i)
                    .ok_or_else(|| out_of_range(*i, *span, values.len()))?,
                (Value::Matrix(matrix), pick) => &matrix.entries[matrix_entry(matrix.ty, pick)?],
                (Value::Tuple(values), Pick::Member(Member::Unnamed(index))) => {
                    let entry = values.get(index.index as usize);
                    entry.ok_or_else(|| no_member(value, pick))?
                }
                (other, _) => return Err(no_member(other, pick)),
            };
        }
        Ok((value.clone(), None))
    }

    fn field(&self, path: &FieldPath, picks: &[Pick<'_>]) -> Result<FieldPath, Mistake> {
        let text = |index: &Int| self.scene.integers.text(*index);
        picks.iter().try_fold(path.clone(), |path, pick| {
            Ok(match pick {
                Pick::At(_, span) | Pick::AtPair(_, _, span) if path.is_outside() => {
                    let message = "an index known when the program runs selects from a field of the struct only: make this constant a field";
                    return Err((*span, message.to_owned()));
                }
                Pick::Index(at, span) => path.index_at(*at, *span),
                Pick::Pair(row, column, span) => path.pair_at(*row, *column, *span),
                Pick::At(at, _) => path.at(*at, &text(at)),
                Pick::AtPair(row, column, _) => {
                    let both = format!("({}, {})", text(row), text(column));
                    path.at_pair(*row, *column, &both)
                }
                Pick::Member(member) => path.member(member),
            })
        })
    }
}

/// Returns the error of an index known when the program runs into an array of fixed size.
pub(super) fn fixed_size(span: Span) -> Mistake {
    let message = "this index is known only when the program runs, and the array has a fixed size: make it a field, or a condition on the index";
    (span, message.to_owned())
}

pub(super) fn out_of_range(at: usize, span: Span, entries: usize) -> Mistake {
    let last = match entries.checked_sub(1) {
        Some(last) => format!("the last is [{last}]"),
        None => "it is empty".to_owned(),
    };
    let plural = if entries == 1 { "entry" } else { "entries" };
    (
        span,
        format!("index {at} is out of range: the array has {entries} {plural}, {last}"),
    )
}

/// Returns the index of an entry of a vector or matrix in its storage.
pub(super) fn matrix_entry(ty: MatrixType, pick: &Pick<'_>) -> Result<usize, Mistake> {
    let (found, span, index) = match pick {
        Pick::Index(at, span) => ((*at < ty.len()).then_some(*at), *span, at.to_string()),
        Pick::Pair(row, column, span) => {
            (ty.place(*row, *column), *span, format!("({row}, {column})"))
        }
        Pick::At(_, span) | Pick::AtPair(_, _, span) => return Err(fixed_size(*span)),
        Pick::Member(member) => {
            let message = format!(
                "a `{ty}` has no such entry: its entries are {}",
                ty.entry_names()
            );
            return ty.place_of(member).ok_or((member.span(), message));
        }
    };
    let message = format!(
        "index {index} is out of range: a `{ty}` has the entries {}",
        ty.entry_names()
    );
    found.ok_or((span, message))
}

pub(super) fn no_member(value: &Value, pick: &Pick<'_>) -> Mistake {
    let kind = value.kind();
    match pick {
        Pick::Index(_, span)
        | Pick::Pair(_, _, span)
        | Pick::At(_, span)
        | Pick::AtPair(_, _, span) => (*span, format!("{kind} cannot be indexed")),
        Pick::Member(member) => {
            let entries = match value {
                Value::Tuple(values) if !values.is_empty() => {
                    format!(": its entries are `.0` to `.{}`", values.len() - 1)
                }
                Value::Array(_) => ": its entries are `[0]`, `[1]`, …".to_owned(),
                _ => String::new(),
            };
            (member.span(), format!("{kind} has no such entry{entries}"))
        }
    }
}
