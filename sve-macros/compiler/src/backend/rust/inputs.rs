//! A system with inputs: the type that holds their values beside the system, for which steps are
//! derived, and the trait by which an integrator makes it.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::{Type, parse_quote};

use super::configuration::configuration;
use super::{Context, attributes};
use crate::syntax::parse::{Annotated, is_f64};

/// Returns the type whose steps are derived.
pub(super) fn stepped(block: &Annotated) -> Type {
    match &block.inputs {
        Some(_) => parse_quote!(__Held<'_>),
        None => (*block.item.self_ty).clone(),
    }
}

/// Returns the implementations together with the type that holds inputs, if the block has any.
pub(super) fn within(context: &Context<'_>, output: TokenStream) -> TokenStream {
    let Some(input) = &context.block.inputs else {
        return output;
    };
    let (private, user_ty, attributes) = (context.private, context.user_ty(), attributes());
    let access = context.model.symbols.parameters();
    let inputs = access.filter(|&s| context.model.symbols.source(s).starts_with("u["));
    let count = Literal::usize_unsuffixed(inputs.count());
    let numbers = if is_f64(input) {
        quote!([*u])
    } else {
        quote!((*u).into())
    };
    let [n, _] = context.sizes();
    let whole = configuration(context.block, &n, private);
    let forward = quote! {
        type Configuration = #whole;
        type Stepped = __Held<'static>;
        type Kind = #private::Inputs;
        type StateLanes = ();
        type IncrementLanes = ();
        const NAMES: #private::Names = <__Held<'static> as #private::AnySystem>::NAMES;
        const FORMULAS_HASH: u64 = <__Held<'static> as #private::AnySystem>::FORMULAS_HASH;
    };
    quote! {
        const _: () = {
            /// The system with inputs that are held over a step.
            #[derive(Clone, Copy)]
            pub struct __Held<'a> {
                __system: &'a #user_ty,
                u: [f64; #count],
            }
            #attributes
            impl #private::AnySystem for #user_ty {
                type Target = Self;
                #forward
                fn target(&self) -> &Self { self }
                fn visit_parameters(&self, visit: &mut dyn ::core::ops::FnMut(f64)) {
                    let held = __Held { __system: self, u: [0f64; #count] };
                    #private::AnySystem::visit_parameters(&held, visit);
                }
            }
            #attributes
            impl #private::AnySystem for &#user_ty {
                type Target = #user_ty;
                #forward
                fn target(&self) -> &#user_ty { self }
            }
            #attributes
            impl #private::WithInputs for #user_ty {
                type Input = #input;
                type Numbers = [f64; #count];
                type Sizes = <__Held<'static> as #private::System>::Dims;
                type Held<'a> = __Held<'a>;
                #[inline(always)]
                fn numbers(u: &#input) -> [f64; #count] { #numbers }
                #[inline(always)]
                fn held(&self, u: &#input) -> __Held<'_> {
                    __Held { __system: self, u: #numbers }
                }
            }
            #output
        };
    }
}
