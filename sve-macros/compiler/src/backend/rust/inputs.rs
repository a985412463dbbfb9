//! A system with inputs: the type that holds their values beside the system, for which steps are
//! derived, and its implementation of `WithInputs`. Formulas read a field of the system as
//! `self.m`, through `Deref`.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::{Type, parse_quote};

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
    let symbols = &context.model.symbols;
    let inputs = (symbols.parameters()).filter(|&s| symbols.source(s).starts_with("u["));
    let count = Literal::usize_unsuffixed(inputs.count());
    let holder = Holder {
        private: context.private,
        user_ty: context.user_ty(),
        input,
        count: quote!(#count),
        numbers: if is_f64(input) {
            quote!([*u])
        } else {
            quote!((*u).into())
        },
    };
    holder.print(&output)
}

/// The type that holds the values of inputs beside a system.
pub(super) struct Holder<'a> {
    pub(super) private: &'a TokenStream,
    pub(super) user_ty: &'a Type,
    /// The type of the argument `u`.
    pub(super) input: &'a Type,
    /// The number of numbers in it.
    pub(super) count: TokenStream,
    /// The numbers in the reference `u`, an array.
    pub(super) numbers: TokenStream,
}

impl Holder<'_> {
    /// Returns the type with implementations for it.
    pub(super) fn print(&self, output: &TokenStream) -> TokenStream {
        let Self {
            private,
            user_ty,
            input,
            count,
            numbers,
        } = self;
        let (attributes, forward) = (attributes(), self.forward());
        quote! {
            const _: () = {
                /// A system with inputs that are held over a step. Its type is as visible as the
                /// system's, which is an argument.
                #[derive(Clone, Copy)]
                pub struct __WithInputs<'a, S> {
                    __system: &'a S,
                    u: [f64; #count],
                }
                #attributes
                impl<S> ::core::ops::Deref for __WithInputs<'_, S> {
                    type Target = S;
                    #[inline(always)]
                    fn deref(&self) -> &S { self.__system }
                }
                type __Held<'a> = __WithInputs<'a, #user_ty>;
                #attributes
                impl #private::AnySystem for #user_ty {
                    type Target = Self;
                    #forward
                    fn target(&self) -> &Self { self }
                    fn visit_parameters(&self, visit: &mut dyn ::core::ops::FnMut(f64)) {
                        let held = __WithInputs { __system: self, u: [0f64; #count] };
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
                        __WithInputs { __system: self, u: #numbers }
                    }
                }
                #output
            };
        }
    }

    /// What the system and references to it have from the type that holds its inputs.
    fn forward(&self) -> TokenStream {
        let private = self.private;
        let held = quote!(<__Held<'static> as #private::AnySystem>);
        quote! {
            type Configuration = #held::Configuration;
            type Stepped = __Held<'static>;
            type Kind = #private::Inputs;
            type StateLanes = ();
            type IncrementLanes = ();
            const NAMES: #private::Names = #held::NAMES;
            const FORMULAS_HASH: u64 = #held::FORMULAS_HASH;
        }
    }
}
