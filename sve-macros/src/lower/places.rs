//! Variables and their entries: `x`, `x[1].0`, `self.body.mass`, read and assigned to.
//!
//! Entries are picked from the variable itself: to copy an array for each entry of it would cost its square.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, Member};

use super::Lowering;
use super::value::{FieldPath, Value};

/// One step into a value.
enum Pick<'e> {
    Index(usize, Span),
    Member(&'e Member),
}

/// What is wrong, and where.
type Mistake = (Span, String);

impl Lowering<'_> {
    /// The value of `base[index]` or `base.member`.
    pub(super) fn entry(&mut self, expr: &Syntax) -> Value {
        let Some((base, picks)) = self.picks(expr) else {
            return Value::Poison;
        };
        let value = match variable_name(base) {
            Some(name) if self.variable(&name).is_some() => None,
            _ => Some(self.eval(base)),
        };
        let found = match (&value, variable_name(base)) {
            (Some(value), _) => read(value, &picks),
            (None, Some(name)) => self
                .variable(&name)
                .map_or(Ok(Value::Poison), |variable| read(variable, &picks)),
            (None, None) => Ok(Value::Poison),
        };
        match found {
            Ok(value) if self.work(value.entries(), expr) => value,
            Ok(_) => Value::Poison,
            Err((span, message)) => {
                self.errors.push(span, message);
                Value::Poison
            }
        }
    }

    /// Assigns to a variable, an entry or a component.
    pub(super) fn store(&mut self, place: &Syntax, value: Value) {
        let value = self.shallow(value, place);
        match place {
            Syntax::Infer(_) => return,
            Syntax::Tuple(tuple) => return self.store_list(place, &tuple.elems, value),
            Syntax::Array(array) => return self.store_list(place, &array.elems, value),
            _ => {}
        }
        let Some((base, picks)) = self.picks(place) else {
            return;
        };
        let Some(name) = variable_name(base).filter(|name| name != "self") else {
            self.refuse(
                base,
                "only a local variable, or an entry of one, can be assigned to",
            );
            return;
        };
        let Some(at) = self.scopes.iter().rposition(|s| s.contains_key(&name)) else {
            self.refuse(base, "this variable is not known here");
            return;
        };
        if at < self.floor {
            self.refuse(
                base,
                "a closure that changes a variable around it is not understood: write a `for` loop",
            );
            return;
        }
        let Some(slot) = self.scopes[at].get_mut(&name) else {
            return;
        };
        match slot_of(slot, &picks) {
            Ok(Some(slot)) => *slot = value,
            Ok(None) => {}
            Err((span, message)) => self.errors.push(span, message),
        }
    }

    /// `(a, b) = …` and `[a, b] = …`.
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
                let message = format!(
                    "{} cannot be assigned to these {} places",
                    other.kind(),
                    places.len()
                );
                self.refuse(whole, message);
                return;
            }
        };
        for (place, value) in places.iter().zip(values) {
            self.store(place, value);
        }
    }

    /// `x[A..B]`.
    pub(super) fn slice(&mut self, base: &Syntax, range: &syn::ExprRange) -> Value {
        let value = self.eval(base);
        let mut bound = |expr: &Option<Box<Syntax>>| match expr {
            Some(expr) => self.index_value(expr).map(Some),
            None => Some(None),
        };
        let Some((from, to)) = bound(&range.start).zip(bound(&range.end)) else {
            return Value::Poison;
        };
        let from = from.unwrap_or(0);
        let to = match range.limits {
            syn::RangeLimits::Closed(_) => to.map(|to| to.saturating_add(1)),
            syn::RangeLimits::HalfOpen(_) => to,
        };
        match value {
            Value::Poison => Value::Poison,
            Value::Array(values) => {
                let n = values.len();
                match values.get(from..to.unwrap_or(n)) {
                    Some(part) => Value::Array(part.to_vec()),
                    None => self.refuse(
                        range,
                        format!("this range is not within the array, which has {n} entries"),
                    ),
                }
            }
            Value::Field(path) => match to {
                Some(to) if self.work(to, range) => {
                    Value::Array((from..to).map(|i| Value::Field(path.index(i))).collect())
                }
                Some(_) => Value::Poison,
                None => self.refuse(
                    range,
                    "the length of this field is not known to the macro: write both bounds",
                ),
            },
            other => self.refuse(base, format!("{} cannot be indexed", other.kind())),
        }
    }

    pub(super) fn variable(&self, name: &str) -> Option<&Value> {
        self.scopes.iter().rev().find_map(|scope| scope.get(name))
    }

    /// An expression as its base and the steps into it, innermost first.
    fn picks<'e>(&mut self, expr: &'e Syntax) -> Option<(&'e Syntax, Vec<Pick<'e>>)> {
        let mut picks = Vec::new();
        let mut base = expr;
        loop {
            base = match base {
                Syntax::Index(index) if !matches!(*index.index, Syntax::Range(_)) => {
                    let at = self.index_value(&index.index)?;
                    picks.push(Pick::Index(at, index.index.span()));
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

    pub(super) fn index_value(&mut self, expr: &Syntax) -> Option<usize> {
        match self.eval(expr) {
            Value::Int(i) if i >= 0 => usize::try_from(i).ok(),
            Value::Poison => None,
            Value::Int(i) => {
                self.refuse(expr, format!("index {i} is negative: begin the loop later, or write `(i + N - 1) % N` on a ring"));
                None
            }
            other => {
                let message = format!(
                    "an index must be known at compile time (a literal, a loop variable, a constant of this block), and this is {}",
                    other.kind()
                );
                self.refuse(expr, message);
                None
            }
        }
    }
}

fn variable_name(expr: &Syntax) -> Option<String> {
    match expr {
        Syntax::Path(path) => path.path.get_ident().map(ToString::to_string),
        _ => None,
    }
}

fn read(value: &Value, picks: &[Pick<'_>]) -> Result<Value, Mistake> {
    let mut value = value;
    for (at, pick) in picks.iter().enumerate() {
        value = match (value, pick) {
            (Value::Poison, _) => return Ok(Value::Poison),
            (Value::Field(path), _) => return Ok(Value::Field(field(path, &picks[at..]))),
            (Value::Array(values), Pick::Index(i, span)) => values
                .get(*i)
                .ok_or_else(|| out_of_range(*i, *span, values.len()))?,
            (Value::Tuple(values), Pick::Member(Member::Unnamed(index))) => {
                let entry = values.get(index.index as usize);
                entry.ok_or_else(|| no_member(value, pick))?
            }
            (other, _) => return Err(no_member(other, pick)),
        };
    }
    Ok(value.clone())
}

/// The place that is meant; nothing in what is poisoned.
fn slot_of<'v>(slot: &'v mut Value, picks: &[Pick<'_>]) -> Result<Option<&'v mut Value>, Mistake> {
    let mut slot = slot;
    for pick in picks {
        let mistake = no_member(slot, pick);
        slot = match (slot, pick) {
            (Value::Poison, _) => return Ok(None),
            (Value::Array(values), Pick::Index(i, span)) => {
                let n = values.len();
                values
                    .get_mut(*i)
                    .ok_or_else(|| out_of_range(*i, *span, n))?
            }
            (Value::Tuple(values), Pick::Member(Member::Unnamed(index))) => {
                values.get_mut(index.index as usize).ok_or(mistake)?
            }
            _ => return Err(mistake),
        };
    }
    Ok(Some(slot))
}

fn field(path: &FieldPath, picks: &[Pick<'_>]) -> FieldPath {
    picks.iter().fold(path.clone(), |path, pick| match pick {
        Pick::Index(at, _) => path.index(*at),
        Pick::Member(member) => path.member(member),
    })
}

fn out_of_range(at: usize, span: Span, entries: usize) -> Mistake {
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

fn no_member(value: &Value, pick: &Pick<'_>) -> Mistake {
    let kind = value.kind();
    match pick {
        Pick::Index(_, span) => (*span, format!("{kind} cannot be indexed")),
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
