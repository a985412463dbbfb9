//! What is emitted after an error: implementations without bodies, so that no second-hand errors follow.
//!
//! Sizes come from the signatures, by the compiler where they are not literal.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};
use syn::{Expr, FnArg, ImplItem, ImplItemFn, ItemImpl, Lit, ReturnType, Type};

use crate::parse::{Arguments, is_f64};
use crate::rule::Rule;

/// Stubs for every rule that the attribute names.
pub(crate) fn stub(block: &ItemImpl, attribute: &TokenStream) -> TokenStream {
    let self_ty = &block.self_ty;
    let runtime = runtime(attribute);
    let private = quote!(#runtime::__private);
    let attributes = super::attributes();
    let (generics, _, clause) = block.generics.split_for_impl();
    let n = coordinates(block);
    let m = processes(block);
    let fail = quote!(::core::unreachable!("the macro reported an error"));
    let operations = quote!(#private::Operations { arithmetic: 0, transcendental: 0 });
    let plan = quote! {
        #private::Plan {
            system: "",
            rule: "",
            degrees_of_freedom: 0,
            noises: 0,
            blocks: &[],
            deterministic_order: 0,
            strong_order: #private::StrongOrder::Deterministic,
            prepare: #operations,
            step: #operations,
            iteration: #operations,
            formulas: #private::Formulas { system: "", motion: "", action: "", step: "" },
        }
    };
    let rules = rules(attribute).into_iter().map(|rule| {
        let rule = format_ident!("{}", rule.type_name());
        quote! {
            #attributes
            impl #generics #private::Variational<#runtime::#rule> for #self_ty #clause {
                type Prepared = ();
                const PLAN: &'static #private::Plan = &#plan;
                const RETURNS_STATE: bool = false;
                fn prepare(&self, h: f64) {}
                fn increment(
                    &self,
                    prepared: &(),
                    state: &#private::State<#n>,
                    h: f64,
                    dw: &[f64; #m],
                    newton: &#private::Newton,
                ) -> ::core::result::Result<([f64; #n], [f64; #n]), #private::SolveError> {
                    #fail
                }
            }
        }
    });
    quote! {
        #attributes
        impl #generics #private::System for #self_ty #clause {
            type Dims = #private::Dims<#n, #m>;
            const AFFINE_MOMENTUM: bool = true;
            fn lagrangian_jet(&self, time: f64, q: &[f64; #n], v: &[f64; #n]) -> #private::LagrangianJet<#n> { #fail }
            fn noise_jets(&self, time: f64, q: &[f64; #n], p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] { #fail }
        }
        #(#rules)*
    }
}

/// The rules that the attribute names; all of them where it has a mistake, since any may have been meant.
fn rules(attribute: &TokenStream) -> Vec<Rule> {
    match syn::parse2::<Arguments>(attribute.clone()) {
        Ok(arguments) => arguments.rules.iter().map(|(rule, _)| *rule).collect(),
        Err(_) => Rule::ALL.to_vec(),
    }
}

/// The path after `crate =`, or the usual one.
fn runtime(attribute: &TokenStream) -> TokenStream {
    let mut tokens = attribute
        .clone()
        .into_iter()
        .skip_while(|t| t.to_string() != "crate")
        .skip(2);
    let path: TokenStream = tokens
        .by_ref()
        .take_while(|t| t.to_string() != ",")
        .collect();
    match syn::parse2::<syn::Path>(path) {
        Ok(path) => quote!(#path),
        Err(_) => quote!(::sve_runtime),
    }
}

fn functions(block: &ItemImpl) -> impl Iterator<Item = &ImplItemFn> {
    block.items.iter().filter_map(|item| match item {
        ImplItem::Fn(function) => Some(function),
        _ => None,
    })
}

fn coordinates(block: &ItemImpl) -> TokenStream {
    let last = functions(block)
        .find(|f| f.sig.ident == "lagrangian")
        .and_then(|f| f.sig.inputs.last());
    match last {
        Some(FnArg::Typed(argument)) => size(&[&argument.ty]),
        _ => quote!(1),
    }
}

fn processes(block: &ItemImpl) -> TokenStream {
    let is_noise = |f: &&ImplItemFn| {
        f.attrs
            .iter()
            .any(|a| a.path().is_ident("gamma") || a.path().is_ident("h1"))
    };
    let outputs: Vec<&Type> = functions(block)
        .filter(is_noise)
        .filter_map(|f| match &f.sig.output {
            ReturnType::Type(_, ty) => Some(&**ty),
            ReturnType::Default => None,
        })
        .collect();
    size(&outputs)
}

/// Numbers in some types, as a constant argument.
fn size(types: &[&Type]) -> TokenStream {
    let literal: Option<usize> = types.iter().map(|ty| entries(ty)).sum();
    if let Some(n) = literal {
        let n = Literal::usize_unsuffixed(n);
        return quote!(#n);
    }
    let types = types.iter().map(|ty| match ty {
        Type::Reference(reference) => &*reference.elem,
        other => *other,
    });
    quote!({ #(::core::mem::size_of::<#types>() / ::core::mem::size_of::<f64>())+* })
}

/// Numbers in a type with literal lengths.
fn entries(ty: &Type) -> Option<usize> {
    match ty {
        Type::Array(array) => match &array.len {
            Expr::Lit(length) => match &length.lit {
                Lit::Int(n) => n
                    .base10_parse::<usize>()
                    .ok()?
                    .checked_mul(entries(&array.elem)?),
                _ => None,
            },
            _ => None,
        },
        _ => is_f64(ty).then_some(1),
    }
}
