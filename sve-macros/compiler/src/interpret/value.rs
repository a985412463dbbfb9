//! What a variable of a body can hold while it is run symbolically.

use std::rc::Rc;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr as Syntax, Type};

use super::closures::Closure;
use super::integers::Integer;
use super::references::Place;
use super::{Lowering, readable};
use crate::algebra::Expr;
use crate::syntax::parse::is_f64;

/// A value.
#[derive(Clone)]
pub(super) enum Value {
    /// An `f64`.
    Scalar(Expr),
    /// An integer known at compile time.
    Int(Integer),
    Array(Vec<Value>),
    Tuple(Vec<Value>),
    /// An iterator: the list of its items.
    Sequence(Vec<Value>),
    /// A field of the user's struct, or a constant from outside the block: a number or an array, which its use decides.
    Field(FieldPath),
    /// `|x| …`, which waits to be called.
    Closure(Rc<Closure>),
    /// `x.into()`: what it becomes is for the type that is written beside it to say.
    Converted(Box<Value>),
    /// `array::from_fn(…)`, whose length is for the type that is written beside it to say.
    Generated(Rc<Closure>),
    /// A mutable reference.
    Place(Place),
    Unit,
    /// A variable that has been declared and not yet assigned to.
    Unset,
    /// The result of a mistake that has been reported.
    Poison,
}

impl Value {
    /// Numbers in it.
    pub(super) fn entries(&self) -> usize {
        match self {
            Self::Array(values) | Self::Tuple(values) | Self::Sequence(values) => {
                1 + values.iter().map(Self::entries).sum::<usize>()
            }
            _ => 1,
        }
    }

    /// Whether arrays are nested in it more than `depth` deep.
    pub(super) fn is_deeper(&self, depth: usize) -> bool {
        match self {
            Self::Array(values) | Self::Tuple(values) | Self::Sequence(values) => {
                depth == 0 || values.iter().any(|value| value.is_deeper(depth - 1))
            }
            _ => false,
        }
    }

    pub(super) fn kind(&self) -> String {
        match self {
            Self::Scalar(_) => "an `f64`".to_owned(),
            Self::Int(i) => format!("the integer {}", i.value),
            Self::Array(values) => format!("an array of {}", values.len()),
            Self::Tuple(values) => format!("a tuple of {}", values.len()),
            Self::Sequence(values) => format!("an iterator over {}", values.len()),
            Self::Field(path) => path.kind(),
            Self::Closure(_) => "a closure".to_owned(),
            Self::Converted(inner) => inner.kind(),
            Self::Generated(_) => "an array whose length is not written".to_owned(),
            Self::Place(_) => "a mutable reference".to_owned(),
            Self::Unit => "nothing".to_owned(),
            Self::Unset => "a variable without a value".to_owned(),
            Self::Poison => "an error".to_owned(),
        }
    }
}

/// `self.a`, `self.m[2]`, `self.body.mass`; `GRAVITY`, `constants::MASSES[2]`.
#[derive(Clone)]
pub(super) struct FieldPath {
    /// A constant from outside the block; `self` if there is none.
    outside: Option<syn::Path>,
    steps: Vec<FieldStep>,
}

#[derive(Clone)]
enum FieldStep {
    Named(Ident),
    Numbered(u32),
    Index(usize),
}

impl FieldPath {
    /// `self`.
    pub(super) fn new() -> Self {
        Self {
            outside: None,
            steps: Vec::new(),
        }
    }

    /// A constant from outside the block.
    pub(super) fn outside(path: syn::Path) -> Self {
        Self {
            outside: Some(path),
            steps: Vec::new(),
        }
    }

    /// What it is, for messages.
    pub(super) fn kind(&self) -> String {
        let path = super::readable(&self.access());
        match (&self.outside, self.steps.is_empty()) {
            (Some(_), _) => {
                format!("`{path}`, a constant from outside this block, whose value is not seen")
            }
            (None, true) => "`self`".to_owned(),
            (None, false) => format!("the field `{path}`"),
        }
    }

    /// What to say of a constant from outside the block where the macro needs its value; nothing of other fields.
    pub(super) fn unseen(&self) -> Option<String> {
        let path = self.outside.as_ref().filter(|_| self.steps.is_empty())?;
        let name = path.segments.last().map(|last| last.ident.to_string());
        Some(unseen(&name.unwrap_or_default(), &super::readable(path)))
    }

    pub(super) fn is_self(&self) -> bool {
        self.outside.is_none() && self.steps.is_empty()
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
        let mut longer = self.clone();
        longer.steps.push(step);
        longer
    }

    /// The expression that reads it.
    pub(super) fn access(&self) -> TokenStream {
        let mut tokens = match &self.outside {
            Some(path) => quote!(#path),
            None => {
                // for errors that the compiler has with the field
                let at = match self.steps.first() {
                    Some(FieldStep::Named(name)) => name.span().resolved_at(Span::call_site()),
                    _ => Span::call_site(),
                };
                quote_spanned!(at=> self)
            }
        };
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
        let plain = |name: &Ident| name.to_string().trim_start_matches("r#").to_owned();
        let path = self.outside.iter().flat_map(|path| &path.segments);
        let steps = self.steps.iter().map(|step| match step {
            FieldStep::Named(name) => plain(name),
            FieldStep::Numbered(index) => index.to_string(),
            FieldStep::Index(index) => index.to_string(),
        });
        let parts: Vec<String> = path.map(|s| plain(&s.ident)).chain(steps).collect();
        parts.join("_")
    }
}

/// What to say of a constant from outside the block where the macro needs its value.
fn unseen(name: &str, path: &str) -> String {
    format!(
        "`{path}` is outside of this `impl` block, the only text that the macro sees, and its value is needed here: put `const {name}: usize = …;` with the number into this block and write `Self::{name}`"
    )
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
        if let Some(name) = bare_name(expr) {
            let message = if self.constant_named(&name.to_string()).is_some() {
                format!("a constant of this block is written `Self::{name}`")
            } else {
                unseen(&name.to_string(), &name.to_string())
            };
            self.refuse(name, message);
            return None;
        }
        self.scopes.push(std::collections::HashMap::new());
        let value = self.eval(expr);
        self.scopes.pop();
        match value {
            Value::Int(n) if n.value >= 0 => usize::try_from(n.value).ok(),
            Value::Poison => None,
            other => {
                if let Value::Field(path) = &other
                    && let Some(message) = path.unseen()
                {
                    self.refuse(expr, message);
                    return None;
                }
                self.errors.push(
                    expr.span(),
                    format!("the length must be an integer known here, a literal or a constant of this block; found {}", other.kind()),
                );
                None
            }
        }
    }
}

/// A name that stands alone in a length.
fn bare_name(expr: &Syntax) -> Option<&Ident> {
    match expr {
        Syntax::Path(path) => path.path.get_ident(),
        Syntax::Binary(binary) => bare_name(&binary.left).or_else(|| bare_name(&binary.right)),
        Syntax::Paren(inner) => bare_name(&inner.expr),
        Syntax::Cast(cast) => bare_name(&cast.expr),
        _ => None,
    }
}
