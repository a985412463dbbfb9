//! `impl System`: the derivatives of L and of the noises.

use proc_macro2::{Literal, Span, TokenStream};
use quote::{quote, quote_spanned};

use super::configuration::{Received, received, written};
use super::energy::energy_lanes;
use super::euler::{euler_increment, no_euler};
use super::identity::identity;
use super::jets::{constraint_jets, force_jet, lagrangian_jet, noise_force_jets, noise_jets};
use super::{Context, attributes, documented};
use crate::explain::SystemTexts;
use crate::system::degeneracy::{Degeneracy, Role};
use crate::system::functions::Functions;
use crate::system::mechanics::Mechanics;

pub(crate) fn system(context: &Context<'_>, functions: &Functions) -> TokenStream {
    let Context {
        block,
        model,
        about,
        private,
        ..
    } = *context;
    let attributes = attributes();
    let (self_ty, [n, m]) = (context.self_ty(), context.sizes());
    let mechanics = &functions.mechanics;
    let affine_momentum = mechanics.affine_momentum;
    let [doc, jet_doc, noise_doc] = documentation(about, !mechanics.noises.is_empty());
    let configuration = written(block, private).map(|ty| quote!(, #ty));
    let received = received(block, model, private);
    let Received { flat, open, .. } = &received;
    let lagrangian_body = lagrangian_jet(&mechanics.lagrangian, context.formulas());
    let noise_body = noise_jets(&mechanics.noises, context.formulas());
    let optional = optional(context, functions, &received);
    let identity = identity(model, context.arena, private);
    let roles = context.degeneracy.map(|d| roles(d, private));
    let parameters = model.symbols.parameters().map(|s| model.symbols.source(s));
    let inputs = Literal::usize_unsuffixed(model.symbols.inputs());
    let inputs = (model.symbols.inputs() > 0).then(|| quote!(const INPUTS: usize = #inputs;));
    let (coordinates, momenta) = (&model.names.configuration, &model.names.momenta);
    let (used, markers) = (used(context), markers(context, mechanics));
    quote! {
        #used
        #doc
        #attributes
        impl #private::System for #self_ty {
            type Dims = #private::Dims<#n, #m #configuration>;
            type Itself = Self;
            const AFFINE_MOMENTUM: bool = #affine_momentum;
            #roles
            #inputs
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
            #optional
        }
        #markers
    }
}

/// The functions that not every system has.
fn optional(context: &Context<'_>, functions: &Functions, received: &Received) -> TokenStream {
    let force = functions.mechanics.force.as_ref();
    let force = force.map(|jet| force_jet(jet, received, context.formulas()));
    let [n, m] = context.sizes();
    let noises = &functions.mechanics.noises;
    let of_noises = noise_force_jets(noises, received, [&n, &m], context.formulas());
    let constraints = constraint_jets(context, functions);
    let energy = functions.energy.as_ref();
    let energy = energy.and_then(|energy| energy_lanes(energy, context));
    let euler = functions.euler.as_ref();
    let euler = euler.and_then(|euler| euler_increment(euler, context.settings.lanes, context));
    let euler = euler.unwrap_or_else(no_euler);
    quote!(#force #of_noises #constraints #energy #euler)
}

/// Uses of the functions and constants of the block. Derived code does not call the functions, and
/// without a use the compiler would report them as dead; constants must be those of the standard
/// library.
fn used(context: &Context<'_>) -> TokenStream {
    let (block, self_ty, attributes) = (context.block, context.user_ty(), attributes());
    let parts = [
        &block.noises,
        &block.forces,
        &block.symmetries,
        &block.constraints,
    ];
    let functions = parts.into_iter().flatten().chain(&block.time_scale);
    let functions = functions.chain([&block.lagrangian]);
    let functions = functions.map(|part| &part.name);
    let constants = context.model.constants.iter();
    let constants = constants.map(|(path, value)| constant_check(path, *value));
    quote! {
        #attributes
        const _: () = { #(let _ = <#self_ty>::#functions;)* };
        #(#constants)*
    }
}

/// Implementations of the traits by which splittings know a system. Conditions of order for the
/// splitting of a quadratic kinetic energy do not hold for steps that constraints couple.
fn markers(context: &Context<'_>, mechanics: &Mechanics) -> TokenStream {
    let (private, self_ty) = (context.private, context.self_ty());
    let is_separable = mechanics.is_separable && context.degeneracy.is_none();
    let is_quadratic =
        is_separable && mechanics.affine_momentum && mechanics.constraints.is_empty();
    let separable = is_separable.then(|| quote!(impl #private::Separable for #self_ty {}));
    let quadratic =
        is_quadratic.then(|| quote!(impl #private::QuadraticKineticEnergy for #self_ty {}));
    quote!(#separable #quadratic)
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

/// A check, when the user's program is compiled, that a path leads to the constant of the standard
/// library that it is read as.
pub(super) fn constant_check(path: &TokenStream, value: f64) -> TokenStream {
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
