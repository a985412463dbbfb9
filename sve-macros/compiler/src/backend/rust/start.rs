//! `impl StartOfStep`: the test of the mass matrix at the start of a step, of single states and in
//! lanes.
//!
//! Input: the blocks of the mass matrix that may be singular. Output: an implementation, which is
//! empty where nothing has to be tested. A lane that is not sure takes the scalar step, which
//! decides.

use proc_macro2::TokenStream;
use quote::quote;

use super::axis::Axis;
use super::code::Place;
use super::configuration::{Received, received};
use super::function::Printed;
use super::{Context, attributes};
use crate::algebra::Expr;
use crate::program::limits::in_lanes;
use crate::program::{Array, Kernel, Scheduler, Tier, Tiers, entries};
use crate::structure::{Matrix, StartTest, Storage};

pub(crate) fn start_of_step(context: &Context<'_>, test: &StartTest) -> TokenStream {
    let (private, attributes) = (context.private, attributes());
    let StartTest {
        of_parameters,
        of_state,
        needs_velocity,
    } = test;
    let self_ty = context.self_ty();
    let Received { flat, open, .. } = &received(context.block, context.model, private);
    let by_parameters = (!of_parameters.is_empty()).then(|| {
        let body = all_regular(of_parameters, context);
        quote! {
            const TESTS_PARAMETERS: bool = true;
            #[inline]
            fn parameters_give_regular_mass(&self) -> bool {
                #body
            }
        }
    });
    let by_state = (!of_state.is_empty()).then(|| {
        let body = all_regular(of_state, context);
        let lanes = (context.settings.lanes).then(|| singular_lanes(of_state, context));
        quote! {
            const TESTS_STATE: bool = true;
            #[inline]
            fn state_gives_regular_mass(&self, time: f64, q: &#flat) -> bool {
                #open
                #body
            }
            #lanes
        }
    });
    let by_velocity = needs_velocity.then(|| {
        quote!(
            const TESTS_VELOCITY: bool = true;
        )
    });
    quote! {
        #attributes
        impl #private::StartOfStep for #self_ty {
            #by_parameters
            #by_state
            #by_velocity
        }
    }
}

/// The mass matrix of each block.
fn masses(blocks: &[Matrix<Expr>]) -> Vec<Array<Expr>> {
    let blocks = blocks.iter().enumerate();
    blocks
        .map(|(at, block)| Array::matrix(&format!("mass_{at}"), block))
        .collect()
}

/// Statements and the value of the test that all blocks are regular.
fn all_regular(blocks: &[Matrix<Expr>], context: &Context<'_>) -> TokenStream {
    let private = context.private;
    let Printed {
        statements, arrays, ..
    } = context.formulas().list(&masses(blocks));
    quote! {
        #statements
        #(#private::is_regular(&#arrays))&&*
    }
}

/// `lanes_of_singular_mass`; nothing for configurations without lanes and for blocks that are
/// tested lane by lane.
fn singular_lanes(blocks: &[Matrix<Expr>], context: &Context<'_>) -> Option<TokenStream> {
    let (model, private, formulas) = (context.model, context.private, context.formulas());
    let is_small = |block: &Matrix<Expr>| {
        block.storage == Storage::Dense && block.size() <= in_lanes::UNKNOWNS
    };
    if model.configuration().has_rotations() || !blocks.iter().all(is_small) {
        return None;
    }
    let masses = masses(blocks);
    let state = model.q.iter().chain([&model.time]);
    let tiers: Tiers = state.map(|&s| (s, Tier::State)).collect();
    let scheduler = Scheduler::new(context.arena, formulas.symbols, tiers, &entries(&masses));
    let kernel = Kernel::new(scheduler, &masses);
    if kernel.program.all().count() > in_lanes::INSTRUCTIONS {
        return None;
    }
    let printer = formulas.printer(&kernel, Place::Over(Axis::Lanes));
    let [before, known] = [Tier::Prepare, Tier::State].map(|tier| printer.statements(tier));
    let blocks = kernel.arrays.iter().map(|block| printer.shaped(block));
    let body = quote! {
        #known
        let is_regular = #(#private::lane::is_regular(&#blocks))&*;
        unsure[lane] = if is_regular { 0f64 } else { 1f64 };
    };
    let ([n, _], sweep) = (context.sizes(), Axis::Lanes.sweep(&body, private));
    let inputs = Axis::inputs(&model.symbols, private);
    Some(quote! {
        #[inline(always)]
        fn lanes_of_singular_mass(&self, states: &#private::lane::StateLanes<#n>) -> ::core::option::Option<#private::lane::Mask> {
            #before
            #inputs
            let mut unsure: #private::lane::Lane = [0f64; #private::lane::LANES];
            #sweep
            ::core::option::Option::Some(#private::lane::marked(&unsure))
        }
    })
}
