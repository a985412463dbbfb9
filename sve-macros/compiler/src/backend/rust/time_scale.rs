//! The time scale of a system: its value at a state, and the nodes of a step at which the time
//! passes.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::Type;

use super::configuration::configuration;
use super::{Context, attributes};
use crate::catalogue::{Nodes, Rule};
use crate::program::Array;

/// `impl TimeScale`, for a system that has one.
pub(super) fn time_scale(context: &Context<'_>) -> Option<TokenStream> {
    let Context {
        block,
        model,
        private,
        ..
    } = *context;
    let scale = Array::number("scale", model.time_scale?);
    let (statements, [scale]) = context.formulas().arrays(&[scale]);
    let [n, _] = context.sizes();
    let configuration = configuration(block, &n, private);
    let body = quote! {
        let #private::State { t: time, q, p } = #private::in_coordinates::<_, #n>(state);
        #statements
        #scale
    };
    let self_ty = context.self_ty();
    Some(implementation(self_ty, &configuration, private, &body))
}

pub(super) fn implementation(
    self_ty: &Type,
    configuration: &TokenStream,
    private: &TokenStream,
    body: &TokenStream,
) -> TokenStream {
    let attributes = attributes();
    quote! {
        #attributes
        impl #private::TimeScale for #self_ty {
            #[inline]
            fn time_scale(&self, state: &#private::State<#configuration>) -> f64 { #body }
        }
    }
}

/// `nodes` of a step by a rule, for a system with a time scale: the derivative of the action by the
/// energy is the time of a step, the sum of the time scale at the nodes with these weights.
pub(super) fn nodes(context: &Context<'_>, rule: Rule) -> Option<TokenStream> {
    let (model, private) = (context.model, context.private);
    model.time_scale?;
    let body = match rule.stages() {
        Some(stages) => {
            let sizes = [stages, model.dof()].map(Literal::usize_unsuffixed);
            let [s, n] = &sizes;
            quote!(#private::gauss::nodes::<#s, #n, _>(&start.q, h, unknowns, visit))
        }
        None => {
            let pairs = nodes_between(rule).into_iter().map(|(weight, place)| {
                let [weight, place] = [weight, place].map(Literal::f64_suffixed);
                quote!((#weight, #place))
            });
            quote!(#private::nodes_between(&start.q, &end.q, &[#(#pairs),*], visit))
        }
    };
    Some(quote! {
        #[inline]
        fn nodes(
            &self,
            start: &#private::FlatStateOf<Self>,
            end: &#private::FlatStateOf<Self>,
            h: f64,
            unknowns: &Self::Unknowns,
            visit: &mut dyn ::core::ops::FnMut(f64, &#private::FlatOf<Self>),
        ) {
            #body
        }
    })
}

/// The nodes between the ends of a step: each with its weight, and its place as a fraction of the
/// displacement.
pub(crate) fn nodes_between(rule: Rule) -> Vec<(f64, f64)> {
    match rule.nodes {
        Nodes::One { c } => vec![(1.0, c)],
        Nodes::Ends => vec![(0.5, 0.0), (0.5, 1.0)],
        Nodes::Gauss { .. } | Nodes::Taylor => Vec::new(),
    }
}
