//! `impl StageBounds`: bounds of the derivatives at a node, by which the Gauss rules judge
//! solutions.

use proc_macro2::TokenStream;
use quote::quote;

use super::function::{Formulas, Printed, record};
use super::{Context, attributes, ident};
use crate::algebra::Expr;
use crate::discretise::node_bounds::{NodeBounds, NoiseBounds, Uniqueness};
use crate::discretise::stages::Stages;
use crate::program::Array;

/// Prints the implementation.
pub(super) fn node_bounds(context: &Context<'_>, stages: &Stages) -> TokenStream {
    let (private, attributes) = (context.private, attributes());
    let (self_ty, [n, m]) = (context.self_ty(), context.sizes());
    let (kind, bounds) = match &stages.uniqueness {
        Uniqueness::Linear => (quote!(Linear), None),
        Uniqueness::Bounded(bounds) => (quote!(Bounded), Some(bounds)),
        Uniqueness::Unknown => (quote!(Unknown), None),
    };
    let function = bounds.map(|bounds| {
        let formulas = Formulas {
            symbols: &stages.symbols,
            ..context.formulas()
        };
        let body = body(bounds, formulas);
        quote! {
            #[inline]
            fn bounds(
                &self,
                time: f64,
                [q, v, p]: [&[f64; #n]; 3],
                radii: &#private::gauss::Radii<#n>,
            ) -> #private::gauss::NodeBounds<#n, #m> {
                #body
            }
        }
    });
    quote! {
        #attributes
        impl #private::gauss::StageBounds<#n, #m> for #self_ty {
            const UNIQUENESS: #private::gauss::Uniqueness = #private::gauss::Uniqueness::#kind;
            #function
        }
    }
}

/// The fields of the bounds of L and of the force, and of the bounds of a noise.
const OF_MOTION: [&str; 9] = [
    "momentum_by_time",
    "momentum_by_time_radius",
    "force_by_time",
    "mass",
    "mass_radius",
    "momentum_by_position",
    "momentum_by_position_radius",
    "force_by_position",
    "force_by_velocity",
];
const OF_NOISE: [&str; 8] = [
    "against",
    "dp",
    "against_t",
    "dpt",
    "against_q",
    "dqp",
    "dpp",
    "force_v",
];

fn body(bounds: &NodeBounds, formulas: Formulas<'_>) -> TokenStream {
    let NodeBounds {
        mass: [mass, mass_radius],
        momentum_by_time: [by_time, by_time_radius],
        momentum_by_position: [by_position, by_position_radius],
        force: (force_by_time, [force_by_position, force_by_velocity]),
        noises,
        conditions,
    } = bounds;
    let vectors = [by_time, by_time_radius, force_by_time];
    let matrices = [
        mass,
        mass_radius,
        by_position,
        by_position_radius,
        force_by_position,
        force_by_velocity,
    ];
    let (of_vectors, of_matrices) = OF_MOTION.split_at(vectors.len());
    let vectors = of_vectors.iter().zip(vectors);
    let matrices = of_matrices.iter().zip(matrices);
    let mut arrays: Vec<Array<Expr>> = vectors
        .map(|(name, vector)| Array::vector(name, vector))
        .collect();
    arrays.extend(matrices.map(|(name, matrix)| Array::rows(name, matrix)));
    for (at, NoiseBounds { vectors, matrices }) in noises.iter().enumerate() {
        let (of_vectors, of_matrices) = OF_NOISE.split_at(vectors.len());
        let name = |field: &str| format!("noise_{at}_{field}");
        let vectors = of_vectors.iter().zip(vectors);
        arrays.extend(vectors.map(|(field, vector)| Array::vector(&name(field), vector)));
        let matrices = of_matrices.iter().zip(matrices);
        arrays.extend(matrices.map(|(field, matrix)| Array::rows(&name(field), matrix)));
    }
    arrays.push(Array::vector("left", conditions));
    let private = formulas.private;
    let Printed {
        statements, arrays, ..
    } = formulas.list(&arrays);
    let (of_motion, rest) = arrays.split_at(OF_MOTION.len());
    let (of_noises, conditions) = rest.split_at(OF_NOISE.len() * noises.len());
    let noises = of_noises.chunks(OF_NOISE.len());
    let noises =
        noises.map(|noise| record(&quote!(#private::gauss::NoiseBounds), &OF_NOISE, noise));
    let fields = OF_MOTION.map(ident);
    quote! {
        #statements
        #private::gauss::NodeBounds {
            #(#fields: #of_motion,)*
            noises: [#(#noises),*],
            hold: #private::all_positive(&#(#conditions)*),
        }
    }
}
