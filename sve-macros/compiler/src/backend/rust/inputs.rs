//! A system with inputs, or with a time scale: the type that holds the inputs, or the energy of the
//! path, beside the system, for which steps are derived, and the implementation of `WithInputs` or
//! `WithTimeScale`. Formulas read a field of the system as `self.m`, through `Deref`.

use std::collections::HashSet;

use proc_macro2::{Group, Ident, Literal, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::spanned::Spanned;
use syn::{Lifetime, Type, parse_quote};

use super::attributes;
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::{Meaning, Symbols};
use crate::syntax::parse::{Annotated, is_f64};

/// Returns the type whose steps are derived.
pub(super) fn stepped(block: &Annotated) -> Type {
    if block.inputs.is_some() || block.time_scale.is_some() {
        held(&block.item.self_ty)
    } else {
        (*block.item.self_ty).clone()
    }
}

/// Returns the type that holds inputs beside a system of this type.
pub(super) fn held(user_ty: &Type) -> Type {
    if named(user_ty, true).1.is_empty() {
        parse_quote!(__Held<'_>)
    } else {
        parse_quote!(__Held<'_, '_>)
    }
}

/// Returns a type with names for the lifetimes `'_`, one for all or one for each, and the names.
pub(super) fn named(ty: &Type, one_for_all: bool) -> (TokenStream, Vec<Lifetime>) {
    let mut names: Vec<Lifetime> = Vec::new();
    let ty = each_elided(ty.to_token_stream(), &mut || {
        if names.is_empty() || !one_for_all {
            let name = format!("'__s{}", names.len());
            names.push(Lifetime::new(&name, Span::mixed_site()));
        }
        names[names.len() - 1].ident.clone()
    });
    (ty, names)
}

/// Replaces the name of each lifetime `'_`.
fn each_elided(tokens: TokenStream, name: &mut impl FnMut() -> Ident) -> TokenStream {
    let mut after_quote = false;
    let tokens = tokens.into_iter().map(|token| {
        let is_name = core::mem::take(&mut after_quote);
        match token {
            TokenTree::Group(group) => {
                let inner = each_elided(group.stream(), name);
                TokenTree::Group(Group::new(group.delimiter(), inner))
            }
            TokenTree::Ident(ident) if is_name && ident == "_" => TokenTree::Ident(name()),
            other => {
                after_quote = matches!(&other, TokenTree::Punct(mark) if mark.as_char() == '\'');
                other
            }
        }
    });
    tokens.collect()
}

/// Returns a warning at the type of `u` for each of its numbers that no formula reads.
pub(super) fn unread(
    block: &Annotated,
    symbols: &Symbols,
    formulas: impl Iterator<Item = Expr>,
    arena: &Arena,
) -> TokenStream {
    let Some(input) = &block.inputs else {
        return TokenStream::new();
    };
    let read: HashSet<Symbol> = formulas.flat_map(|of| arena.symbols_of(of)).collect();
    let inputs = symbols.parameters().filter(|symbol| {
        let meaning = symbols.meaning(*symbol);
        matches!(meaning, Meaning::Parameter { input: Some(_), .. }) && !read.contains(symbol)
    });
    let at = input.span().resolved_at(Span::call_site());
    let warnings = inputs.map(|symbol| {
        let number = symbols.source(symbol);
        let note =
            format!("no function of the block reads `{number}`: use it, or leave it out of `u`");
        let name = Ident::new("INPUT", at);
        quote! {
            const _: () = {
                #[deprecated(note = #note)]
                const #name: () = ();
                #name
            };
        }
    });
    warnings.collect()
}

/// Returns the implementations together with the type that holds inputs or an energy, if the block
/// has any.
pub(super) fn within(
    private: &TokenStream,
    (block, symbols): (&Annotated, &Symbols),
    output: TokenStream,
) -> TokenStream {
    let holds = match (&block.inputs, &block.time_scale) {
        (Some(input), _) => Holds::Inputs {
            input,
            numbers: if is_f64(input) {
                quote!([*u])
            } else {
                quote!((*u).into())
            },
            is_scene: block.is_scene(),
        },
        (None, Some(_)) => Holds::Energy,
        (None, None) => return output,
    };
    let count = Literal::usize_unsuffixed(symbols.inputs());
    let holder = Holder {
        private,
        user_ty: &block.item.self_ty,
        count: quote!(#count),
        holds,
    };
    holder.print(&output)
}

/// The type that holds numbers beside a system.
pub(super) struct Holder<'a> {
    pub(super) private: &'a TokenStream,
    pub(super) user_ty: &'a Type,
    /// How many numbers it holds.
    pub(super) count: TokenStream,
    pub(super) holds: Holds<'a>,
}

/// The meaning of the numbers that are held.
pub(super) enum Holds<'a> {
    Inputs {
        /// The type of the argument `u`.
        input: &'a Type,
        /// The numbers in the reference `u`, an array.
        numbers: TokenStream,
        /// True for a scene, which has no lanes.
        is_scene: bool,
    },
    /// The energy of a path of a system with a time scale.
    Energy,
}

impl Holder<'_> {
    /// Returns the type with implementations for it.
    pub(super) fn print(&self, output: &TokenStream) -> TokenStream {
        let Self { private, count, .. } = self;
        let (user_ty, lifetimes) = named(self.user_ty, true);
        let held_by = self.held_by(&user_ty, &lifetimes);
        let (attributes, forward) = (attributes(), self.forward(&lifetimes));
        quote! {
            const _: () = {
                /// A system with inputs or an energy that are held over a step. Its type is as
                /// visible as the system's, which is an argument.
                pub struct __WithInputs<'a, S> {
                    __system: &'a S,
                    u: #private::HeldInputs<[f64; #count]>,
                }
                #attributes
                impl<S> ::core::clone::Clone for __WithInputs<'_, S> {
                    fn clone(&self) -> Self {
                        Self { __system: self.__system, u: ::core::clone::Clone::clone(&self.u) }
                    }
                }
                #attributes
                impl<S> ::core::ops::Deref for __WithInputs<'_, S> {
                    type Target = S;
                    #[inline(always)]
                    fn deref(&self) -> &S { self.__system }
                }
                type __Held<'a #(, #lifetimes)*> = __WithInputs<'a, #user_ty>;
                #attributes
                impl<#(#lifetimes),*> #private::AnySystem for #user_ty {
                    type Target = Self;
                    #forward
                    fn target(&self) -> &Self { self }
                    fn visit_parameters(&self, visit: &mut dyn ::core::ops::FnMut(f64)) {
                        let u = #private::HeldInputs::new([0f64; #count]);
                        let held = __WithInputs { __system: self, u };
                        #private::AnySystem::visit_parameters(&held, visit);
                    }
                }
                #attributes
                impl<#(#lifetimes),*> #private::AnySystem for &#user_ty {
                    type Target = #user_ty;
                    #forward
                    fn target(&self) -> &#user_ty { self }
                }
                #attributes
                #held_by
                #output
            };
        }
    }

    /// The trait by which a system gives the type that holds its numbers.
    fn held_by(&self, user_ty: &TokenStream, lifetimes: &[Lifetime]) -> TokenStream {
        let Self {
            private,
            count,
            holds,
            ..
        } = self;
        let Holds::Inputs {
            input,
            numbers,
            is_scene,
        } = holds
        else {
            let attributes = attributes();
            return quote! {
                impl<#(#lifetimes),*> #private::WithTimeScale for #user_ty {
                    type Held<'a> = __Held<'a #(, #lifetimes)*> where Self: 'a;
                    #[inline(always)]
                    fn with_energy(&self, energy: f64) -> __Held<'_ #(, #lifetimes)*> {
                        __WithInputs { __system: self, u: #private::HeldInputs::new([energy]) }
                    }
                }
                #attributes
                impl<#(#lifetimes),*> #private::WithTimeScale for &#user_ty {
                    type Held<'a> = __Held<'a #(, #lifetimes)*> where Self: 'a;
                    #[inline(always)]
                    fn with_energy(&self, energy: f64) -> __Held<'_ #(, #lifetimes)*> {
                        #private::WithTimeScale::with_energy(*self, energy)
                    }
                }
            };
        };
        let lanes = self.lanes(*is_scene, lifetimes);
        quote! {
            impl<#(#lifetimes),*> #private::WithInputs for #user_ty {
                type Input = #input;
                type Numbers = [f64; #count];
                #lanes
                type Held<'a> = __Held<'a #(, #lifetimes)*> where Self: 'a;
                #[inline(always)]
                fn numbers(u: &#input) -> [f64; #count] { #numbers }
                #[inline(always)]
                fn held_numbers(&self, numbers: [f64; #count]) -> __Held<'_ #(, #lifetimes)*> {
                    __WithInputs { __system: self, u: #private::HeldInputs::new(numbers) }
                }
                const OPEN: [f64; #count] = [f64::NAN; #count];
                #[inline(always)]
                fn inputs_of<'h>(held: &'h mut __Held<'_ #(, #lifetimes)*>) -> &'h mut #private::HeldInputs<[f64; #count]> {
                    &mut held.u
                }
            }
        }
    }

    /// How the states of lanes are read.
    fn lanes(&self, is_scene: bool, lifetimes: &[Lifetime]) -> TokenStream {
        let (private, stepped) = (self.private, longest(lifetimes));
        let (lanes, lane) = if is_scene {
            (quote!(()), quote!(::core::option::Option::None))
        } else {
            let sizes = quote!(<<#stepped as #private::System>::Dims as #private::Dimensions>);
            let state = quote!(#sizes::get(states, lane));
            (
                quote!(#sizes::StateLanes),
                quote!(::core::option::Option::Some(#state)),
            )
        };
        quote! {
            type Lanes = #lanes;
            #[inline(always)]
            fn lane(states: &#lanes, lane: usize) -> ::core::option::Option<#private::StateOf<Self>> {
                let _ = (states, lane);
                #lane
            }
        }
    }

    /// The members that the system and references to it have from the type that holds its inputs.
    fn forward(&self, lifetimes: &[Lifetime]) -> TokenStream {
        let private = self.private;
        let kind = match self.holds {
            Holds::Inputs { .. } => quote!(#private::Inputs),
            Holds::Energy => quote!(#private::ScaledTime),
        };
        let stepped = longest(lifetimes);
        let held = quote!(<#stepped as #private::AnySystem>);
        quote! {
            type Configuration = #held::Configuration;
            type Stepped = #stepped;
            type Kind = #kind;
            type StateLanes = ();
            const NAMES: #private::Names = #held::NAMES;
            const FORMULAS_HASH: u64 = #held::FORMULAS_HASH;
        }
    }
}

/// The type that holds inputs for as long as possible.
fn longest(lifetimes: &[Lifetime]) -> TokenStream {
    match lifetimes {
        [] => quote!(__Held<'static>),
        [own, ..] => quote!(__Held<#own, #own>),
    }
}
