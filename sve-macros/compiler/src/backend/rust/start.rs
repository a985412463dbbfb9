//! `impl StartOfStep`: the test of the mass matrix at the start of a step, of single states and in lanes.
//!
//! Input: the blocks of the mass matrix that may be singular. Output: an implementation, which is empty where nothing has to be tested. A lane that is not sure takes
//! the scalar step, which decides.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::configuration::{Received, received};
use super::solve::typed;
use super::straight::{Straight, rows};
use super::{Context, attributes, private};
use crate::algebra::Expr;
use crate::program::{Labels, Scheduler, Tier, Tiers, Value};
use crate::structure::{Matrix, StartTest, Storage};

/// Largest number of instructions of a loop over the lanes. Of longer loops the compiler makes no vectors.
const MAX_INSTRUCTIONS: usize = 1500;

/// Largest block that is tested in lanes.
const MAX_ROWS: usize = 6;

pub(crate) fn start_of_step(context: &Context<'_>, test: &StartTest) -> TokenStream {
    let (private, attributes) = (private(context.block), attributes());
    let StartTest {
        of_parameters,
        of_state,
        needs_velocity,
    } = test;
    let self_ty = &context.block.item.self_ty;
    let Received { flat, open, .. } = &received(context.block, context.model, &private);
    let by_parameters = (!of_parameters.is_empty()).then(|| {
        let body = all_regular(of_parameters, context, &private);
        quote! {
            const TESTS_PARAMETERS: bool = true;
            #[inline]
            fn parameters_give_regular_mass(&self) -> bool {
                #body
            }
        }
    });
    let by_state = (!of_state.is_empty()).then(|| {
        let body = all_regular(of_state, context, &private);
        let lanes = (context.settings.lanes).then(|| singular_lanes(of_state, context, &private));
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

/// Statements and the value of the test that all blocks are regular.
fn all_regular(
    blocks: &[Matrix<Expr>],
    context: &Context<'_>,
    private: &TokenStream,
) -> TokenStream {
    let roots: Vec<Expr> = blocks.iter().flat_map(Matrix::stored).collect();
    let named = blocks.iter().enumerate().map(|(at, block)| {
        let names = rows(&format!("mass_{at}"), block.rows.len());
        (block.rows.as_slice(), names)
    });
    let named: Vec<(&[Vec<Expr>], Vec<String>)> = named.collect();
    let straight = Straight::new(context.arena, &context.model.symbols, &roots);
    let (statements, arrays) = straight.finish(private, &named);
    let blocks = blocks
        .iter()
        .zip(&arrays)
        .map(|(block, rows)| typed(private, block, rows));
    quote! {
        #statements
        #(#private::is_regular(&#blocks))&&*
    }
}

/// `lanes_of_singular_mass`; nothing for configurations without lanes and for blocks that are tested lane by lane.
fn singular_lanes(
    blocks: &[Matrix<Expr>],
    context: &Context<'_>,
    private: &TokenStream,
) -> Option<TokenStream> {
    let model = context.model;
    let is_small =
        |block: &Matrix<Expr>| block.storage == Storage::Dense && block.size() <= MAX_ROWS;
    if model.configuration().has_rotations() || !blocks.iter().all(is_small) {
        return None;
    }
    let roots: Vec<Expr> = blocks.iter().flat_map(Matrix::stored).collect();
    let state = model.q.iter().chain([&model.time]);
    let tiers: Tiers = state.map(|&s| (s, Tier::State)).collect();
    let mut scheduler = Scheduler::new(context.arena, &model.symbols, tiers, &roots);
    let lowered = blocks
        .iter()
        .map(|block| block.map(|e| scheduler.value(e)))
        .collect::<Vec<Matrix<Value>>>();
    let mut labels = Labels::default();
    labels.expressions(&scheduler, context.arena, &model.symbols, &[], &roots);
    let results: Vec<Value> = lowered.iter().flat_map(Matrix::stored).collect();
    let program = scheduler.finish(&results);
    if program.all().count() > MAX_INSTRUCTIONS {
        return None;
    }
    let printer = Printer::of_stages(&program, &model.symbols, &labels, private);
    let [before, known] = [Tier::Prepare, Tier::State].map(|tier| printer.statements(tier));
    let blocks = lowered.iter().map(|block| printer.matrix(&block.rows));
    let n = Literal::usize_unsuffixed(model.dof());
    let entries = (0..model.dof()).map(|i| {
        let i = Literal::usize_unsuffixed(i);
        quote!(states.q[#i][lane])
    });
    Some(quote! {
        #[inline(always)]
        fn lanes_of_singular_mass(&self, states: &#private::lane::StateLanes<#n>) -> ::core::option::Option<#private::lane::Mask> {
            #before
            let mut unsure: #private::lane::Lane = [0f64; #private::lane::LANES];
            for lane in 0..#private::lane::LANES {
                let time: f64 = states.t[lane];
                let q: [f64; #n] = [#(#entries),*];
                #known
                let is_regular = #(#private::lane::is_regular(&#blocks))&*;
                unsure[lane] = if is_regular { 0f64 } else { 1f64 };
            }
            ::core::option::Option::Some(#private::lane::marked(&unsure))
        }
    })
}
