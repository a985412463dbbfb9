//! Integers known at compile time, with the types and the overflow of Rust: casts wrap, arithmetic
//! out of range is refused.
//!
//! The type of an integer without a suffix follows from its use; without a use that decides, it is
//! `i32`. Arithmetic of such integers must stay within the range of `i32`, so that a function which
//! overflows when it is called is not accepted.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{BinOp, Type};

use super::Lowering;
use super::calls::Argument;
use super::value::Value;
use crate::syntax::parse::is_f64;
use crate::syntax::{bare, readable};

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
    /// Returns the type with this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        KINDS.into_iter().find(|kind| kind.name == name)
    }

    /// Returns the type of integers that the source annotates.
    fn of(ty: &Type) -> Option<Self> {
        match bare(ty) {
            Type::Path(path) if path.qself.is_none() => {
                Self::named(&path.path.get_ident()?.to_string())
            }
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

/// A method of one or two integers.
type Compute = fn(i64, i64) -> Option<i64>;

/// The methods of integers. `abs_diff` of signed integers returns the unsigned type.
const METHODS: [(&str, Compute); 6] = [
    ("abs", |i, _| i.checked_abs()),
    ("pow", |i, k| i.checked_pow(u32::try_from(k).ok()?)),
    ("abs_diff", |i, k| i.checked_sub(k)?.checked_abs()),
    ("min", |i, k| Some(i.min(k))),
    ("max", |i, k| Some(i.max(k))),
    ("rem_euclid", i64::checked_rem_euclid),
];

/// Returns the method of this name with its operands, the same integer twice if the method takes no
/// argument; `None` if there is no such method, or an argument is not an integer.
pub(super) fn method(name: &str, arguments: &[Argument]) -> Option<(Compute, [Integer; 2])> {
    let &(_, compute) = METHODS.iter().find(|method| method.0 == name)?;
    let integer = |argument: &Argument| match argument.value {
        Value::Int(i) => Some(i),
        _ => None,
    };
    let values: Vec<Integer> = arguments.iter().map(integer).collect::<Option<_>>()?;
    match values.as_slice() {
        [i] if name == "abs" => Some((compute, [*i, *i])),
        [i, k] if name != "abs" => Some((compute, [*i, *k])),
        _ => None,
    }
}

/// Returns whether a value that may be an integer is annotated as one.
fn kind_of_field(value: &Value, ty: &Type) -> Option<()> {
    let is_unknown = matches!(value, Value::Field(_) | Value::Scalar(_));
    (is_unknown && is_integer(ty)).then_some(())
}

impl Lowering<'_> {
    /// Returns the common type of two integers, or reports an error if they have two types.
    pub(super) fn common(
        &mut self,
        a: Integer,
        b: Integer,
        at: &impl Spanned,
    ) -> Result<Option<Kind>, ()> {
        match (a.kind, b.kind) {
            (Some(a), Some(b)) if a != b => self.two_kinds(a, b, at).ok_or(()),
            (a, b) => Ok(a.or(b)),
        }
    }

    fn two_kinds<T>(&mut self, a: Kind, b: Kind, at: &impl Spanned) -> Option<T> {
        let message = format!(
            "`{}` and `{}` are two types of integers: convert one with `as`",
            a.name, b.name
        );
        self.refuse(at, message)
    }

    /// Returns the result of integer arithmetic, or reports an error if the result overflows its
    /// type.
    pub(super) fn computed(
        &mut self,
        value: Option<i64>,
        kind: Option<Kind>,
        at: &impl Spanned,
    ) -> Option<Value> {
        let message = match (value, kind) {
            (Some(value), kind) if kind.unwrap_or(I32).contains(value) => {
                return Some(Value::Int(Integer { value, kind }));
            }
            (Some(value), Some(kind)) if value < 0 && !kind.signed => format!(
                "this is {value}, which overflows `{}`: begin the loop later, write `(i + N - 1) % N` on a ring, or `i as f64 - 1.0` for a number",
                kind.name
            ),
            (_, Some(kind)) => format!(
                "this integer arithmetic overflows `{}` or divides by zero",
                kind.name
            ),
            (_, None) => "this integer arithmetic overflows `i32`, the type of integers that have no other, or divides by zero: write the type, as in `1_u64`".to_owned(),
        };
        self.refuse(at, message)
    }

    /// Computes with two integers.
    pub(super) fn integer_arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        a: Integer,
        b: Integer,
    ) -> Option<Value> {
        let kind = self.common(a, b, token).ok()?;
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

    /// Returns the value of a literal, or reports an error if the value does not fit into the type
    /// of the suffix.
    pub(super) fn typed_literal(
        &mut self,
        value: i64,
        kind: Option<Kind>,
        at: &impl Spanned,
    ) -> Option<Value> {
        match kind {
            // `-128_i8` is the negative of 128, which does not fit into an `i8`
            Some(kind) if !kind.contains(value) && !kind.contains(-value) => self.refuse(
                at,
                format!("the integer {value} does not fit into `{}`", kind.name),
            ),
            _ => Some(Value::Int(Integer { value, kind })),
        }
    }

    /// Computes `-i`.
    pub(super) fn negated(&mut self, i: Integer, at: &impl Spanned) -> Option<Value> {
        match (i.value.checked_neg(), i.kind) {
            // `-2147483648` is a valid `i32`, but 2147483648 is not
            (Some(value), None) => Some(Value::Int(value.into())),
            (value, kind) => self.computed(value, kind, at),
        }
    }

    /// Evaluates `as`, for integers only.
    pub(super) fn cast(&mut self, cast: &syn::ExprCast) -> Option<Value> {
        let value = self.eval(&cast.expr)?.unconverted();
        let target = readable(&cast.ty);
        let kind = Kind::of(&cast.ty);
        if !matches!(value, Value::Int(_))
            && (is_f64(&cast.ty) || kind.is_some_and(|kind| kind.bits >= 32))
            && let Some(integer) = self.running(&value)
        {
            return Some(match kind {
                Some(_) => self.index_value_of(integer),
                None => Value::Scalar(self.number_of(integer)),
            });
        }
        let message = match (value, kind) {
            (Value::Poison, _) => return None,
            (Value::Int(i), _) if is_f64(&cast.ty) => return Some(self.constant(i.value as f64)),
            (Value::Int(i), Some(kind)) => match kind.wrapped(i.value) {
                Some(value) => {
                    let kind = Some(kind);
                    return Some(Value::Int(Integer { value, kind }));
                }
                None => format!(
                    "`{}` does not fit into `{target}`: the cast would wrap around to a number beyond 2⁶³",
                    i.value
                ),
            },
            (Value::Int(_), None) => {
                let message = format!(
                    "an integer becomes an `f64` or another type of integers here, written by name, not `{target}`"
                );
                return self.refuse(&cast.ty, message);
            }
            (value, _) => {
                let instead = match value {
                    Value::Field(_) => "let its type be `f64`, and leave `as` out",
                    _ => "leave it out, every number of a formula is an `f64`",
                };
                format!(
                    "`as` is for integers known at compile time, and this is {}: {instead}",
                    value.kind()
                )
            }
        };
        self.refuse(&cast.as_token, message)
    }

    /// Checks an integer against an annotated type: the type must not be `f64`, and it must contain
    /// the integer. Returns other values unchanged.
    pub(super) fn number(&mut self, value: Value, ty: &Type, at: &impl Spanned) -> Value {
        let (Value::Int(i), kind) = (&value, Kind::of(ty)) else {
            let running = kind_of_field(&value, ty).and_then(|()| self.running(&value));
            return running.map_or(value, Value::Index);
        };
        let checked = match (i.kind, kind) {
            _ if is_f64(ty) => self.refuse(at, super::integer(i.value)),
            (_, None) => return value,
            (Some(other), Some(kind)) if other != kind => self.two_kinds(other, kind, at),
            (None, Some(kind)) if !kind.contains(i.value) => {
                let message = format!("the integer {} does not fit into `{}`", i.value, kind.name);
                self.refuse(at, message)
            }
            (_, Some(kind)) => Some(Value::Int(i.or_of(kind))),
        };
        checked.unwrap_or(Value::Poison)
    }

    /// Calls a method of integers.
    pub(super) fn integer_method(
        &mut self,
        name: &str,
        compute: Compute,
        [i, k]: [Integer; 2],
        at: Span,
    ) -> Option<Value> {
        let kind = match name {
            "pow" => i.kind,
            _ => self.common(i, k, &at).ok()?,
        };
        let unsigned = |kind: Kind| {
            let mut kinds = KINDS.into_iter();
            kinds.find(|other| other.name.strip_prefix('u') == kind.name.strip_prefix('i'))
        };
        let kind = match kind {
            Some(kind) if kind.signed && name == "abs_diff" => unsigned(kind),
            kind => kind,
        };
        self.computed(compute(i.value, k.value), kind, &at)
    }
}
