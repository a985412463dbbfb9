//! Functions beside a step for what is rarely computed: the second guess of an iteration, its
//! rounding errors, the full bounds of its root.
//!
//! Such a function begins with nothing known but the start of the step and the unknowns that its
//! formulas contain.

use std::cell::RefCell;
use std::collections::BTreeSet;

use proc_macro2::{Group, Ident, Literal, TokenStream, TokenTree};
use quote::{format_ident, quote};
use syn::Type;

use super::configuration::Received;
use super::function::Formulas;
use super::ident;
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;
use crate::program::symbol_name;

/// The functions beside a step.
pub(super) struct Cold<'a> {
    pub(super) formulas: Formulas<'a>,
    pub(super) self_ty: &'a Type,
    pub(super) received: &'a Received,
    pub(super) noises: Literal,
    pub(super) functions: RefCell<Vec<TokenStream>>,
}

impl Cold<'_> {
    /// Declares a function for a block, with the formulas that it computes and the symbols that its
    /// body binds. Returns the call.
    pub(super) fn function(
        &self,
        (name, block): (&str, usize),
        (formulas, bound): (&[Expr], &[Symbol]),
        (output, body): (&TokenStream, &TokenStream),
    ) -> TokenStream {
        let Formulas {
            arena,
            symbols,
            private,
        } = self.formulas;
        let is_unknown =
            |s: &Symbol| matches!(symbols.meaning(*s), Meaning::Unknown(_) | Meaning::Limit(_));
        let contained = formulas.iter().flat_map(|&e| arena.symbols_of(e));
        let contained: BTreeSet<Symbol> = contained.collect();
        let unknowns = contained
            .iter()
            .filter(|s| is_unknown(s) && !bound.contains(s));
        let unknowns = unknowns.map(|&s| ident(&symbol_name(symbols, s)));
        let unknowns: Vec<Ident> = unknowns.collect();
        let contains = |is_meant: fn(&Meaning) -> bool| {
            contained.iter().any(|&s| is_meant(symbols.meaning(s)))
        };
        let time = contains(|meaning| matches!(meaning, Meaning::Time));
        let time = time.then(|| quote!(let time = state.t;));
        let noise = contains(|meaning| matches!(meaning, Meaning::Wiener(_)));
        let (dw, m) = (noise.then(|| quote!(dw,)), &self.noises);
        let noise = noise.then(|| quote!(dw: &[f64; #m],));
        let Received {
            flat,
            open_state,
            start,
            ..
        } = self.received;
        let (name, self_ty) = (format_ident!("{name}_{block}"), self.self_ty);
        let body = of_argument(body.clone());
        self.functions.borrow_mut().push(quote! {
            #[cold]
            #[inline(never)]
            fn #name(
                system: &#self_ty,
                state: &#private::State<#flat>,
                h: f64,
                #noise
                #(#unknowns: f64,)*
            ) -> #output {
                #open_state
                #time
                #body
            }
        });
        quote!(#name(self, #start, h, #dw #(#unknowns),*))
    }
}

/// The same code in a function that is no method.
fn of_argument(code: TokenStream) -> TokenStream {
    let tree = |tree| match tree {
        TokenTree::Ident(word) if word == "self" => Ident::new("system", word.span()).into(),
        TokenTree::Group(group) => {
            let mut renamed = Group::new(group.delimiter(), of_argument(group.stream()));
            renamed.set_span(group.span());
            renamed.into()
        }
        other => other,
    };
    code.into_iter().map(tree).collect()
}
