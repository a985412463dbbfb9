//! Values whose type is inferred from a type annotation: results of `into`, and arrays made by `array::from_fn`.

use std::rc::Rc;

use quote::quote;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, GenericArgument, PathArguments, Type};

use super::Lowering;
use super::calls::Argument;
use super::closures::Closure;
use super::integers::Integer;
use super::value::Value;
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
    /// Evaluates `x.into()`. Integers and tuples may become numbers and arrays; other values stay as they are.
    pub(super) fn converted(&self, receiver: Value) -> Value {
        match receiver {
            Value::Int(_) | Value::Tuple(_) => Value::Converted(Box::new(receiver)),
            Value::Field(path) => {
                let runtime = &self.block.arguments.runtime;
                Value::Field(path.converted(quote!(#runtime::__private::entry)))
            }
            other => other,
        }
    }

    /// Evaluates `array::from_fn(…)`. Without a length among the generic arguments, the array waits for a type annotation.
    pub(super) fn array_from_fn(&mut self, path: &syn::ExprPath, arguments: &[Argument]) -> Value {
        let closure = match arguments {
            [
                Argument {
                    value: Value::Closure(closure),
                    ..
                },
            ] => Rc::clone(closure),
            [
                Argument {
                    value: Value::Poison,
                    ..
                },
            ] => return Value::Poison,
            _ => {
                return self.refuse(
                    path,
                    "`from_fn` takes a closure, as in `std::array::from_fn(|i| 2.0 * q[i])`",
                );
            }
        };
        let generics = match path.path.segments.last().map(|segment| &segment.arguments) {
            Some(PathArguments::AngleBracketed(generics)) => &generics.args,
            _ => return Value::Generated(closure),
        };
        let length = match generics.iter().nth(1) {
            Some(GenericArgument::Const(length)) => length.clone(),
            // syn parses a single name as a type
            Some(GenericArgument::Type(Type::Path(name))) => Syntax::Path(syn::ExprPath {
                attrs: Vec::new(),
                qself: None,
                path: name.path.clone(),
            }),
            _ => return Value::Generated(closure),
        };
        match self.index_value(&length) {
            Some(n) => self.generated(&closure, n, None, &length),
            None => Value::Poison,
        }
    }

    /// Returns the array of the `n` values of a closure.
    fn generated(
        &mut self,
        closure: &Closure,
        n: usize,
        entry: Option<&Type>,
        at: &impl Spanned,
    ) -> Value {
        let mistakes = self.errors.count();
        let mut values = Vec::new();
        for i in 0..n {
            if !self.tick(at) {
                return Value::Poison;
            }
            let index = Argument {
                value: Value::Int(Integer::count(i)),
                at: at.span(),
            };
            let value = self.call_closure(closure, vec![index], at);
            if self.errors.count() > mistakes {
                // the next entry would repeat the error
                return Value::Poison;
            }
            values.push(match entry {
                Some(ty) => self.awaited(value, ty, at),
                None => value,
            });
        }
        Value::Array(values)
    }

    /// Converts a value, or entries of it, that have waited for the annotated type.
    pub(super) fn awaited(&mut self, value: Value, ty: &Type, at: &impl Spanned) -> Value {
        if !value.waits_for_type() {
            return value;
        }
        match (value, ty) {
            (value, Type::Paren(inner)) => self.awaited(value, &inner.elem, at),
            (value, Type::Group(inner)) => self.awaited(value, &inner.elem, at),
            (Value::Generated(closure), Type::Array(array)) => match self.index_value(&array.len) {
                Some(n) => self.generated(&closure, n, Some(&array.elem), at),
                None => Value::Poison,
            },
            (Value::Converted(inner), ty) => match (inner.unconverted(), ty) {
                (Value::Int(i), ty) if is_f64(ty) => {
                    Value::Scalar(self.arena.constant(i.value as f64))
                }
                (Value::Int(i), ty) => {
                    let value = Value::Int(Integer::from(i.value));
                    self.number(value, ty, at)
                }
                (Value::Tuple(values), Type::Array(array)) => {
                    let entries = values.into_iter();
                    Value::Array(
                        entries
                            .map(|value| self.awaited(value, &array.elem, at))
                            .collect(),
                    )
                }
                (inner, ty) => self.awaited(inner, ty, at),
            },
            (Value::Array(values), Type::Array(array)) => Value::Array(
                values
                    .into_iter()
                    .map(|value| self.awaited(value, &array.elem, at))
                    .collect(),
            ),
            (Value::Tuple(values), Type::Tuple(types)) if values.len() == types.elems.len() => {
                let pairs = values.into_iter().zip(&types.elems);
                Value::Tuple(
                    pairs
                        .map(|(value, ty)| self.awaited(value, ty, at))
                        .collect(),
                )
            }
            (value, _) => value,
        }
    }
}
