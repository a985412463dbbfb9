//! Inference of the type `usize` for integers that are used as indices.

use syn::visit::Visit;
use syn::{Block, Expr as Syntax, Pat};

use super::Lowering;
use super::integers::{Integer, USIZE};
use super::value::Value;

impl Lowering<'_> {
    /// Gives the items of a loop the type `usize` if they have no type and the loop variable is an
    /// index in the body.
    pub(super) fn as_indices(items: Vec<Value>, name: &Pat, body: &Block) -> Vec<Value> {
        if items.iter().any(is_untyped) && is_index(name, |indices| indices.visit_block(body)) {
            items.into_iter().map(with_usize).collect()
        } else {
            items
        }
    }

    /// Gives the argument of a closure the type `usize` if it has no type and the parameter is an
    /// index in the body.
    pub(super) fn as_index(value: Value, name: &Pat, body: &Syntax) -> Value {
        if is_untyped(&value) && is_index(name, |indices| indices.visit_expr(body)) {
            with_usize(value)
        } else {
            value
        }
    }
}

fn is_untyped(value: &Value) -> bool {
    matches!(value, Value::Int(Integer { kind: None, .. }))
}

fn with_usize(value: Value) -> Value {
    match value {
        Value::Int(i) => Value::Int(i.or_of(USIZE)),
        other => other,
    }
}

/// A visitor that finds out whether a variable occurs in an index.
struct Indices<'a> {
    name: &'a syn::Ident,
    found: bool,
}

impl<'ast> Visit<'ast> for Indices<'_> {
    fn visit_expr_index(&mut self, index: &'ast syn::ExprIndex) {
        self.found |= occurs(self.name, &index.index);
        syn::visit::visit_expr_index(self, index);
    }
}

/// Returns whether a variable occurs in an index outside of casts, calls and closures, so that its
/// type is `usize`.
fn is_index<'p>(name: &'p Pat, search: impl FnOnce(&mut Indices<'p>)) -> bool {
    let Pat::Ident(name) = name else { return false };
    let mut indices = Indices {
        name: &name.ident,
        found: false,
    };
    search(&mut indices);
    indices.found
}

/// Returns whether a variable is the expression itself, or an operand of its arithmetic.
fn occurs(name: &syn::Ident, syntax: &Syntax) -> bool {
    match syntax {
        Syntax::Path(path) => path.path.is_ident(name),
        Syntax::Paren(inner) => occurs(name, &inner.expr),
        Syntax::Group(inner) => occurs(name, &inner.expr),
        Syntax::Binary(binary) => occurs(name, &binary.left) || occurs(name, &binary.right),
        Syntax::Range(range) => [&range.start, &range.end]
            .into_iter()
            .flatten()
            .any(|bound| occurs(name, bound)),
        _ => false,
    }
}
