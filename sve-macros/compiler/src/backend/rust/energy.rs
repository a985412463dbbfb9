//! `energy_lanes`: the energies of many states at once, as a loop over the lanes without branches and calls.
//!
//! Input: the energy as a function of q and p. Output: a function of the implementation of `System`. An energy that is not finite is left to the
//! function of a single state.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use crate::algebra::{Arena, Expr};
use crate::model::Model;
use crate::program::{Labels, Program, Scheduler, Tier, Tiers, Value};
use crate::system::energy::Energy;

/// Largest number of instructions, beyond which the loop is not worth its code.
const MAX_INSTRUCTIONS: usize = 1500;

/// Returns the function, unless the energy takes too many operations.
pub(super) fn energy_lanes(
    energy: &Energy,
    model: &Model,
    private: &TokenStream,
    arena: &Arena,
) -> Option<TokenStream> {
    let Energy {
        lagrangian,
        mass,
        has_diagonal_mass,
        at_rest,
    } = energy;
    let n = model.dof();
    let entries = mass.iter().flatten().chain(at_rest);
    let roots: Vec<Expr> = entries.chain([lagrangian]).copied().collect();
    let early = model.q.iter().chain([&model.time]);
    let mut tiers: Tiers = early.map(|&s| (s, Tier::State)).collect();
    tiers.extend(model.v.iter().map(|&s| (s, Tier::Iterate(0))));
    let mut scheduler = Scheduler::new(arena, &model.symbols, tiers, &roots);
    let values = scheduler.values(&roots);
    let mut labels = Labels::default();
    labels.expressions(&scheduler, arena, &model.symbols, &[], &roots);
    let program: Program = scheduler.finish(&values);
    if program.all().count() > MAX_INSTRUCTIONS {
        return None;
    }
    let printer = Printer::of_stages(&program, &model.symbols, &labels, private);
    let [before, known, late] =
        [Tier::Prepare, Tier::State, Tier::Iterate(0)].map(|tier| printer.statements(tier));
    let (matrix, rest) = values.split_at(n * n);
    let velocity = if *has_diagonal_mass {
        let diagonal: Vec<Value> = (0..n).map(|i| matrix[i * n + i]).collect();
        let diagonal = printer.array(&diagonal);
        quote!(#private::lane::solve_diagonal(&#diagonal, &rhs))
    } else {
        let rows: Vec<Vec<Value>> = matrix.chunks(n).map(<[Value]>::to_vec).collect();
        let matrix = printer.matrix(&rows);
        quote!(#private::lane::solve(&#matrix, &rhs))
    };
    let index = || (0..n).map(Literal::usize_unsuffixed);
    let of_lane = |row: &TokenStream| {
        let entries = index().map(|i| quote!(states.#row[#i][lane]));
        quote!([#(#entries),*])
    };
    let (q, p) = (of_lane(&quote!(q)), of_lane(&quote!(p)));
    let rhs = index().zip(rest).map(|(i, &value)| {
        let at_rest = printer.operand(value);
        quote!(p[#i] - #at_rest)
    });
    let terms = index().map(|i| quote!(+ p[#i] * v[#i]));
    let lagrangian = printer.operand(rest[n]);
    let size = Literal::usize_unsuffixed(n);
    Some(quote! {
        #[inline(always)]
        fn energy_lanes(&self, states: &#private::lane::StateLanes<#size>, next: &mut #private::lane::Lane) {
            #before
            for lane in 0..#private::lane::LANES {
                let time: f64 = states.t[lane];
                let q: [f64; #size] = #q;
                let p: [f64; #size] = #p;
                #known
                let rhs: [f64; #size] = [#(#rhs),*];
                let v: [f64; #size] = #velocity;
                #late
                next[lane] = -#lagrangian #(#terms)*;
            }
        }
    })
}
