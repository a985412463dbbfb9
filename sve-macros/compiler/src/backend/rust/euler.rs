//! `euler_increment` and `euler_increment_in_lane`: the increment of Euler's method as straight-line code, of which the explicit baselines consist.
//!
//! Input: the increment as expressions. Output: items of the implementation of `System`. What depends on parameters and step size alone is computed in
//! `euler_numbers`, with the inverse of a mass matrix that is constant and not diagonal.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use crate::algebra::{Arena, Expr};
use crate::model::Model;
use crate::program::{Labels, Operation, Program, Scheduler, Tier, Tiers, Value};
use crate::system::euler::Euler;

/// Largest number of instructions of the increment.
const MAX_INSTRUCTIONS: usize = 4000;

/// Largest number of instructions of all stages of a step in lanes. Of longer loops over the lanes the compiler makes no vectors: a step of the double
/// pendulum by Heun's method, of 330, takes longer than a single step.
const MAX_IN_LANES: usize = 120;

/// Instructions of a function in lanes, in this count.
const CALL: usize = 30;

/// Largest number of instructions that become part of each stage of a method.
const MAX_INLINED: usize = 1500;

/// Returns the items of a system that has no increment as straight-line code.
pub(super) fn no_euler() -> TokenStream {
    quote!(
        type EulerNumbers = ();
    )
}

/// Returns the items, unless the increment takes too many operations.
pub(super) fn euler_increment(
    euler: &Euler,
    has_lanes: bool,
    model: &Model,
    private: &TokenStream,
    arena: &Arena,
) -> Option<TokenStream> {
    let rows = euler.rows();
    let roots: Vec<Expr> = rows.concat();
    let state = model.q.iter().chain(&model.p).chain([&model.time]);
    let mut tiers: Tiers = state.map(|&s| (s, Tier::State)).collect();
    tiers.extend(model.v.iter().map(|&s| (s, Tier::Iterate(0))));
    let mut scheduler = Scheduler::new(arena, &euler.symbols, tiers, &roots);
    let values: Vec<Vec<Value>> = rows.iter().map(|row| scheduler.values(row)).collect();
    let mut labels = Labels::default();
    for (row, name) in values.iter().zip(["dq", "dp", "ito_dq", "ito_dp"]) {
        labels.vector(name, 0, row);
    }
    labels.expressions(&scheduler, arena, &euler.symbols, &[], &roots);
    let program = scheduler.finish(&values.concat());
    let length = program.all().count();
    (length <= MAX_INSTRUCTIONS).then(|| {
        let parts = Parts {
            euler,
            model,
            program: &program,
            labels: &labels,
            private,
            values: &values,
        };
        let function = parts.scalar(length <= MAX_INLINED);
        let stages = MAX_IN_LANES / weight(&program).max(1);
        let in_lane = (has_lanes && stages > 0).then(|| parts.in_lane(stages));
        quote!(#function #in_lane)
    })
}

/// Returns the number of instructions, of which those that call a function count more.
fn weight(program: &Program) -> usize {
    let of_one = |operation| match operation {
        Operation::Call(..)
        | Operation::Call2(..)
        | Operation::SinCos(_)
        | Operation::AngleAddition(..) => CALL,
        _ => 1,
    };
    let late = program.all().filter(|(_, i)| i.tier != Tier::Prepare);
    late.map(|(_, i)| of_one(i.operation)).sum()
}

impl Euler {
    /// The expressions that are computed: increments of q and p, their corrections, and what the velocity is solved from.
    fn rows(&self) -> Vec<Vec<Expr>> {
        let mut rows = vec![self.dq.clone(), self.dp.clone()];
        rows.extend(self.correction.iter().flatten().cloned());
        if let Some(solved) = &self.solved {
            rows.push(solved.rhs.clone());
            rows.extend(solved.mass.iter().cloned());
        }
        rows
    }

    /// The number of rows of results.
    fn results(&self) -> usize {
        if self.correction.is_some() { 4 } else { 2 }
    }
}

/// The scheduled increment.
struct Parts<'a> {
    euler: &'a Euler,
    model: &'a Model,
    program: &'a Program,
    labels: &'a Labels,
    private: &'a TokenStream,
    values: &'a [Vec<Value>],
}

impl Parts<'_> {
    /// `euler_numbers` and the increment of a single state.
    fn scalar(&self, is_inlined: bool) -> TokenStream {
        let private = self.private;
        let symbols = &self.euler.symbols;
        let mut printer = Printer::new(self.program, symbols, self.labels, private);
        let kept = printer.split_prepared(&self.used());
        let (prepare, kept) = (printer.prepare(), (printer.array(&kept), kept.len()));
        let [n, m, count] = self.sizes(kept.1);
        let (array, _) = kept;
        let (ty, numbers) = match self.constant_mass() {
            Some(mass) => {
                let mass = printer.matrix(mass);
                let inverse = quote!(#private::euler::inverse(&#mass)?);
                let ty = quote!(([f64; #count], [[f64; #n]; #n]));
                (ty, quote!((#array, #inverse)))
            }
            None => (quote!([f64; #count]), array),
        };
        let body = self.body(&printer, false);
        let inline = if is_inlined {
            quote!(#[inline(always)])
        } else {
            quote!(#[inline])
        };
        quote! {
            type EulerNumbers = #ty;
            const HAS_EULER_INCREMENT: bool = true;
            #[inline]
            fn euler_numbers(&self, h: f64) -> ::core::option::Option<#ty> {
                #prepare
                ::core::option::Option::Some(#numbers)
            }
            #inline
            fn euler_increment(
                &self,
                prepared: &#ty,
                time: f64,
                q: &[f64; #n],
                p: &[f64; #n],
                h: f64,
                dw: &[f64; #m],
            ) -> ::core::option::Option<#private::euler::EulerIncrement<[f64; #n]>> {
                #body
            }
        }
    }

    /// The increment of a state in a loop over the lanes.
    fn in_lane(&self, stages: usize) -> TokenStream {
        let stages = Literal::usize_unsuffixed(stages);
        let private = self.private;
        let symbols = &self.euler.symbols;
        let mut printer = Printer::of_stages(self.program, symbols, self.labels, private);
        let kept = printer.split_prepared(&self.used());
        let [n, m, count] = self.sizes(kept.len());
        let ty = match self.constant_mass() {
            Some(_) => quote!(([f64; #count], [[f64; #n]; #n])),
            None => quote!([f64; #count]),
        };
        let body = self.body(&printer, true);
        quote! {
            const EULER_STAGES_IN_LANES: usize = #stages;
            #[inline(always)]
            fn euler_increment_in_lane(
                &self,
                prepared: &#ty,
                time: f64,
                q: &[f64; #n],
                p: &[f64; #n],
                h: f64,
                dw: &[f64; #m],
            ) -> ::core::option::Option<#private::euler::EulerIncrement<[f64; #n]>> {
                #body
            }
        }
    }

    fn sizes(&self, kept: usize) -> [Literal; 3] {
        let noises = self.model.noises.len();
        [self.model.dof(), noises, kept].map(Literal::usize_unsuffixed)
    }

    /// The mass matrix, if it is inverted in `euler_numbers`.
    fn constant_mass(&self) -> Option<&[Vec<Value>]> {
        let is_constant = self.euler.solved.as_ref()?.is_constant;
        is_constant.then(|| &self.values[self.euler.results() + 1..])
    }

    /// The values that the increment uses other than by instructions.
    fn used(&self) -> Vec<Value> {
        let rows = match self.constant_mass() {
            Some(_) => self.euler.results() + 1,
            None => self.values.len(),
        };
        self.values[..rows].concat()
    }

    /// The body of the increment, with the solve for the velocity between the statements before and after it.
    fn body(&self, printer: &Printer<'_>, in_lane: bool) -> TokenStream {
        let private = self.private;
        let load = printer.load(&self.used());
        let [noise, state, late] =
            [Tier::Noise, Tier::State, Tier::Iterate(0)].map(|tier| printer.statements(tier));
        let open = self
            .constant_mass()
            .map(|_| quote!(let (prepared, inverse) = prepared;));
        let velocity = self.euler.solved.as_ref().map(|solved| {
            let at = self.euler.results();
            let rhs = printer.array(&self.values[at]);
            let mass = || printer.matrix(&self.values[at + 1..]);
            let v = if solved.is_constant {
                quote!(#private::euler::product(inverse, &#rhs))
            } else if in_lane {
                let mass = mass();
                quote!(#private::lane::solve(&#mass, &#rhs))
            } else {
                let mass = mass();
                quote!(#private::solve(&#mass, &#rhs)?)
            };
            quote!(let v = #v;)
        });
        let field = |rows: &[Vec<Value>]| {
            let (q, p) = (printer.array(&rows[0]), printer.array(&rows[1]));
            quote!(#private::euler::Field { q: #q, p: #p })
        };
        let increment = field(self.values);
        let correction = if self.euler.correction.is_some() {
            let correction = field(&self.values[2..]);
            quote!(::core::option::Option::Some(#correction))
        } else {
            quote!(::core::option::Option::None)
        };
        quote! {
            #open
            #load
            #noise
            #state
            #velocity
            #late
            ::core::option::Option::Some(#private::euler::EulerIncrement {
                increment: #increment,
                correction: #correction,
            })
        }
    }
}
