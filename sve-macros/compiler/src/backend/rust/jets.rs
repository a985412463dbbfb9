//! Functions that return the derivatives of L, of the noises, of the force and of the constraints
//! at a point.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::configuration::Received;
use super::function::{Formulas, record};
use super::{Context, attributes};
use crate::algebra::Expr;
use crate::discretise::stages::{ParameterJet, Stages};
use crate::program::Array;
use crate::system::functions::Functions;
use crate::system::mechanics::{ConstraintJet, ForceJet, LagrangianJet, NoiseJet};

/// The body of `lagrangian_jet`.
pub(super) fn lagrangian_jet(jet: &LagrangianJet, formulas: Formulas<'_>) -> TokenStream {
    let (statements, arrays) = formulas.arrays(&[
        Array::number("lagrangian", jet.value),
        Array::vector("dq", &jet.dq),
        Array::vector("dv", &jet.dv),
        Array::vector("dqt", &jet.dqt),
        Array::vector("dvt", &jet.dvt),
        Array::rows("dqq", &jet.dqq),
        Array::rows("dqv", &jet.dqv),
        Array::rows("dvv", &jet.dvv),
    ]);
    let private = formulas.private;
    let fields = ["value", "dq", "dv", "dqt", "dvt", "dqq", "dqv", "dvv"];
    let jet = record(&quote!(#private::LagrangianJet), &fields, &arrays);
    quote!(#statements #jet)
}

/// The body of `noise_jets`.
pub(super) fn noise_jets(jets: &[NoiseJet], formulas: Formulas<'_>) -> TokenStream {
    let fields = ["dq", "dp", "dqq", "dqp", "dpp"];
    let arrays = jets.iter().enumerate().flat_map(|(at, jet)| {
        let [dq, dp, dqq, dqp, dpp] = fields.map(|field| format!("noise_{at}_{field}"));
        [
            Array::vector(&dq, &jet.dq),
            Array::vector(&dp, &jet.dp),
            Array::rows(&dqq, &jet.dqq),
            Array::rows(&dqp, &jet.dqp),
            Array::rows(&dpp, &jet.dpp),
        ]
    });
    let printed = formulas.list(&arrays.collect::<Vec<_>>());
    let (statements, private) = (printed.statements, formulas.private);
    let jets = printed.arrays.chunks(fields.len());
    let jets = jets.map(|jet| record(&quote!(#private::NoiseJet), &fields, jet));
    quote!(#statements [#(#jets),*])
}

/// The fields of a force jet.
const FORCE: [&str; 4] = ["value", "dt", "dq", "dv"];

/// Returns the arrays of a force jet with these names, in the order of [`FORCE`].
fn force_arrays(jet: &ForceJet, names: [&str; 4]) -> [Array<Expr>; 4] {
    let [value, dt, dq, dv] = names;
    [
        Array::vector(value, &jet.value),
        Array::vector(dt, &jet.dt),
        Array::rows(dq, &jet.dq),
        Array::rows(dv, &jet.dv),
    ]
}

/// `NOISE_FORCED`, `NOISE_READS_VELOCITY` and `noise_force_jets`; nothing without forces of noises.
pub(super) fn noise_force_jets(
    jets: &[NoiseJet],
    Received { flat, open, .. }: &Received,
    [n, m]: [&Literal; 2],
    formulas: Formulas<'_>,
) -> Option<TokenStream> {
    let reads_velocity = jets.iter().any(|jet| jet.reads_velocity);
    let jets = noise_forces(jets, formulas)?;
    let private = formulas.private;
    Some(quote! {
        const NOISE_FORCED: bool = true;
        const NOISE_READS_VELOCITY: bool = #reads_velocity;
        #[inline]
        fn noise_force_jets(&self, time: f64, q: &#flat, v: &[f64; #n]) -> [#private::ForceJet<#n>; #m] {
            #open
            #jets
        }
    })
}

/// The body of `noise_force_jets`; `None` if no noise has a force.
fn noise_forces(jets: &[NoiseJet], formulas: Formulas<'_>) -> Option<TokenStream> {
    let private = formulas.private;
    let arrays = jets.iter().enumerate().filter_map(|(at, jet)| {
        let names = FORCE.map(|field| format!("noise_{at}_{field}"));
        let names = names.each_ref().map(String::as_str);
        jet.force.as_ref().map(|force| force_arrays(force, names))
    });
    let arrays: Vec<Array<Expr>> = arrays.flatten().collect();
    if arrays.is_empty() {
        return None;
    }
    let printed = formulas.list(&arrays);
    let statements = printed.statements;
    let mut given = printed.arrays.chunks(FORCE.len());
    let jets = jets.iter().map(|jet| match &jet.force {
        Some(_) => {
            let arrays = given.next().unwrap_or_default();
            record(&quote!(#private::ForceJet), &FORCE, arrays)
        }
        None => quote!(#private::ForceJet::NONE),
    });
    Some(quote!(#statements [#(#jets),*]))
}

/// `FORCED` and `force_jet`.
pub(super) fn force_jet(
    jet: &ForceJet,
    Received { flat, open, .. }: &Received,
    formulas: Formulas<'_>,
) -> TokenStream {
    let (statements, arrays) = formulas.arrays(&force_arrays(jet, ["force", "dt", "dq", "dv"]));
    let (private, n) = (formulas.private, Literal::usize_unsuffixed(jet.value.len()));
    let jet = record(&quote!(#private::ForceJet), &FORCE, &arrays);
    quote! {
        const FORCED: bool = true;
        #[inline]
        fn force_jet(&self, time: f64, q: &#flat, v: &[f64; #n]) -> #private::ForceJet<#n> {
            #open
            #statements
            #jet
        }
    }
}

/// `CONSTRAINTS`, `constraint_jets` and `constraint_curvatures`; nothing where there are none.
pub(super) fn constraint_jets(context: &Context<'_>, functions: &Functions) -> Option<TokenStream> {
    let jets = &functions.mechanics.constraints;
    if jets.is_empty() {
        return None;
    }
    let (formulas, private) = (context.formulas(), context.private);
    let row = |of: fn(&ConstraintJet) -> Expr| jets.iter().map(of).collect::<Vec<Expr>>();
    let slopes: Vec<Vec<Expr>> = jets.iter().map(|jet| jet.dq.clone()).collect();
    let (statements, [values, magnitudes, dt, slopes]) = formulas.arrays(&[
        Array::vector("value", &row(|j| j.value)),
        Array::vector("magnitude", &row(|j| j.magnitude)),
        Array::vector("dt", &row(|j| j.dt)),
        Array::rows("dq", &slopes),
    ]);
    let curvatures = Array::vector("curvature", &functions.constraint_curvatures);
    let (of_curvatures, [curvatures]) = formulas.arrays(&[curvatures]);
    let names = context.model.constraints.iter();
    let names = names.map(|constraint| &constraint.name);
    let [n, _] = context.sizes();
    let count = Literal::usize_unsuffixed(jets.len());
    Some(quote! {
        const CONSTRAINTS: &'static [&'static str] = &[#(#names),*];
        fn constraint_jets(
            &self,
            time: f64,
            q: &[f64; #n],
            visit: &mut dyn ::core::ops::FnMut(#private::ConstraintJet<#n>),
        ) {
            #statements
            let (values, magnitudes, dt, dq) = (#values, #magnitudes, #dt, #slopes);
            for k in 0..#count {
                visit(#private::ConstraintJet {
                    value: values[k],
                    magnitude: magnitudes[k],
                    dt: dt[k],
                    dq: dq[k],
                });
            }
        }
        fn constraint_curvatures(
            &self,
            time: f64,
            q: &[f64; #n],
            v: &[f64; #n],
            visit: &mut dyn ::core::ops::FnMut(f64),
        ) {
            #of_curvatures
            for curvature in #curvatures {
                visit(curvature);
            }
        }
    })
}

/// `impl WithPotential`, of a context whose last noise is the potential of the option `weak2`.
pub(super) fn with_potential(context: &Context<'_>) -> TokenStream {
    let (private, attributes) = (context.private, attributes());
    let (self_ty, [n, m]) = (context.self_ty(), context.sizes());
    let noises = &context.mechanics.noises;
    let jets = noise_jets(noises, context.formulas());
    let forces = noise_forces(noises, context.formulas()).map(|forces| {
        quote! {
            const NOISE_FORCED: bool = true;
            fn noise_force_jets(&self, time: f64, q: &[f64; #n], v: &[f64; #n]) -> [#private::ForceJet<#n>; #m] {
                #forces
            }
        }
    });
    quote! {
        #attributes
        impl #private::gauss::WithPotential<#n, #m> for #self_ty {
            fn noise_jets(&self, time: f64, q: &[f64; #n], p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] {
                #jets
            }
            #forces
        }
    }
}

/// `fn parameter_jets`: derivatives by the parameters at a point, which the linearised step of a
/// Gauss rule needs.
pub(super) fn parameter_jets(context: &Context<'_>, stages: &Stages) -> TokenStream {
    let (private, [n, m]) = (context.private, context.sizes());
    let formulas = Formulas {
        symbols: &stages.symbols,
        ..context.formulas()
    };
    let visits = stages.parameters.iter().map(|jet: &ParameterJet| {
        let (statements, mut arrays) = formulas.arrays(&[
            Array::vector("dq", &jet.dq),
            Array::vector("dv", &jet.dv),
            Array::vector("force", &jet.force),
            Array::rows("noise_against", &jet.noise_against),
            Array::rows("noise_dp", &jet.noise_dp),
        ]);
        if jet.force.is_empty() {
            arrays[2] = quote!([0f64; #n]);
        }
        let fields = ["dq", "dv", "force", "noise_against", "noise_dp"];
        let jet = record(&quote!(#private::gauss::ParameterJet), &fields, &arrays);
        quote!({ #statements visit(#jet); })
    });
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
