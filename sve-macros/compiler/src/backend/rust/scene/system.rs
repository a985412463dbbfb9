//! `impl AnySystem` and `impl Rule` of a scene.

use proc_macro2::TokenStream;
use quote::quote;

use super::super::function::Formulas;
use crate::catalogue::Rule;
use crate::scene::Derived;
use crate::syntax::parse::Annotated;

pub(super) fn system(_: &Derived, _: &Annotated, _: Formulas<'_>) -> TokenStream {
    quote!()
}

pub(super) fn rule(_: Rule, _: &Derived, _: &Annotated, _: Formulas<'_>) -> TokenStream {
    quote!()
}
