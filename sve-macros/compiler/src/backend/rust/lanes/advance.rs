//! The end of a step in lanes: the new state of a lane, and whether its equations are solved.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::super::axis::Axis;
use super::super::step::inside;
use super::{Value, Writer, course};
use crate::structure::{Returns, Solution};

impl Writer<'_> {
    /// The new state of a lane.
    pub(super) fn advance(&self) -> TokenStream {
        let (dq, dp) = (&self.step.scheme.dq, &self.step.scheme.dp);
        let new = |row: &TokenStream, values: &[Value]| {
            let entries = values.iter().enumerate().map(|(i, &value)| {
                let (start, value) = (Axis::Lanes.entry(row, i), self.printer.operand(value));
                match self.step.scheme.returns {
                    Returns::Increment | Returns::MatrixTimesState => quote!(#start + #value),
                    Returns::State => quote!(#value),
                }
            });
            quote!([#(#entries),*])
        };
        let (q, p) = (new(&quote!(states.q), dq), new(&quote!(states.p), dp));
        let (solved, domain) = self.solved();
        // a state outside of the domain of L is none
        let has_conditions =
            !self.step.scheme.domain.is_empty() || !self.step.scheme.guards.is_empty();
        let poison = has_conditions.then(|| {
            let n = Literal::usize_unsuffixed(dq.len());
            quote!(let p_lane = if true #domain { p_lane } else { [f64::NAN; #n] };)
        });
        let [store_q, store_p] = stores(dq.len());
        let private = self.private;
        quote! {
            let q_lane = #q;
            let p_lane = #p;
            #poison
            #store_q
            #store_p
            any |= #private::lane::needs_scalar_step(q_lane, p_lane, #solved);
        }
    }

    /// Conditions on a lane: all its iterations have converged, and L is defined at the solution.
    /// The second is tested where its values are known.
    pub(super) fn solved(&self) -> (TokenStream, TokenStream) {
        let iterations = self.step.scheme.blocks.iter().enumerate();
        let arrived = iterations.filter_map(|(at, block)| {
            let course = course(at);
            matches!(block.solution, Solution::Iteration(_))
                .then(|| quote!(& #course.has_converged(lane)))
        });
        let domain = self.step.scheme.domain.iter().map(|condition| {
            let value = self.printer.operand(condition.value);
            let holds = inside(&value, condition.is_closed);
            quote!(& (#holds))
        });
        let guards = self.step.scheme.guards.iter().map(|&guard| {
            let guard = self.printer.operand(guard);
            quote!(& (#guard >= 0f64))
        });
        (quote!(true #(#arrived)*), quote!(#(#domain)* #(#guards)*))
    }
}

/// The statements that store the new state of a lane, which is in `q_lane` and `p_lane`.
pub(in super::super) fn stores(count: usize) -> [TokenStream; 2] {
    ["q", "p"].map(|quantity| {
        let (row, new) = (
            format_ident!("{quantity}"),
            format_ident!("{quantity}_lane"),
        );
        let entries = (0..count).map(Literal::usize_unsuffixed);
        Axis::Lanes.store(&quote!(next.#row), entries.map(|i| quote!(#new[#i])))
    })
}
