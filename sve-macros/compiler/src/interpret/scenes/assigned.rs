//! The variables that statements assign.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::Visit;
use syn::{BinOp, Expr as Syntax};

use crate::interpret::places::variable_name;

/// Returns the variables that statements assign, each with the place of its first assignment.
pub(super) fn assigned(visit: impl FnOnce(&mut Assigned)) -> Vec<(String, Span)> {
    let mut names = Assigned(Vec::new());
    visit(&mut names);
    names.0
}

/// The names, as they are found.
pub(super) struct Assigned(Vec<(String, Span)>);

impl Assigned {
    fn add(&mut self, place: &Syntax) {
        match place {
            Syntax::Tuple(tuple) => tuple.elems.iter().for_each(|place| self.add(place)),
            Syntax::Array(array) => array.elems.iter().for_each(|place| self.add(place)),
            Syntax::Index(index) => self.add(&index.expr),
            Syntax::Field(field) => self.add(&field.base),
            Syntax::Unary(unary) => self.add(&unary.expr),
            Syntax::Paren(inner) => self.add(&inner.expr),
            Syntax::Group(inner) => self.add(&inner.expr),
            _ => {
                if let Some(name) = variable_name(place)
                    && self.0.iter().all(|(other, _)| *other != name)
                {
                    self.0.push((name, place.span()));
                }
            }
        }
    }
}

impl<'ast> Visit<'ast> for Assigned {
    fn visit_expr_assign(&mut self, assign: &'ast syn::ExprAssign) {
        self.add(&assign.left);
        syn::visit::visit_expr_assign(self, assign);
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        if let BinOp::AddAssign(_)
        | BinOp::SubAssign(_)
        | BinOp::MulAssign(_)
        | BinOp::DivAssign(_) = binary.op
        {
            self.add(&binary.left);
        }
        syn::visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_reference(&mut self, reference: &'ast syn::ExprReference) {
        if reference.mutability.is_some() {
            self.add(&reference.expr);
        }
        syn::visit::visit_expr_reference(self, reference);
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if call.method == "iter_mut" {
            self.add(&call.receiver);
        }
        syn::visit::visit_expr_method_call(self, call);
    }
}
