//! `impl System`: the derivatives of L and of the noises.

use proc_macro2::{Literal, Span, TokenStream};
use quote::{quote, quote_spanned};

use super::configuration::{Received, received, written};
use super::energy::energy_lanes;
use super::euler::{euler_increment, no_euler};
use super::identity::identity;
use super::jets::{constraint_jets, force_jet, lagrangian_jet, noise_jets};
use super::{Context, attributes, documented};
use crate::explain::SystemTexts;
use crate::system::degeneracy::{Degeneracy, Role};
use crate::system::functions::Functions;
use crate::system::mechanics::Mechanics;

pub(crate) fn system(context: &Context<'_>, functions: &Functions) -> TokenStream {
    let Context {
        settings,
        block,
        model,
        about,
        private,
        ..
    } = *context;
    let attributes = attributes();
    let (self_ty, [n, m]) = (context.self_ty(), context.sizes());
    let formulas = context.formulas();
    let Mechanics {
        lagrangian,
        noises,
        force,
        affine_momentum,
        ..
    } = &functions.mechanics;
    let markers = markers(context, &functions.mechanics, &private);
    let [doc, jet_doc, noise_doc] = documentation(about, !noises.is_empty());
    let configuration = written(block, private).map(|ty| quote!(, #ty));
    let received = received(block, model, private);
    let Received { flat, open, .. } = &received;
    let lagrangian_body = lagrangian_jet(lagrangian, formulas);
    let noise_body = noise_jets(noises, formulas);
    let force = force.as_ref();
    let force = force.map(|jet| force_jet(jet, &received, formulas));
    let energy = functions.energy.as_ref();
    let energy = energy.and_then(|energy| energy_lanes(energy, context));
    let euler = functions.euler.as_ref();
    let euler = euler.and_then(|euler| euler_increment(euler, settings.lanes, context));
    let euler = euler.unwrap_or_else(no_euler);
    let constraint_jets = constraint_jets(context, functions);
    let identity = identity(model, context.arena, private);
    let roles = context.degeneracy.map(|d| roles(d, private));
    let parameters = model.symbols.parameters().map(|s| model.symbols.source(s));
    let (coordinates, momenta) = (&model.names.configuration, &model.names.momenta);
    // the user's functions are not called by what is derived from them, and yet are not dead
    let parts = [
        &block.noises,
        &block.forces,
        &block.symmetries,
        &block.constraints,
    ];
    let functions = parts.into_iter().flatten().chain([&block.lagrangian]);
    let functions = functions.map(|part| &part.name);
    let constants = model
        .constants
        .iter()
        .map(|(path, value)| constant_check(path, *value));
    quote! {
        #attributes
        const _: () = { #(let _ = <#self_ty>::#functions;)* };
        #(#constants)*
        #doc
        #attributes
        impl #private::System for #self_ty {
            type Dims = #private::Dims<#n, #m #configuration>;
            type Itself = Self;
            const AFFINE_MOMENTUM: bool = #affine_momentum;
            #roles
            const PARAMETERS: &'static [&'static str] = &[#(#parameters),*];
            const COORDINATES: &'static [&'static str] = &[#(#coordinates),*];
            const MOMENTA: &'static [&'static str] = &[#(#momenta),*];
            #identity
            #[inline]
            fn itself(&self) -> &Self { self }
            #jet_doc
            #[inline]
            fn lagrangian_jet(&self, time: f64, q: &#flat, v: &[f64; #n]) -> #private::LagrangianJet<#n> {
                #open
                #lagrangian_body
            }
            #noise_doc
            #[inline]
            fn noise_jets(&self, time: f64, q: &#flat, p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] {
                #open
                #noise_body
            }
            #force
            #constraint_jets
            #energy
            #euler
        }
        #markers
    }
}

/// Which splittings the structure of L allows.
fn markers(
    context: &Context<'_>,
    mechanics: &Mechanics,
    private: &TokenStream,
) -> Option<TokenStream> {
    let self_ty = &context.block.item.self_ty;
    if !mechanics.is_separable || context.degeneracy.is_some() {
        return None;
    }
    // conditions of order for the splitting of a quadratic kinetic energy do not hold for steps that constraints couple
    let is_quadratic = mechanics.affine_momentum && mechanics.constraints.is_empty();
    let quadratic =
        is_quadratic.then(|| quote!(impl #private::QuadraticKineticEnergy for #self_ty {}));
    Some(quote!(impl #private::Separable for #self_ty {} #quadratic))
}

/// `ROLES`, how the velocity of each coordinate occurs in a degenerate L.
fn roles(degeneracy: &Degeneracy, private: &TokenStream) -> TokenStream {
    let roles = degeneracy.roles.iter().map(|role| match role {
        Role::Massive => quote!(#private::CoordinateRole::Massive),
        Role::Massless => quote!(#private::CoordinateRole::Massless),
        Role::Algebraic => quote!(#private::CoordinateRole::Algebraic),
    });
    quote!(const ROLES: &'static [#private::CoordinateRole] = &[#(#roles),*];)
}

/// Of the implementation, and of its functions for L and the noises.
fn documentation(about: &SystemTexts, is_noisy: bool) -> [TokenStream; 3] {
    let of_motion = if is_noisy {
        "Equations of motion (Stratonovich):"
    } else {
        "Equations of motion:"
    };
    let of_lagrangian = "L with its first and second derivatives.";
    let of_noises = "The noise Hamiltonians, −γ and H₁, with their first and second derivatives.";
    [
        documented(&[("The system:", &about.system()), (of_motion, &about.motion)]),
        documented(&[(of_lagrangian, &about.lagrangian)]),
        documented(&[(of_noises, &about.noises)]),
    ]
}

/// A check, when the user's program is compiled, that a path leads to the constant of the standard library that it is read as.
fn constant_check(path: &TokenStream, value: f64) -> TokenStream {
    let at = path.clone().into_iter().next();
    let at = at.map_or_else(Span::call_site, |token| token.span());
    let written = path.to_string().replace(' ', "");
    let name = written.rsplit("::").next().unwrap_or_default();
    let message = format!(
        "`{written}` is read as `std::f64::consts::{name}`, and it has another value here: write the full path of the constant, as in `crate::{written}`"
    );
    let bits = Literal::u64_suffixed(value.to_bits());
    quote_spanned!(at=>
        const _: () = {
            let value: f64 = #path;
            ::core::assert!(value.to_bits() == #bits, #message);
        };
    )
}
