//! What a variable of a body can hold while it is run symbolically.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, Type};

use super::{Lowering, readable};
use crate::parse::is_f64;
use crate::symbolic::Expr;

/// A value.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// An `f64`.
    Scalar(Expr),
    /// An integer known at compile time.
    Int(i64),
    Array(Vec<Value>),
    Tuple(Vec<Value>),
    /// A field of the user's struct: a number or an array, which its use decides.
    Field(FieldPath),
    Unit,
    /// The result of a mistake that has been reported.
    Poison,
}

impl Value {
    /// Numbers in it.
    pub(super) fn entries(&self) -> usize {
        match self {
            Self::Array(values) | Self::Tuple(values) => {
                1 + values.iter().map(Self::entries).sum::<usize>()
            }
            _ => 1,
        }
    }

    pub(super) fn kind(&self) -> String {
        match self {
            Self::Scalar(_) => "an `f64`".to_owned(),
            Self::Int(i) => format!("the integer {i}"),
            Self::Array(values) => format!("an array of {}", values.len()),
            Self::Tuple(values) => format!("a tuple of {}", values.len()),
            Self::Field(path) => format!("the field `{}`", super::readable(&path.access())),
            Self::Unit => "nothing".to_owned(),
            Self::Poison => "an error".to_owned(),
        }
    }
}

/// `self.a`, `self.m[2]`, `self.body.mass`.
#[derive(Clone, Debug)]
pub(super) struct FieldPath {
    steps: Vec<FieldStep>,
}

#[derive(Clone, Debug)]
enum FieldStep {
    Named(Ident),
    Numbered(u32),
    Index(usize),
}

impl FieldPath {
    pub(super) fn new() -> Self {
        Self { steps: Vec::new() }
    }

    pub(super) fn member(&self, member: &syn::Member) -> Self {
        self.then(match member {
            syn::Member::Named(name) => FieldStep::Named(name.clone()),
            syn::Member::Unnamed(index) => FieldStep::Numbered(index.index),
        })
    }

    pub(super) fn index(&self, index: usize) -> Self {
        self.then(FieldStep::Index(index))
    }

    fn then(&self, step: FieldStep) -> Self {
        let mut steps = self.steps.clone();
        steps.push(step);
        Self { steps }
    }

    /// The expression that reads it.
    pub(super) fn access(&self) -> TokenStream {
        let mut tokens = quote!(self);
        for step in &self.steps {
            match step {
                FieldStep::Named(name) => tokens.extend(quote!(. #name)),
                FieldStep::Numbered(index) => {
                    let index = Literal::u32_unsuffixed(*index);
                    tokens.extend(quote!(. #index));
                }
                FieldStep::Index(index) => {
                    let index = Literal::usize_unsuffixed(*index);
                    tokens.extend(quote!([#index]));
                }
            }
        }
        tokens
    }

    /// A name for generated code: `m_2`.
    pub(super) fn name(&self) -> String {
        let parts: Vec<String> = self
            .steps
            .iter()
            .map(|step| match step {
                FieldStep::Named(name) => name.to_string().trim_start_matches("r#").to_owned(),
                FieldStep::Numbered(index) => index.to_string(),
                FieldStep::Index(index) => index.to_string(),
            })
            .collect();
        parts.join("_")
    }
}

/// The type of an argument or result: `f64` or arrays of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Scalar,
    Array(usize, Box<Shape>),
}

impl Shape {
    /// Numbers in it.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Array(n, inner) => n * inner.len(),
        }
    }

    /// A value of this shape with entries from `next`, in memory order.
    pub(super) fn fill(&self, next: &mut dyn FnMut() -> Value) -> Value {
        match self {
            Self::Scalar => next(),
            Self::Array(n, inner) => Value::Array((0..*n).map(|_| inner.fill(next)).collect()),
        }
    }
}

/// Coordinates that one system may have: the step is unrolled.
const COORDINATES: usize = 512;

impl Lowering<'_> {
    /// The shape of a type, or an error at it.
    pub(super) fn shape(&mut self, ty: &Type) -> Option<Shape> {
        let shape = self.shape_within(ty, COORDINATES)?;
        if shape.len() > COORDINATES {
            self.errors.push(
                ty.span(),
                format!(
                    "{} numbers are too many to unroll; the limit is {COORDINATES}",
                    shape.len()
                ),
            );
            return None;
        }
        Some(shape)
    }

    fn shape_within(&mut self, ty: &Type, limit: usize) -> Option<Shape> {
        match ty {
            Type::Paren(inner) => self.shape_within(&inner.elem, limit),
            Type::Group(inner) => self.shape_within(&inner.elem, limit),
            _ if is_f64(ty) => Some(Shape::Scalar),
            Type::Array(array) => {
                let inner = self.shape_within(&array.elem, limit)?;
                let n = self.length(&array.len)?;
                if n > limit {
                    self.errors.push(
                        array.len.span(),
                        format!("{n} numbers are too many to unroll; the limit is {COORDINATES}"),
                    );
                    return None;
                }
                Some(Shape::Array(n, Box::new(inner)))
            }
            _ => {
                self.errors.push(
                    ty.span(),
                    format!(
                        "`{}` is not a type of coordinates: write `f64` or `[f64; N]`, by value",
                        readable(ty)
                    ),
                );
                None
            }
        }
    }

    fn length(&mut self, expr: &Syntax) -> Option<usize> {
        if let Syntax::Path(path) = expr
            && let Some(name) = path.path.get_ident()
        {
            self.refuse(
                expr,
                format!("`{name}` is not known here, for only this `impl` block is seen: write `const {name}: usize = …;` in this block and use `Self::{name}`"),
            );
            return None;
        }
        self.scopes.push(std::collections::HashMap::new());
        let value = self.eval(expr);
        self.scopes.pop();
        match value {
            Value::Int(n) if n >= 0 => usize::try_from(n).ok(),
            Value::Poison => None,
            other => {
                self.errors.push(
                    expr.span(),
                    format!("the length must be an integer known here, a literal or a constant of this block; found {}", other.kind()),
                );
                None
            }
        }
    }
}
