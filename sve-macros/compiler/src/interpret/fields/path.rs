//! The path of a parameter.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{quote, quote_spanned};

use super::super::matrices::MatrixType;
use crate::model::scene::Int;

/// The path of a parameter: `self.a`, `self.m[2]`, `self.body.mass`; `GRAVITY`,
/// `constants::MASSES[2]`.
#[derive(Clone, Default)]
pub(in super::super) struct FieldPath {
    /// The path of a constant from outside the block; `None` for a field of `self`.
    outside: Option<syn::Path>,
    steps: Vec<FieldStep>,
    /// True if the type is annotated as `f64`.
    is_number: bool,
    /// If `into` has been called, the function of the runtime that reads an entry of an array of
    /// columns or of a matrix.
    reader: Option<TokenStream>,
    /// The type of the vector or matrix whose entry the last step selects, if the type is known.
    vector: Option<MatrixType>,
}

#[derive(Clone)]
pub(in super::super) enum FieldStep {
    Named(Ident),
    Numbered(u32),
    /// An index, and its place in the source.
    Index(usize, Option<Span>),
    /// Row and column, and their place in the source.
    Pair(usize, usize, Option<Span>),
    /// A function of the runtime that reads an entry, its row and its column.
    Read(TokenStream, usize, usize),
    /// An index known when the program runs, and its text.
    At(Int, String),
    /// Row and column known when the program runs, and their text.
    AtPair(Int, Int, String),
}

impl FieldPath {
    /// Returns the path of a constant from outside the block. The default is the path `self`.
    pub(in super::super) fn outside(path: syn::Path) -> Self {
        Self {
            outside: Some(path),
            ..Self::default()
        }
    }

    /// Describes the parameter for messages.
    pub(in super::super) fn kind(&self) -> String {
        let path = crate::syntax::readable(&self.access());
        match (&self.outside, self.steps.is_empty()) {
            (Some(_), _) => {
                format!("`{path}`, a constant from outside this block, whose value is not seen")
            }
            (None, true) => "`self`".to_owned(),
            (None, false) => format!("the field `{path}`"),
        }
    }

    /// Returns the message for a constant from outside the block whose value the macro needs;
    /// `None` for other parameters.
    pub(in super::super) fn unseen(&self) -> Option<String> {
        let path = self.outside.as_ref().filter(|_| self.steps.is_empty())?;
        let name = path.segments.last().map(|last| last.ident.to_string());
        Some(unseen(
            &name.unwrap_or_default(),
            &crate::syntax::readable(path),
        ))
    }

    /// Returns whether the parameter is a constant from outside the block.
    pub(in super::super) fn is_outside(&self) -> bool {
        self.outside.is_some()
    }

    pub(in super::super) fn steps(&self) -> &[FieldStep] {
        &self.steps
    }

    /// Returns whether an index of the path is known when the program runs only.
    pub(super) fn is_running(&self) -> bool {
        let is_running =
            |step: &FieldStep| matches!(step, FieldStep::At(..) | FieldStep::AtPair(..));
        self.steps.iter().any(is_running)
    }

    /// Returns the path of the entry at an index known when the program runs.
    pub(in super::super) fn at(&self, index: Int, text: &str) -> Self {
        self.then(FieldStep::At(index, text.to_owned()))
    }

    /// Returns the path of an entry of a matrix at a row and column known when the program runs.
    pub(in super::super) fn at_pair(&self, row: Int, column: Int, text: &str) -> Self {
        self.then(FieldStep::AtPair(row, column, text.to_owned()))
    }

    /// Returns the path without the values of its indices.
    pub(super) fn kind_of_entry(&self) -> String {
        let steps = self.steps.iter().map(|step| match step {
            FieldStep::Named(name) => format!(".{name}"),
            FieldStep::Numbered(index) => format!(".{index}"),
            FieldStep::Index(..) | FieldStep::At(..) => "[]".to_owned(),
            FieldStep::Pair(..) | FieldStep::Read(..) | FieldStep::AtPair(..) => "[,]".to_owned(),
        });
        steps.collect()
    }

    pub(in super::super) fn is_self(&self) -> bool {
        self.outside.is_none() && self.steps.is_empty()
    }

    pub(in super::super) fn member(&self, member: &syn::Member) -> Self {
        self.then(match member {
            syn::Member::Named(name) => FieldStep::Named(name.clone()),
            syn::Member::Unnamed(index) => FieldStep::Numbered(index.index),
        })
    }

    pub(in super::super) fn index(&self, index: usize) -> Self {
        self.then(FieldStep::Index(index, None))
    }

    /// Returns the path of the entry whose index stands at `span`.
    pub(in super::super) fn index_at(&self, index: usize, span: Span) -> Self {
        self.then(FieldStep::Index(index, Some(span)))
    }

    /// Returns the path of an entry of a matrix.
    pub(in super::super) fn pair(&self, row: usize, column: usize) -> Self {
        self.then(match self.reader.clone() {
            Some(reader) => FieldStep::Read(reader, row, column),
            None => FieldStep::Pair(row, column, None),
        })
    }

    /// Returns the path of an entry of a matrix whose row and column stand at `span`.
    pub(in super::super) fn pair_at(&self, row: usize, column: usize, span: Span) -> Self {
        self.then(FieldStep::Pair(row, column, Some(span)))
    }

    /// Returns the path of a component of a vector.
    pub(in super::super) fn component(&self, name: &str) -> Self {
        let named = self.steps.iter().rev().find_map(|step| match step {
            FieldStep::Named(name) => Some(name.span()),
            _ => None,
        });
        let name = Ident::new(name, named.unwrap_or_else(Span::call_site));
        self.then(FieldStep::Named(name))
    }

    /// Records that the last step selects an entry of a vector or matrix of this type.
    pub(in super::super) fn entry_of(self, ty: MatrixType) -> Self {
        Self {
            vector: Some(ty),
            ..self
        }
    }

    /// Records a call of `into`. The parameter can then be an array or a vector, whatever the
    /// annotated type is.
    pub(in super::super) fn converted(self, reader: TokenStream) -> Self {
        Self {
            reader: Some(reader),
            ..self
        }
    }

    pub(in super::super) fn is_converted(&self) -> bool {
        self.reader.is_some()
    }

    /// Returns the type of the vector or matrix whose entry the last step selects, if the type is
    /// known.
    pub(in super::super) fn vector(&self) -> Option<MatrixType> {
        self.vector
    }

    /// Splits off the last step. Returns the path before it, and the step.
    pub(in super::super) fn last_step(&self) -> Option<(Self, &FieldStep)> {
        let (last, before) = self.steps.split_last()?;
        let base = Self {
            outside: self.outside.clone(),
            steps: before.to_vec(),
            ..Self::default()
        };
        Some((base, last))
    }

    /// Records that the type is annotated as `f64`.
    pub(in super::super) fn as_number(&self) -> Self {
        Self {
            is_number: true,
            ..self.clone()
        }
    }

    pub(in super::super) fn is_number(&self) -> bool {
        self.is_number
    }

    fn then(&self, step: FieldStep) -> Self {
        let steps = self.steps.iter().cloned();
        Self {
            outside: self.outside.clone(),
            steps: steps.chain([step]).collect(),
            is_number: self.is_number,
            ..Self::default()
        }
    }

    /// Returns the expression that reads the parameter.
    pub(in super::super) fn access(&self) -> TokenStream {
        let mut tokens = match &self.outside {
            Some(path) => quote!(#path),
            None => {
                // the compiler of Rust reports errors of types at this span
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
                FieldStep::Index(index, _) => {
                    let index = Literal::usize_unsuffixed(*index);
                    tokens.extend(quote!([#index]));
                }
                FieldStep::Pair(row, column, _) => {
                    let [row, column] = [row, column].map(|i| Literal::usize_unsuffixed(*i));
                    tokens.extend(quote!([(#row, #column)]));
                }
                FieldStep::Read(reader, row, column) => {
                    let [row, column] = [row, column].map(|i| Literal::usize_unsuffixed(*i));
                    tokens = quote!(#reader(&#tokens, #row, #column));
                }
                FieldStep::At(_, text) | FieldStep::AtPair(_, _, text) => {
                    let index: TokenStream = text.parse().unwrap_or_default();
                    tokens.extend(quote!([#index]));
                }
            }
        }
        tokens
    }

    /// Returns a name for generated code, such as `m_2`.
    pub(in super::super) fn name(&self) -> String {
        let plain = |name: &Ident| name.to_string().trim_start_matches("r#").to_owned();
        let path = self.outside.iter().flat_map(|path| &path.segments);
        let steps = self.steps.iter().map(|step| match step {
            FieldStep::Named(name) => plain(name),
            FieldStep::Numbered(index) => index.to_string(),
            FieldStep::Index(index, _) => index.to_string(),
            FieldStep::Pair(row, column, _) | FieldStep::Read(_, row, column) => {
                format!("{row}_{column}")
            }
            FieldStep::At(..) | FieldStep::AtPair(..) => "at".to_owned(),
        });
        let parts: Vec<String> = path.map(|s| plain(&s.ident)).chain(steps).collect();
        parts.join("_")
    }
}

/// Returns the message for a constant from outside the block whose value the macro needs.
pub(in super::super) fn unseen(name: &str, path: &str) -> String {
    format!(
        "`{path}` is outside of this `impl` block, the only text that the macro sees, and its value is needed here: put `const {name}: usize = …;` with the number into this block and write `Self::{name}`"
    )
}
