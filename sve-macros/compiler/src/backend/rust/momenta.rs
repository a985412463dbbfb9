//! An inherent function for the momentum of each symmetry.

use proc_macro2::TokenStream;
use quote::quote;

use super::configuration::{Received, configuration, received};
use super::{Context, attributes, momentum_name};
use crate::algebra::Vanishing;
use crate::explain;
use crate::program::Array;
use crate::system::symmetry::MomentumMap;

/// Longest formula that is worth reading, in characters.
const READABLE: usize = 600;

pub(crate) fn momenta(context: &Context<'_>) -> TokenStream {
    let Context {
        block,
        model,
        momenta,
        private,
        ..
    } = *context;
    if momenta.is_empty() {
        return TokenStream::new();
    }
    let (self_ty, [n, _], attributes) = (context.user_ty(), context.sizes(), attributes());
    let configuration = configuration(block, &n, private);
    let Received { open, .. } = received(block, model, private);
    let functions = block.symmetries.iter().zip(momenta).map(|(part, map)| {
        let MomentumMap {
            name,
            value,
            is_affine,
            evidence,
        } = map;
        let function = momentum_name(&part.name);
        let visibility = &part.item.vis;
        let value = Array::number("momentum", *value);
        let (statements, [momentum]) = context.formulas().arrays(&[value]);
        let formula = model.symbols.formula(map.value, READABLE, context.arena);
        let formula = formula.map(|formula| format!("⟨p, ξ⟩ = {formula}"));
        let doc = doc(name, formula.as_deref(), *is_affine, *evidence);
        quote! {
            #[doc = #doc]
            #[must_use]
            #[inline]
            #visibility fn #function(&self, state: &#private::State<#configuration>) -> f64 {
                let #private::State { t: time, q, p } = #private::in_coordinates::<_, #n>(state);
                #open
                #statements
                #momentum
            }
        }
    });
    quote! {
        #attributes
        #[allow(dead_code)]
        impl #self_ty {
            #(#functions)*
        }
    }
}

/// Returns the documentation of a function of a momentum.
pub(super) fn doc(
    name: &str,
    formula: Option<&str>,
    is_affine: bool,
    evidence: Vanishing,
) -> String {
    let steps = if is_affine {
        "by the motion and by every step"
    } else {
        "by the motion; by steps only to their accuracy, for the symmetry is not affine in q"
    };
    let formula = formula
        .map(|formula| format!("\n\n```text\n{formula}\n```"))
        .unwrap_or_default();
    let caveat = explain::symmetry_caveat(evidence)
        .map(|caveat| format!(" The symmetry is {caveat}."))
        .unwrap_or_default();
    format!("The momentum of the symmetry `{name}`, conserved {steps}.{caveat}{formula}")
}
