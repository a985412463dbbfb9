//! `impl StageBounds`: bounds of the derivatives at a node, by which the Gauss rules judge solutions.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::straight::{Named, Straight, rows};
use super::{Context, attributes};
use crate::algebra::Expr;
use crate::discretise::node_bounds::{NodeBounds, NoiseBounds, Uniqueness};
use crate::model::Symbols;

/// Prints the implementation.
pub(super) fn node_bounds(
    context: &Context<'_>,
    symbols: &Symbols,
    uniqueness: &Uniqueness,
    private: &TokenStream,
) -> TokenStream {
    let attributes = attributes();
    let self_ty = &context.block.item.self_ty;
    let sizes = [context.model.dof(), context.model.noises.len()];
    let [n, m] = sizes.map(Literal::usize_unsuffixed);
    let (kind, bounds) = match uniqueness {
        Uniqueness::Linear => (quote!(Linear), None),
        Uniqueness::Bounded(bounds) => (quote!(Bounded), Some(bounds)),
        Uniqueness::Unknown => (quote!(Unknown), None),
    };
    let function = bounds.map(|bounds| {
        let body = body(context, symbols, bounds, private);
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

fn body(
    context: &Context<'_>,
    symbols: &Symbols,
    bounds: &NodeBounds,
    private: &TokenStream,
) -> TokenStream {
    let NodeBounds {
        mass: [mass, mass_radius],
        momentum_by_time: [momentum_by_time, momentum_by_time_radius],
        momentum_by_position: [momentum_by_position, momentum_by_position_radius],
        force: (force_by_time, [force_by_position, force_by_velocity]),
        noises,
        conditions,
    } = bounds;
    let n = mass.len();
    let vectors = [momentum_by_time, momentum_by_time_radius, force_by_time].map(Clone::clone);
    let names = [
        "momentum_by_time",
        "momentum_by_time_radius",
        "force_by_time",
    ];
    let mut parts: Vec<Named<Vec<Vec<Expr>>>> =
        vec![(vectors.to_vec(), names.map(ToOwned::to_owned).to_vec())];
    let matrices = [
        (mass, "mass"),
        (mass_radius, "mass_radius"),
        (momentum_by_position, "momentum_by_position"),
        (momentum_by_position_radius, "momentum_by_position_radius"),
        (force_by_position, "force_by_position"),
        (force_by_velocity, "force_by_velocity"),
    ];
    parts.extend(matrices.map(|(matrix, name)| (matrix.clone(), rows(name, n))));
    for (at, NoiseBounds { vectors, matrices }) in noises.iter().enumerate() {
        let name = |part: &str| format!("noise_{at}_{part}");
        parts.push((
            vectors.to_vec(),
            ["dq", "dp", "dqt", "dpt"].map(name).to_vec(),
        ));
        for (matrix, part) in matrices.iter().zip(["dqq", "dqp", "dpp"]) {
            parts.push((matrix.clone(), rows(&name(part), n)));
        }
    }
    parts.push((vec![conditions.clone()], vec!["left".to_owned()]));
    let roots: Vec<Expr> = parts.iter().flat_map(|part| part.0.concat()).collect();
    let views = parts
        .iter()
        .map(|(part, names)| (part.as_slice(), names.clone()));
    let views: Vec<Named<&[Vec<Expr>]>> = views.collect();
    let (statements, arrays) =
        Straight::new(context.arena, symbols, &roots).finish(private, &views);
    let [
        vectors,
        mass,
        mass_radius,
        momentum,
        momentum_radius,
        force_by_position,
        force_by_velocity,
        noises @ ..,
        conditions,
    ] = arrays.as_slice()
    else {
        return TokenStream::new();
    };
    let noises = noises.chunks(4).map(|chunk| {
        let (vectors, dqq, dqp, dpp) = (&chunk[0], &chunk[1], &chunk[2], &chunk[3]);
        quote! {{
            let [dq, dp, dqt, dpt] = #vectors;
            #private::gauss::NoiseBounds { dq, dp, dqt, dpt, dqq: #dqq, dqp: #dqp, dpp: #dpp }
        }}
    });
    quote! {
        #statements
        let [momentum_by_time, momentum_by_time_radius, force_by_time] = #vectors;
        let [conditions] = #conditions;
        #private::gauss::NodeBounds {
            mass: #mass,
            mass_radius: #mass_radius,
            momentum_by_time,
            momentum_by_time_radius,
            momentum_by_position: #momentum,
            momentum_by_position_radius: #momentum_radius,
            force_by_time,
            force_by_position: #force_by_position,
            force_by_velocity: #force_by_velocity,
            noises: [#(#noises),*],
            hold: #private::all_positive(&conditions),
        }
    }
}
