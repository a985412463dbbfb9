//! Assignments, and mutable references into local arrays, made by `iter_mut` and `for x in &mut a`.
//!
//! An assignment through a reference changes the place of the reference. Functions and closures
//! that are called get copies, and must not change them.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, Type, UnOp};

use super::Lowering;
use super::frames::Place;
use super::places::{
    Mistake, Pick, fixed_size, matrix_entry, no_member, out_of_range, variable_name,
};
use super::value::Value;
use crate::syntax::bare;

/// The target of an assignment.
struct Target {
    place: Place,
    /// True if the place was reached through a reference.
    is_referenced: bool,
}

impl Lowering<'_> {
    /// Evaluates `array.iter_mut()` and `&mut array`. Returns references to the entries of a local
    /// array or slice.
    pub(super) fn iterate_mutably(&mut self, array: &Syntax, at: Span) -> Option<Value> {
        let (array, range) = match array {
            Syntax::Index(index) => match &*index.index {
                Syntax::Range(range) => (&*index.expr, Some(range)),
                _ => (array, None),
            },
            _ => (array, None),
        };
        let target = self.target(array, false)?;
        let n = match self.frame.followed(&Value::Place(target.place.clone())) {
            Value::Array(values) => values.len(),
            Value::Matrix(matrix) => matrix.entries.len(),
            Value::Poison => return None,
            other => {
                let message = format!(
                    "only a local array is changed entry by entry, and this is {}",
                    other.kind()
                );
                return self.refuse(&at, message);
            }
        };
        let (from, to) = match range {
            Some(range) => self.range_within(range, n)?,
            None => (0, n),
        };
        self.work(n, &at)?;
        let entries = (from..to).map(|entry| Value::Place(target.place.then(entry)));
        Some(Value::Sequence(entries.collect()))
    }

    /// Assigns to a variable, an entry or a component. An assignment to a reference changes the
    /// place to which it refers.
    pub(super) fn store_at(&mut self, place: &Syntax, value: Value) {
        let Some(target) = self.target(place, true) else {
            return;
        };
        let message = if self.frame.is_lazy && target.is_referenced {
            "a closure of `map` that changes entries runs only where its results are taken: write a `for` loop"
        } else if let Some(slot) = self.frame.at_mut(&target.place) {
            *slot = value;
            return;
        } else {
            "what this reference refers to has another variable of its name before it: rename one"
        };
        self.errors.push(place.span(), message);
    }

    /// Returns the place that an expression names; `None` if its variable is poisoned, or after an
    /// error.
    fn target(&mut self, expr: &Syntax, is_assigned: bool) -> Option<Target> {
        let (base, picks) = self.picks(expr)?;
        let Some(name) = variable_name(base).filter(|name| name != "self") else {
            let message = "only a local variable, or an entry of one, can be assigned to";
            return self.refuse(base, message);
        };
        let Some(root) = self.frame.place(&name) else {
            return self.refuse(base, "this variable is not known here");
        };
        if let Some(Value::Poison) = self.frame.at(&root) {
            return None;
        }
        let is_captured = root.scope < self.frame.floor;
        let is_dereferenced = is_dereferenced(expr);
        let target = self.walk(root, &picks, is_dereferenced || !is_assigned);
        let target = self.found(target)??;
        if is_assigned && matches!(self.frame.at(&target.place), Some(Value::Place(_))) {
            return self.refuse(
                expr,
                "this would let the reference refer to something else: assign to what it refers to, `*x = …`",
            );
        }
        if is_dereferenced && !target.is_referenced {
            return self.refuse(
                expr,
                "what changes through this reference is not followed: a helper or closure returns what it computes",
            );
        }
        if is_captured && !target.is_referenced {
            return self.refuse(
                base,
                "a closure that changes a variable around it is not understood: write a `for` loop",
            );
        }
        Some(target)
    }

    /// Goes from a variable to one of its entries and follows references on the path. A reference
    /// at the end of the path is followed if `follows_last`.
    fn walk(
        &self,
        place: Place,
        picks: &[Pick<'_>],
        follows_last: bool,
    ) -> Result<Option<Target>, Mistake> {
        let mut target = Target {
            place,
            is_referenced: false,
        };
        for pick in picks {
            self.follow(&mut target);
            let value = self.frame.at(&target.place).unwrap_or(&Value::Poison);
            let entry = match (value, pick) {
                (Value::Poison, _) => return Ok(None),
                (Value::Array(values), Pick::Index(i, _)) if *i < values.len() => *i,
                (Value::Array(values), Pick::Index(i, span)) => {
                    return Err(out_of_range(*i, *span, values.len()));
                }
                (Value::Array(_), Pick::At(_, span)) => return Err(fixed_size(*span)),
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
        if let Some(place) = self.frame.referenced(&target.place) {
            *target = Target {
                place,
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

/// Returns the position of `&mut` if a type begins with it.
pub(super) fn mutable(ty: &Type) -> Option<Span> {
    match bare(ty) {
        Type::Reference(reference) => reference.mutability.map(|word| word.span()),
        _ => None,
    }
}
