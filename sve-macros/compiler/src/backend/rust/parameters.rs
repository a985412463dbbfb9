//! Derivatives by the parameters at a point, which the linearised step of a Gauss rule needs.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::Context;
use super::straight::Straight;
use crate::algebra::Expr;
use crate::discretise::stages::{ParameterJet, Stages};

/// `fn parameter_jets`.
pub(super) fn parameter_jets(
    context: &Context<'_>,
    stages: &Stages,
    private: &TokenStream,
) -> TokenStream {
    let (n, m) = (context.model.dof(), context.model.noises.len());
    let visits = stages.parameters.iter().map(|jet| {
        let ParameterJet {
            dq,
            dv,
            force,
            noise_dq,
            noise_dp,
        } = jet;
        let vectors = [dq.clone(), dv.clone()];
        let force = [force.clone()];
        let roots: Vec<Expr> = [&vectors[..], &force, noise_dq, noise_dp].concat().concat();
        let row = |name: &str, count: usize| vec![name.to_owned(); count];
        let matrices: [(&[Vec<Expr>], Vec<String>); 4] = [
            (&vectors, ["dq", "dv"].map(ToOwned::to_owned).to_vec()),
            (&force, row("force", 1)),
            (noise_dq, row("noise_dq", m)),
            (noise_dp, row("noise_dp", m)),
        ];
        let straight = Straight::new(context.arena, &stages.symbols, &roots);
        let (statements, arrays) = straight.finish(private, &matrices);
        let [vectors, force, noise_dq, noise_dp] = arrays.as_slice() else {
            return TokenStream::new();
        };
        let force = if jet.force.is_empty() {
            let n = Literal::usize_unsuffixed(n);
            quote!([[0f64; #n]])
        } else {
            force.clone()
        };
        quote! {{
            #statements
            let [dq, dv] = #vectors;
            let [force] = #force;
            visit(#private::gauss::ParameterJet { dq, dv, force, noise_dq: #noise_dq, noise_dp: #noise_dp });
        }}
    });
    let [n, m] = [n, m].map(Literal::usize_unsuffixed);
    quote! {
        fn parameter_jets(
            &self,
            time: f64,
            q: &[f64; #n],
            v: &[f64; #n],
            p: &[f64; #n],
            visit: &mut dyn ::core::ops::FnMut(#private::gauss::ParameterJet<#n, #m>),
        ) {
            #(#visits)*
        }
    }
}
