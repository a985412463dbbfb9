//! Plans and instructions → tokens. Infallible, and the only place that knows it prints Rust.
//!
//! A generic parameter hides a type or a constant of the user with the same name, so the names of
//! generic parameters begin with two underscores.

mod axis;
mod calls;
mod code;
mod cold;
mod configuration;
mod energy;
mod euler;
mod expressions;
mod factors;
mod function;
mod gauss;
mod identity;
mod implementation;
mod inputs;
mod jets;
mod judge;
mod lanes;
mod linearise;
mod momenta;
mod node_bounds;
mod pivots;
mod placeholders;
mod plan;
mod print;
mod rounding;
mod rule;
mod scene;
mod scopes;
mod solve;
mod stages;
mod start;
mod step;
mod system;
mod tangents;
mod time_scale;
mod unstructured;

use function::Formulas;
use gauss::gauss;
use momenta::momenta;
pub(crate) use placeholders::placeholders;
pub(crate) use print::print;
use rule::rule;
pub(crate) use scene::print as print_scene;
use scopes::bounded;
use stages::stages;
use start::start_of_step;
use system::system;
#[cfg(test)]
pub(crate) use time_scale::nodes_between;

use proc_macro2::{Ident, Literal, Span, TokenStream, TokenTree};
use quote::{quote, quote_spanned};
use syn::Type;

use crate::algebra::Arena;
use crate::catalogue::Rule;
use crate::derivation::Derived;
use crate::explain::SystemTexts;
use crate::model::Model;
use crate::settings::Settings;
use crate::syntax::parse::Annotated;
use crate::system::commutation::Commutation;
use crate::system::degeneracy::Degeneracy;
use crate::system::mechanics::Mechanics;
use crate::system::symmetry::{MomentumMap, momentum_name};

/// The context that the rules of a block share.
pub(crate) struct Context<'a> {
    pub(crate) settings: Settings,
    pub(crate) block: &'a Annotated,
    pub(crate) model: &'a Model,
    pub(crate) mechanics: &'a Mechanics,
    pub(crate) commutation: &'a Commutation,
    pub(crate) degeneracy: Option<&'a Degeneracy>,
    pub(crate) momenta: &'a [MomentumMap],
    pub(crate) about: &'a SystemTexts,
    pub(crate) arena: &'a Arena,
    pub(crate) private: &'a TokenStream,
    /// The type whose steps are derived: that of the block, or the one that holds its inputs.
    pub(crate) stepped: &'a Type,
}

impl<'a> Context<'a> {
    /// The context in which formulas of the system are printed.
    fn formulas(&self) -> Formulas<'a> {
        Formulas {
            arena: self.arena,
            symbols: &self.model.symbols,
            private: self.private,
        }
    }

    /// The context in which formulas of a step are printed.
    fn formulas_of(&self, derived: &'a Derived) -> Formulas<'a> {
        Formulas {
            symbols: &derived.symbols,
            ..self.formulas()
        }
    }

    /// The numbers of degrees of freedom and of noises.
    fn sizes(&self) -> [Literal; 2] {
        [self.model.dof(), self.model.noises.len()].map(Literal::usize_unsuffixed)
    }

    fn self_ty(&self) -> &'a Type {
        self.stepped
    }

    /// The type of the block.
    fn user_ty(&self) -> &'a Type {
        &self.block.item.self_ty
    }
}

/// Path of what generated code calls in the runtime.
fn private(block: &Annotated) -> TokenStream {
    let runtime = &block.arguments.runtime;
    quote!(#runtime::__private)
}

/// The type of a rule in the runtime: each option wraps the rule.
fn rule_type(rule: Rule, runtime: &TokenStream) -> TokenStream {
    let name = ident(rule.type_name);
    let stages = rule.stages().map(Literal::usize_unsuffixed);
    let stages = stages.map(|stages| quote!(<#stages>));
    rule.options
        .iter()
        .fold(quote!(#runtime::#name #stages), |wrapped, option| {
            let wrapper = ident(option.type_name());
            quote!(#runtime::#wrapper<#wrapped>)
        })
}

/// The value of a parameter. All tokens of the check that it is an `f64` have the place of the
/// parameter: the errors of all functions that read it are then equal, and the compiler of Rust
/// prints equal errors once.
fn number(access: &TokenStream, private: &TokenStream) -> TokenStream {
    let first = access.clone().into_iter().next();
    let at = first
        .map_or_else(Span::call_site, |token| token.span())
        .resolved_at(Span::call_site());
    let check = quote_spanned!(at=> #private::number).into_iter();
    let check: TokenStream = check.map(|token| placed(token, at)).collect();
    quote_spanned!(at=> #check(#access))
}

fn placed(mut token: TokenTree, at: Span) -> TokenTree {
    token.set_span(at);
    token
}

/// A name in generated code.
fn ident(name: &str) -> Ident {
    Ident::new(name, Span::call_site())
}

/// Doc comments, a line each: headings with formulas below. As text blocks these are neither
/// markdown nor tests.
fn documented(parts: &[(&str, &str)]) -> TokenStream {
    let mut tokens = TokenStream::new();
    let mut line = |text: &str| {
        let text = verbatim(&format!(" {text}"));
        tokens.extend(quote!(#[doc = #text]));
    };
    for (at, (heading, text)) in parts.iter().enumerate() {
        if at > 0 {
            line("");
        }
        line(heading);
        if !text.is_empty() {
            line("");
            line("```text");
            text.lines().for_each(&mut line);
            line("```");
        }
    }
    tokens
}

/// A string literal that is read as it is, also in the expansion: letters with bars stay letters.
fn verbatim(text: &str) -> Literal {
    let raw = format!("r\"{text}\"");
    raw.parse().unwrap_or_else(|_| Literal::string(text))
}

/// Attributes of every generated implementation. Generated arithmetic is not written to please a
/// reader's linter.
fn attributes() -> TokenStream {
    let allowed = allowed();
    quote! {
        #[automatically_derived]
        #allowed
    }
}

fn allowed() -> TokenStream {
    quote!(#[allow(unused_variables, clippy::all, clippy::pedantic, clippy::nursery)])
}
