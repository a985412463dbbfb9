//! An inherent function for the momentum of each symmetry.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::configuration::{Received, configuration, received};
use super::straight::Straight;
use super::{attributes, momentum_name, private};
use crate::algebra::{Arena, Vanishing};
use crate::explain;
use crate::model::Model;
use crate::syntax::parse::Annotated;
use crate::system::symmetry::MomentumMap;

/// Longest formula that is worth reading, in characters.
const READABLE: usize = 600;

pub(crate) fn momenta(
    block: &Annotated,
    model: &Model,
    momenta: &[MomentumMap],
    arena: &Arena,
) -> TokenStream {
    if momenta.is_empty() {
        return TokenStream::new();
    }
    let (private, attributes) = (private(block), attributes());
    let self_ty = &block.item.self_ty;
    let n = Literal::usize_unsuffixed(model.dof());
    let configuration = configuration(block, &n, &private);
    let Received {
        flat: _,
        open,
        open_state: _,
        reopen_state: _,
    } = received(block, model, &private);
    let functions = block.symmetries.iter().zip(momenta).map(|(part, map)| {
        let MomentumMap {
            name,
            value,
            is_affine,
            evidence,
        } = map;
        let function = momentum_name(&part.name);
        let visibility = &part.item.vis;
        let (statements, values) = Straight::new(arena, &model.symbols, &[*value])
            .finish(&private, &[(&[vec![*value]], vec!["momentum".to_owned()])]);
        let formula = model.symbols.formula(*value, READABLE, arena);
        let doc = doc(name, formula.as_deref(), *is_affine, *evidence);
        quote! {
            #[doc = #doc]
            #[must_use]
            #[inline]
            #visibility fn #function(&self, state: &#private::State<#configuration>) -> f64 {
                let #private::State { t: time, q, p } = #private::in_coordinates::<_, #n>(state);
                #open
                #statements
                let [[momentum]] = #(#values)*;
                momentum
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

fn doc(name: &str, formula: Option<&str>, is_affine: bool, evidence: Vanishing) -> String {
    let steps = if is_affine {
        "by the motion and by every step"
    } else {
        "by the motion; by steps only to their accuracy, for the symmetry is not affine in q"
    };
    let formula = formula
        .map(|formula| format!("\n\n```text\n⟨p, ξ⟩ = {formula}\n```"))
        .unwrap_or_default();
    let caveat = explain::symmetry_caveat(evidence)
        .map(|caveat| format!(" The symmetry is {caveat}."))
        .unwrap_or_default();
    format!("The momentum of the symmetry `{name}`, conserved {steps}.{caveat}{formula}")
}
