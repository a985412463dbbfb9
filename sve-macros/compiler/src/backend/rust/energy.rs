//! `energy_lanes`: the energies of many states at once, as a loop over the lanes without branches
//! and calls.
//!
//! Input: the energy as a function of q and p. Output: a function of the implementation of
//! `System`. An energy that is not finite is left to the function of a single state.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::Context;
use super::axis::Axis;
use super::code::Place;
use crate::program::limits::in_lanes;
use crate::program::{Array, Kernel, Scheduler, Tier, Tiers, Value, entries};
use crate::system::energy::Energy;

/// Returns the function, unless the energy takes too many operations.
pub(super) fn energy_lanes(energy: &Energy, context: &Context<'_>) -> Option<TokenStream> {
    let Energy {
        lagrangian,
        mass,
        has_diagonal_mass,
        at_rest,
    } = energy;
    let (model, private, formulas) = (context.model, context.private, context.formulas());
    let n = model.dof();
    let mass = Array::rows("", mass).without_names();
    let arrays = [
        mass,
        Array::unnamed(at_rest),
        Array::unnamed(&[*lagrangian]),
    ];
    let early = model.q.iter().chain([&model.time]);
    let mut tiers: Tiers = early.map(|&s| (s, Tier::State)).collect();
    tiers.extend(model.v.iter().map(|&s| (s, Tier::Iterate(0))));
    let scheduler = Scheduler::new(context.arena, formulas.symbols, tiers, &entries(&arrays));
    let kernel = Kernel::new(scheduler, &arrays);
    if kernel.program.all().count() > in_lanes::INSTRUCTIONS {
        return None;
    }
    let printer = formulas.printer(&kernel, Place::Over(Axis::Lanes));
    let [before, known, late] =
        [Tier::Prepare, Tier::State, Tier::Iterate(0)].map(|tier| printer.statements(tier));
    let [mass, at_rest, lagrangian] = [0, 1, 2].map(|at| &kernel.arrays[at]);
    let (solve, matrix) = if *has_diagonal_mass {
        let diagonal: Vec<Value> = (0..n).map(|i| mass.rows[i][i]).collect();
        (quote!(solve_diagonal), printer.array(&diagonal))
    } else {
        (quote!(solve), printer.shaped(mass))
    };
    let momentum = |i: usize| Axis::Lanes.entry(&quote!(states.p), i);
    let rhs = at_rest.entries().enumerate().map(|(i, value)| {
        let (p, at_rest) = (momentum(i), printer.operand(value));
        quote!(#p - #at_rest)
    });
    let terms = (0..n).map(|i| {
        let (p, i) = (momentum(i), Literal::usize_unsuffixed(i));
        quote!(+ #p * v[#i])
    });
    let lagrangian = printer.operand(lagrangian.rows[0][0]);
    let size = Literal::usize_unsuffixed(n);
    let body = quote! {
        #known
        let rhs: [f64; #size] = [#(#rhs),*];
        let v: [f64; #size] = #private::lane::#solve(&#matrix, &rhs);
        #late
        next[lane] = -#lagrangian #(#terms)*;
    };
    let sweep = Axis::Lanes.sweep(&body, private);
    let inputs = Axis::inputs(formulas.symbols, private);
    Some(quote! {
        #[inline(always)]
        fn energy_lanes(&self, states: &#private::lane::StateLanes<#size>, next: &mut #private::lane::Lane) {
            #before
            #inputs
            #sweep
        }
    })
}
