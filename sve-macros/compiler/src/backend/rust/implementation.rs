//! `impl StepEquations<Rule>`: the types of a step and the bodies of its functions → an
//! implementation.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};

use super::attributes;

/// An implementation of the equations of a step.
pub(super) struct Implementation<'a> {
    pub(super) private: &'a TokenStream,
    pub(super) doc: TokenStream,
    /// `impl StepEquations<Rule> for System`.
    pub(super) header: TokenStream,
    /// Numbers of degrees of freedom, increments and unknowns.
    pub(super) sizes: [&'a dyn ToTokens; 3],
    /// The types of the state in a step, of the coefficients that `prepare` returns, and of the
    /// numbers that a trajectory carries.
    pub(super) types: [TokenStream; 3],
    pub(super) plan: TokenStream,
    /// The variant of `Returns`.
    pub(super) returns: TokenStream,
    /// Constants and functions that not every step has.
    pub(super) more: TokenStream,
    /// The bodies of the functions.
    pub(super) prepare: TokenStream,
    pub(super) start: TokenStream,
    pub(super) increment: TokenStream,
    pub(super) linearise: TokenStream,
    /// Docs of `increment`.
    pub(super) increment_doc: TokenStream,
}

impl Implementation<'_> {
    pub(super) fn print(self) -> TokenStream {
        let Self {
            private,
            doc,
            header,
            sizes: [n, m, k],
            types: [state, prepared, memory],
            plan,
            returns,
            more,
            prepare,
            start,
            increment,
            linearise,
            increment_doc,
        } = self;
        let attributes = attributes();
        quote! {
            #doc
            #attributes
            #header {
                type Increments = [f64; #m];
                type Memory = #memory;
                type Prepared = #prepared;
                type Unknowns = [f64; #k];
                const PLAN: &'static #private::Plan = &#plan;
                const RETURNS: #private::Returns = #private::Returns::#returns;
                #[inline]
                fn prepare(&self, h: f64) -> #prepared {
                    #prepare
                }
                #[inline]
                fn start(
                    &self,
                    state: &#state,
                    velocity: &[f64; #n],
                    acceleration: &[f64; #n],
                ) -> [f64; #k] {
                    #start
                }
                #increment_doc
                #[inline]
                fn increment(
                    &self,
                    prepared: &#prepared,
                    memory: &mut #memory,
                    state: &#state,
                    h: f64,
                    dw: &[f64; #m],
                    newton: &#private::BlockSolver<'_>,
                ) -> ::core::result::Result<([f64; #n], [f64; #n], [f64; #k]), #private::SolveError> {
                    #increment
                }
                #[inline]
                fn linearise<__T>(
                    &self,
                    state: &#state,
                    h: f64,
                    dw: &[f64; #m],
                    unknowns: &[f64; #k],
                    then: impl ::core::ops::FnOnce(#private::Linearisation<'_>) -> __T,
                ) -> __T {
                    #linearise
                }
                #more
            }
        }
    }
}
