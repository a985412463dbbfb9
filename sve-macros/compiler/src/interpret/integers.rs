//! Integers known at compile time, with the types and the overflow of Rust: casts wrap, arithmetic out of range is refused.
//!
//! The type of an integer without a suffix follows from its use; without a use that decides, it is `i32`. Arithmetic of such integers
//! must stay within the range of `i32`, so that a function which overflows when it is called is not accepted.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{BinOp, Type};

use super::Lowering;
use super::calls::Argument;
use super::value::Value;
use crate::syntax::parse::is_f64;

/// A type of integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    name: &'static str,
    bits: u32,
    signed: bool,
}

const KINDS: [Kind; 12] = [
    kind("u8", 8, false),
    kind("u16", 16, false),
    kind("u32", 32, false),
    kind("u64", 64, false),
    kind("u128", 128, false),
    kind("usize", 64, false),
    kind("i8", 8, true),
    kind("i16", 16, true),
    I32,
    kind("i64", 64, true),
    kind("i128", 128, true),
    kind("isize", 64, true),
];

const I32: Kind = kind("i32", 32, true);

/// The type of lengths and indices.
pub(super) const USIZE: Kind = kind("usize", 64, false);

const fn kind(name: &'static str, bits: u32, signed: bool) -> Kind {
    Kind { name, bits, signed }
}

impl Kind {
    /// Returns the type of this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        KINDS.into_iter().find(|kind| kind.name == name)
    }

    /// Returns the type of integers that is written.
    fn of(ty: &Type) -> Option<Self> {
        match ty {
            Type::Path(path) if path.qself.is_none() => {
                Self::named(&path.path.get_ident()?.to_string())
            }
            Type::Paren(inner) => Self::of(&inner.elem),
            Type::Group(inner) => Self::of(&inner.elem),
            _ => None,
        }
    }

    fn contains(self, value: i64) -> bool {
        self.wrapped(value) == Some(value)
    }

    /// Returns the value after a cast to this type; `None` if it does not fit into an `i64`.
    fn wrapped(self, value: i64) -> Option<i64> {
        let unused = 64 - self.bits.min(64);
        match (unused, self.signed) {
            (0, false) => (value >= 0).then_some(value),
            (_, false) => Some(((value.cast_unsigned() << unused) >> unused).cast_signed()),
            (_, true) => Some((value << unused) >> unused),
        }
    }
}

/// An integer that is known at compile time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Integer {
    pub(super) value: i64,
    /// The type, if it is written or follows from a use.
    pub(super) kind: Option<Kind>,
}

impl From<i64> for Integer {
    fn from(value: i64) -> Self {
        Self { value, kind: None }
    }
}

impl Integer {
    /// Returns a length or an index.
    pub(super) fn count(count: usize) -> Self {
        Self {
            value: count as i64,
            kind: Some(USIZE),
        }
    }

    /// Gives an integer without a type this type.
    pub(super) fn or_of(self, kind: Kind) -> Self {
        Self {
            kind: self.kind.or(Some(kind)),
            ..self
        }
    }
}

/// Returns whether a type is a type of integers.
pub(super) fn is_integer(ty: &Type) -> bool {
    Kind::of(ty).is_some()
}

/// Returns an associated constant such as `u8::MAX`, if it fits into an `i64`.
pub(super) fn integer_constant(ty: &str, name: &str) -> Option<Integer> {
    let kind = Kind::named(ty)?;
    let value = match (name, kind.signed) {
        ("BITS", _) => {
            return Some(Integer {
                value: i64::from(kind.bits),
                kind: Kind::named("u32"),
            });
        }
        ("MIN", false) => 0,
        ("MIN", true) if kind.bits <= 64 => i64::MIN >> (64 - kind.bits),
        ("MAX", true) if kind.bits <= 64 => i64::MAX >> (64 - kind.bits),
        ("MAX", false) if kind.bits < 64 => (1 << kind.bits) - 1,
        _ => return None,
    };
    Some(Integer {
        value,
        kind: Some(kind),
    })
}

/// Returns the common type of two integers, or both types if they differ.
pub(super) fn common(a: Integer, b: Integer) -> Result<Option<Kind>, (Kind, Kind)> {
    match (a.kind, b.kind) {
        (Some(a), Some(b)) if a != b => Err((a, b)),
        (a, b) => Ok(a.or(b)),
    }
}

impl Lowering<'_> {
    /// Returns the result of integer arithmetic, or reports an error if the result overflows its type.
    pub(super) fn computed(
        &mut self,
        value: Option<i64>,
        kind: Option<Kind>,
        at: &impl Spanned,
    ) -> Value {
        let range = kind.unwrap_or(I32);
        match (value, kind) {
            (Some(value), kind) if range.contains(value) => Value::Int(Integer { value, kind }),
            (Some(value), Some(kind)) if value < 0 && !kind.signed => self.refuse(
                at,
                format!(
                    "this is {value}, which overflows `{}`: begin the loop later, write `(i + N - 1) % N` on a ring, or `i as f64 - 1.0` for a number",
                    kind.name
                ),
            ),
            (_, Some(kind)) => self.refuse(
                at,
                format!(
                    "this integer arithmetic overflows `{}` or divides by zero",
                    kind.name
                ),
            ),
            (_, None) => self.refuse(
                at,
                "this integer arithmetic overflows `i32`, the type of integers that have no other, or divides by zero: write the type, as in `1_u64`",
            ),
        }
    }

    /// Computes with two integers.
    pub(super) fn integer_arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        a: Integer,
        b: Integer,
    ) -> Value {
        let kind = match common(a, b) {
            Ok(kind) => kind,
            Err(kinds) => return self.two_kinds(kinds, token),
        };
        let (a, b) = (a.value, b.value);
        let result = match op {
            '+' => a.checked_add(b),
            '-' => a.checked_sub(b),
            '*' => a.checked_mul(b),
            '%' => a.checked_rem(b),
            _ => a.checked_div(b),
        };
        self.computed(result, kind, token)
    }

    pub(super) fn two_kinds(&mut self, (a, b): (Kind, Kind), at: &impl Spanned) -> Value {
        let message = format!(
            "`{}` and `{}` are two types of integers: convert one with `as`",
            a.name, b.name
        );
        self.refuse(at, message)
    }

    /// Returns the value of a literal, or reports an error if the value does not fit into the type of the suffix.
    pub(super) fn typed_literal(
        &mut self,
        value: i64,
        kind: Option<Kind>,
        at: &impl Spanned,
    ) -> Value {
        match kind {
            // `-128_i8` is the negative of 128, which does not fit into an `i8`
            Some(kind) if !kind.contains(value) && !kind.contains(-value) => self.refuse(
                at,
                format!("the integer {value} does not fit into `{}`", kind.name),
            ),
            _ => Value::Int(Integer { value, kind }),
        }
    }

    /// Computes `-i`.
    pub(super) fn negated(&mut self, i: Integer, at: &impl Spanned) -> Value {
        let negative = i.value.checked_neg();
        match (negative, i.kind) {
            // `-2147483648` is a valid `i32`, but 2147483648 is not
            (Some(value), None) => Value::Int(value.into()),
            (value, kind) => self.computed(value, kind, at),
        }
    }

    /// Evaluates `as`, for integers only.
    pub(super) fn cast(&mut self, cast: &syn::ExprCast) -> Value {
        let value = self.eval(&cast.expr).unconverted();
        let target = crate::syntax::readable(&cast.ty);
        match (value, Kind::of(&cast.ty)) {
            (Value::Poison, _) => Value::Poison,
            (Value::Int(i), _) if is_f64(&cast.ty) => {
                Value::Scalar(self.arena.constant(i.value as f64))
            }
            (Value::Int(i), Some(kind)) => match kind.wrapped(i.value) {
                Some(value) => Value::Int(Integer {
                    value,
                    kind: Some(kind),
                }),
                None => {
                    let message = format!(
                        "`{}` does not fit into `{target}`: the cast would wrap around to a number beyond 2⁶³",
                        i.value
                    );
                    self.refuse(&cast.as_token, message)
                }
            },
            (Value::Int(_), None) => self.refuse(
                &cast.ty,
                format!("an integer becomes an `f64` or another type of integers here, written by name, not `{target}`"),
            ),
            (value @ Value::Field(_), _) => {
                let message = format!(
                    "`as` is for integers known at compile time, and this is {}: let its type be `f64`, and leave `as` out",
                    value.kind()
                );
                self.refuse(&cast.as_token, message)
            }
            (value, _) => {
                let message = format!(
                    "`as` is for integers known at compile time, and this is {}: leave it out, every number of a formula is an `f64`",
                    value.kind()
                );
                self.refuse(&cast.as_token, message)
            }
        }
    }

    /// Checks an integer against an annotated type: it must not be `f64`, and the integer must fit into it. Returns other values as
    /// they are.
    pub(super) fn number(&mut self, value: Value, ty: &Type, at: &impl Spanned) -> Value {
        let Value::Int(i) = value else { return value };
        if is_f64(ty) {
            return self.refuse(at, super::integer(i.value));
        }
        let Some(kind) = Kind::of(ty) else {
            return value;
        };
        match i.kind {
            Some(other) if other != kind => self.two_kinds((other, kind), at),
            None if !kind.contains(i.value) => {
                let message = format!("the integer {} does not fit into `{}`", i.value, kind.name);
                self.refuse(at, message)
            }
            _ => Value::Int(i.or_of(kind)),
        }
    }

    /// Calls a method of integers; `None` if there is no such method, or an argument is not an integer.
    pub(super) fn integer_method(
        &mut self,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Option<Value> {
        let integer = |argument: &Argument| match argument.value {
            Value::Int(i) => Some(i),
            _ => None,
        };
        let values: Vec<Integer> = arguments.iter().map(integer).collect::<Option<_>>()?;
        let (i, k, kinds) = match (name, values.as_slice()) {
            ("abs", &[i]) => (i, i, Ok(i.kind)),
            ("pow", &[i, k]) => (i, k, Ok(i.kind)),
            ("abs_diff" | "min" | "max" | "rem_euclid", &[i, k]) => (i, k, common(i, k)),
            _ => return None,
        };
        let kind = match kinds {
            Ok(kind) => kind,
            Err(kinds) => return Some(self.two_kinds(kinds, &at)),
        };
        let (i, k) = (i.value, k.value);
        let result = match name {
            "pow" => u32::try_from(k).ok().and_then(|k| i.checked_pow(k)),
            "abs" => i.checked_abs(),
            "abs_diff" => i.checked_sub(k).and_then(i64::checked_abs),
            "min" => Some(i.min(k)),
            "max" => Some(i.max(k)),
            _ => i.checked_rem_euclid(k),
        };
        // `abs_diff` of signed integers returns the unsigned type
        let kind = match (name, kind) {
            ("abs_diff", Some(kind)) => KINDS
                .into_iter()
                .find(|other| other.name.strip_prefix('u') == kind.name.strip_prefix('i'))
                .filter(|_| kind.signed)
                .or(Some(kind)),
            (_, kind) => kind,
        };
        Some(self.computed(result, kind, &at))
    }
}
