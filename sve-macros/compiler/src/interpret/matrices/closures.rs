//! Methods of vectors and matrices that call a closure for each entry.

use syn::{Expr as Syntax, ExprMethodCall};

use super::{Matrix, MatrixType};
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::value::Value;

impl Lowering<'_> {
    /// Evaluates `map`, `zip_map` and `fold`; `None` for other methods.
    pub(super) fn closure_method(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Matrix<Value>,
    ) -> Option<Value> {
        let arguments: Vec<&Syntax> = call.args.iter().collect();
        let entries = receiver.entries.clone();
        let ty = receiver.ty.plain();
        let items = match (call.method.to_string().as_str(), arguments.as_slice()) {
            ("map", [function]) => self
                .mapped(entries, function)
                .map(|items| (items, function)),
            ("zip_map", [other, function]) => {
                let other = self.argument(other);
                self.zip_mapped(entries, &other, ty, function)
                    .map(|items| (items, function))
            }
            ("fold", [start, function]) => return Some(self.fold(entries, start, function)),
            _ => return None,
        };
        let Some((items, function)) = items else {
            return Some(Value::Poison);
        };
        let matrix = Matrix { ty, entries: items };
        Some(match self.numbers(&matrix, function) {
            Some(numbers) => numbers.into(),
            None => Value::Poison,
        })
    }

    fn zip_mapped(
        &mut self,
        entries: Vec<Value>,
        other: &Argument,
        ty: MatrixType,
        function: &Syntax,
    ) -> Option<Vec<Value>> {
        let other = Value::from(self.matrix_argument(other, ty, "zip_map")?);
        let Value::Matrix(other) = other else {
            return None;
        };
        let mistakes = self.errors.count();
        let mut results = Vec::new();
        for (a, b) in entries.into_iter().zip(other.entries) {
            let at = syn::spanned::Spanned::span(function);
            let arguments = [a, b].map(|value| Argument { value, at });
            results.push(self.apply(function, arguments.into()));
            if self.errors.count() > mistakes || !self.tick(function) {
                // the next entry would repeat the error
                return None;
            }
        }
        Some(results)
    }
}
