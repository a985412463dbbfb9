//! Mutable references into local arrays, made by `iter_mut` and `for x in &mut a`.
//!
//! A reference names a place. Reading a reference reads the place, and an assignment through the reference changes the place. A
//! reference is valid only in the function that made it. Functions and closures that are called get copies, and must not change them.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, Type, UnOp};

use super::Lowering;
use super::places::{Mistake, Pick, matrix_entry, no_member, out_of_range, variable_name};
use super::value::Value;

/// Largest number of references to references that are followed.
const CHAIN: usize = 8;

/// A variable, or an entry of one.
#[derive(Clone)]
pub(super) struct Place {
    /// The frame of the function or closure that has the variable.
    frame: usize,
    scope: usize,
    name: String,
    path: Vec<usize>,
}

impl Place {
    fn then(&self, entry: usize) -> Self {
        let mut inner = self.clone();
        inner.path.push(entry);
        inner
    }
}

/// The target of an assignment.
struct Target {
    place: Place,
    /// Whether the place was reached through a reference.
    is_referenced: bool,
}

impl Lowering<'_> {
    /// Returns the value at a place; `None` if the place belongs to another frame.
    pub(super) fn at(&self, place: &Place) -> Option<&Value> {
        if place.frame != self.frame {
            return None;
        }
        let variable = self.scopes.get(place.scope)?.get(&place.name)?;
        place
            .path
            .iter()
            .try_fold(variable, |value, &entry| match value {
                Value::Array(values) | Value::Tuple(values) => values.get(entry),
                Value::Matrix(matrix) => matrix.entries.get(entry),
                _ => None,
            })
    }

    fn at_mut(&mut self, place: &Place) -> Option<&mut Value> {
        let variable = self.scopes.get_mut(place.scope)?.get_mut(&place.name)?;
        place
            .path
            .iter()
            .try_fold(variable, |value, &entry| match value {
                Value::Array(values) | Value::Tuple(values) => values.get_mut(entry),
                Value::Matrix(matrix) => matrix.entries.get_mut(entry),
                _ => None,
            })
    }

    /// Returns the value to which a reference refers; a value that is no reference is returned itself.
    pub(super) fn followed<'v>(&'v self, value: &'v Value) -> &'v Value {
        let mut value = value;
        for _ in 0..CHAIN {
            match value {
                Value::Place(place) => match self.at(place) {
                    Some(inner) => value = inner,
                    None => return &Value::Poison,
                },
                _ => break,
            }
        }
        value
    }

    /// Follows a reference, as [`followed`](Self::followed) does, for an owned value.
    pub(super) fn read_through(&self, value: Value) -> Value {
        match &value {
            Value::Place(_) => self.followed(&value).clone(),
            _ => value,
        }
    }

    /// Splits a reference to an array or tuple into references to its entries.
    pub(super) fn split_reference(&self, place: &Place) -> Option<Vec<Value>> {
        match self.followed(&Value::Place(place.clone())) {
            Value::Array(values) | Value::Tuple(values) => Some(
                (0..values.len())
                    .map(|entry| Value::Place(place.then(entry)))
                    .collect(),
            ),
            _ => None,
        }
    }

    /// Evaluates `array.iter_mut()` and `&mut array`. Returns references to the entries of a local array or slice.
    pub(super) fn iterate_mutably(&mut self, array: &Syntax, at: Span) -> Value {
        let (array, range) = match array {
            Syntax::Index(index) => match &*index.index {
                Syntax::Range(range) => (&*index.expr, Some(range)),
                _ => (array, None),
            },
            _ => (array, None),
        };
        let Some(target) = self.target(array, false) else {
            return Value::Poison;
        };
        let n = match self.followed(&Value::Place(target.place.clone())) {
            Value::Array(values) => values.len(),
            Value::Matrix(matrix) => matrix.entries.len(),
            Value::Poison => return Value::Poison,
            other => {
                let message = format!(
                    "only a local array is changed entry by entry, and this is {}",
                    other.kind()
                );
                return self.refuse(&at, message);
            }
        };
        let Some((from, to)) = range.map_or(Some((0, n)), |range| self.range_within(range, n))
        else {
            return Value::Poison;
        };
        if !self.work(n, &at) {
            return Value::Poison;
        }
        let entries = (from..to).map(|entry| Value::Place(target.place.then(entry)));
        Value::Sequence(entries.collect())
    }

    /// Assigns to a variable, an entry or a component, or to what a reference refers to.
    pub(super) fn store_at(&mut self, place: &Syntax, value: Value) {
        let Some(target) = self.target(place, true) else {
            return;
        };
        if self.is_lazy && target.is_referenced {
            self.refuse(
                place,
                "a closure of `map` that changes entries runs only where its results are taken: write a `for` loop",
            );
            return;
        }
        match self.at_mut(&target.place) {
            Some(slot) => *slot = value,
            None => {
                self.refuse(place, "what this reference refers to has another variable of its name before it: rename one");
            }
        }
    }

    /// Returns the place that an expression names; `None` if its variable is poisoned, or after an error.
    fn target(&mut self, expr: &Syntax, is_assigned: bool) -> Option<Target> {
        let (base, picks) = self.picks(expr)?;
        let Some(name) = variable_name(base).filter(|name| name != "self") else {
            self.refuse(
                base,
                "only a local variable, or an entry of one, can be assigned to",
            );
            return None;
        };
        let Some(scope) = self.scopes.iter().rposition(|s| s.contains_key(&name)) else {
            self.refuse(base, "this variable is not known here");
            return None;
        };
        let root = Place {
            frame: self.frame,
            scope,
            name,
            path: Vec::new(),
        };
        if let Some(Value::Poison) = self.at(&root) {
            return None;
        }
        let is_dereferenced = is_dereferenced(expr);
        let target = match self.walk(root, &picks, is_dereferenced || !is_assigned) {
            Ok(target) => target?,
            Err((span, message)) => {
                self.errors.push(span, message);
                return None;
            }
        };
        if is_assigned && matches!(self.at(&target.place), Some(Value::Place(_))) {
            self.refuse(
                expr,
                "this would let the reference refer to something else: assign to what it refers to, `*x = …`",
            );
            return None;
        }
        if is_dereferenced && !target.is_referenced {
            self.refuse(
                expr,
                "what changes through this reference is not followed: a helper or closure returns what it computes",
            );
            return None;
        }
        if scope < self.floor && !target.is_referenced {
            self.refuse(
                base,
                "a closure that changes a variable around it is not understood: write a `for` loop",
            );
            return None;
        }
        Some(target)
    }

    /// Goes from a variable to one of its entries and follows references on the path. A reference at the end of the path is followed
    /// if `follows_last`.
    fn walk(
        &self,
        root: Place,
        picks: &[Pick<'_>],
        follows_last: bool,
    ) -> Result<Option<Target>, Mistake> {
        let mut target = Target {
            place: root,
            is_referenced: false,
        };
        for pick in picks {
            self.follow(&mut target);
            let value = self.at(&target.place).unwrap_or(&Value::Poison);
            let entry = match (value, pick) {
                (Value::Poison, _) => return Ok(None),
                (Value::Array(values), Pick::Index(i, _)) if *i < values.len() => *i,
                (Value::Array(values), Pick::Index(i, span)) => {
                    return Err(out_of_range(*i, *span, values.len()));
                }
                (Value::Matrix(matrix), pick) => matrix_entry(matrix.ty, pick)?,
                (Value::Tuple(values), Pick::Member(syn::Member::Unnamed(index)))
                    if (index.index as usize) < values.len() =>
                {
                    index.index as usize
                }
                _ => return Err(no_member(value, pick)),
            };
            target.place.path.push(entry);
        }
        if follows_last {
            self.follow(&mut target);
        }
        Ok(Some(target))
    }

    fn follow(&self, target: &mut Target) {
        for _ in 0..CHAIN {
            let Some(Value::Place(inner)) = self.at(&target.place) else {
                return;
            };
            *target = Target {
                place: inner.clone(),
                is_referenced: true,
            };
        }
    }
}

/// Returns whether the base of an expression is dereferenced, `*…`.
fn is_dereferenced(expr: &Syntax) -> bool {
    match expr {
        Syntax::Unary(unary) => matches!(unary.op, UnOp::Deref(_)),
        Syntax::Index(index) => is_dereferenced(&index.expr),
        Syntax::Field(field) => is_dereferenced(&field.base),
        Syntax::Paren(inner) => is_dereferenced(&inner.expr),
        Syntax::Group(inner) => is_dereferenced(&inner.expr),
        _ => false,
    }
}

/// Returns where `&mut` is written, if a type begins with it.
pub(super) fn mutable(ty: &Type) -> Option<Span> {
    match ty {
        Type::Reference(reference) => reference.mutability.map(|word| word.span()),
        Type::Paren(inner) => mutable(&inner.elem),
        Type::Group(inner) => mutable(&inner.elem),
        _ => None,
    }
}
