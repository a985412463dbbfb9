//! Values whose type is inferred from a type annotation: results of `into`, and arrays made by
//! `array::from_fn`.

use std::rc::Rc;

use proc_macro2::Span;
use quote::quote;
use syn::spanned::Spanned;
use syn::{PathArguments, Type};

use super::Lowering;
use super::calls::Argument;
use super::closures::Closure;
use super::integers::Integer;
use super::value::Value;
use crate::syntax::bare;
use crate::syntax::nalgebra::length;
use crate::syntax::parse::is_f64;

/// The message for an array of `from_fn` whose length is not known.
pub(super) const NO_LENGTH: &str = "the length of this array is not written here: give its type, `let a: [f64; N] = …`, or write `std::array::from_fn::<_, N, _>(…)`";

impl Value {
    /// Returns whether the type of the value, or of an entry, follows from a type annotation.
    fn waits_for_type(&self) -> bool {
        match self {
            Self::Converted(_) | Self::Generated(_) => true,
            Self::Array(values) | Self::Tuple(values) => values.iter().any(Self::waits_for_type),
            _ => false,
        }
    }

    /// Returns the value to which `into` was applied.
    pub(super) fn unconverted(self) -> Self {
        match self {
            Self::Converted(inner) => inner.unconverted(),
            value => value,
        }
    }
}

impl Lowering<'_> {
    /// Evaluates `x.into()`. Integers and tuples may become numbers and arrays; other values stay
    /// as they are.
    pub(super) fn converted(&self, receiver: Value) -> Value {
        match receiver {
            Value::Int(_) | Value::Index(_) | Value::Tuple(_) => {
                Value::Converted(Box::new(receiver))
            }
            Value::Field(path) => {
                let runtime = &self.block.arguments.runtime;
                Value::Field(path.converted(quote!(#runtime::__private::entry)))
            }
            other => other,
        }
    }

    /// Evaluates `array::from_fn(…)`. Without a length among the generic arguments, the array waits
    /// for a type annotation.
    pub(super) fn array_from_fn(
        &mut self,
        path: &syn::ExprPath,
        arguments: &[Argument],
    ) -> Option<Value> {
        let closure = match arguments {
            [argument] => match &argument.value {
                Value::Closure(closure) => Some(closure),
                Value::Poison => return None,
                _ => None,
            },
            _ => None,
        };
        let Some(closure) = closure else {
            return self.refuse(
                path,
                "`from_fn` takes a closure, as in `std::array::from_fn(|i| 2.0 * q[i])`",
            );
        };
        let generics = match path.path.segments.last().map(|segment| &segment.arguments) {
            Some(PathArguments::AngleBracketed(generics)) => generics.args.iter().nth(1),
            _ => None,
        };
        match generics.and_then(length) {
            Some(length) => {
                let n = self.index_value(&length)?;
                self.generated(closure, n, None, &length)
            }
            None => Some(Value::Generated(Rc::clone(closure))),
        }
    }

    /// Returns the array of the `n` values of a closure.
    fn generated(
        &mut self,
        closure: &Closure,
        n: usize,
        entry: Option<&Type>,
        at: &impl Spanned,
    ) -> Option<Value> {
        let indices = (0..n).map(|i| vec![Value::count(i)]);
        let values = self.called(closure, indices, at.span())?;
        let Some(ty) = entry else {
            return Some(Value::Array(values));
        };
        let mistakes = self.errors.count();
        let mut entries = Vec::new();
        for value in values {
            entries.push(self.awaited(value, ty, at));
            if self.errors.count() > mistakes {
                // the next entry would repeat the error
                return None;
            }
        }
        Some(Value::Array(entries))
    }

    /// Calls a closure with each of the arguments. Returns `None` after the first mistake, which
    /// the next call would repeat.
    pub(super) fn called(
        &mut self,
        closure: &Closure,
        arguments: impl Iterator<Item = Vec<Value>>,
        at: Span,
    ) -> Option<Vec<Value>> {
        let mistakes = self.errors.count();
        let mut results = Vec::new();
        for values in arguments {
            self.tick(&at)?;
            let values = values.into_iter();
            let arguments = values.map(|value| Argument { value, at }).collect();
            let result = self.call_closure(closure, arguments, &at);
            if self.errors.count() > mistakes {
                return None;
            }
            results.push(result.unwrap_or(Value::Poison));
        }
        Some(results)
    }

    /// Converts a value, or entries of it, that have waited for the annotated type.
    pub(super) fn awaited(&mut self, value: Value, ty: &Type, at: &impl Spanned) -> Value {
        if !value.waits_for_type() {
            return value;
        }
        let all = |this: &mut Self, values: Vec<Value>, ty: &Type| -> Vec<Value> {
            let values = values.into_iter();
            values.map(|value| this.awaited(value, ty, at)).collect()
        };
        let ty = bare(ty);
        match (value, ty) {
            (Value::Generated(closure), Type::Array(array)) => {
                let n = self.index_value(&array.len);
                n.and_then(|n| self.generated(&closure, n, Some(&array.elem), at))
                    .unwrap_or(Value::Poison)
            }
            (Value::Converted(inner), ty) => match (inner.unconverted(), ty) {
                (Value::Int(i), ty) if is_f64(ty) => self.constant(i.value as f64),
                (Value::Index(i), ty) if is_f64(ty) => Value::Scalar(self.number_of(i)),
                (Value::Int(i), ty) => {
                    let value = Value::Int(Integer::from(i.value));
                    self.number(value, ty, at)
                }
                (Value::Tuple(values), Type::Array(array)) => {
                    Value::Array(all(self, values, &array.elem))
                }
                (inner, ty) => self.awaited(inner, ty, at),
            },
            (Value::Array(values), Type::Array(array)) => {
                Value::Array(all(self, values, &array.elem))
            }
            (Value::Tuple(values), Type::Tuple(types)) if values.len() == types.elems.len() => {
                let pairs = values.into_iter().zip(&types.elems);
                let awaited = pairs.map(|(value, ty)| self.awaited(value, ty, at));
                Value::Tuple(awaited.collect())
            }
            (value, _) => value,
        }
    }
}
