//! Values that wait for the type which is written beside them: `into`, and arrays of `array::from_fn`.

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

/// What to say of an array of `from_fn` whose length is not known.
pub(super) const NO_LENGTH: &str = "the length of this array is not written here: give its type, `let a: [f64; N] = …`, or write `std::array::from_fn::<_, N, _>(…)`";

impl Value {
    /// Whether it, or an entry, becomes what the type beside it says.
    fn waits_for_type(&self) -> bool {
        match self {
            Self::Converted(_) | Self::Generated(_) => true,
            Self::Array(values) | Self::Tuple(values) => values.iter().any(Self::waits_for_type),
            _ => false,
        }
    }

    /// The value before `into`.
    pub(super) fn unconverted(self) -> Self {
        match self {
            Self::Converted(inner) => inner.unconverted(),
            value => value,
        }
    }
}

impl Lowering<'_> {
    /// `x.into()`: numbers and arrays are what they are; integers and tuples may become numbers and arrays.
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

    /// `array::from_fn(…)`, with its length if that is written as a generic argument.
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
            // a single name is read as a type
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

    /// The array of `n` values of a closure.
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
                // the same mistake for the next entry would be the same error
                return Value::Poison;
            }
            values.push(match entry {
                Some(ty) => self.awaited(value, ty, at),
                None => value,
            });
        }
        Value::Array(values)
    }

    /// A value of a type that is written, where it or one of its entries has waited for that.
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
