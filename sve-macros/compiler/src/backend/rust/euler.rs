//! `euler_increment` and `euler_increment_in_lane`: the increment of Euler's method as
//! straight-line code. The explicit baselines consist of such increments.
//!
//! Input: the increment as expressions. Output: items of the implementation of `System`. What
//! depends on parameters and step size alone is computed in `euler_numbers`, with the inverse of a
//! mass matrix that is constant and not diagonal.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::Context;
use super::code::{Place, Printer};
use super::function::{Formulas, record};
use crate::algebra::Expr;
use crate::program::limits::{self, in_lanes};
use crate::program::{Array, Kernel, Operations, Program, Scheduler, Tier, Tiers, Value, entries};
use crate::system::euler::Euler;

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
    context: &Context<'_>,
) -> Option<TokenStream> {
    let arrays = euler.arrays();
    let model = context.model;
    let state = model.q.iter().chain(&model.p).chain([&model.time]);
    let mut tiers: Tiers = state.map(|&s| (s, Tier::State)).collect();
    tiers.extend(model.v.iter().map(|&s| (s, Tier::Iterate(0))));
    let formulas = Formulas {
        symbols: &euler.symbols,
        ..context.formulas()
    };
    let scheduler = Scheduler::new(formulas.arena, formulas.symbols, tiers, &entries(&arrays));
    let kernel = Kernel::new(scheduler, &arrays);
    let length = kernel.program.all().count();
    (length <= limits::EULER).then(|| {
        let writer = Writer {
            euler,
            formulas,
            sizes: context.sizes(),
            kernel: &kernel,
        };
        let function = writer.scalar(length <= limits::EULER_INLINED);
        let stages = in_lanes::EULER / weight(&kernel.program).max(1);
        let in_lane = (has_lanes && stages > 0).then(|| writer.in_lane(stages));
        quote!(#function #in_lane)
    })
}

/// Returns the number of instructions. Calls of functions have a larger weight.
fn weight(program: &Program) -> usize {
    let late = program.all().filter(|(_, i)| i.tier != Tier::Prepare);
    let work = Operations::of(program, |tier| tier != Tier::Prepare);
    late.count() + (limits::CALL - 1) * (work.transcendental + work.angle_additions)
}

impl Euler {
    /// The increments of q and p, their corrections, and the linear system for the velocity.
    fn arrays(&self) -> Vec<Array<Expr>> {
        let mut arrays = vec![Array::vector("dq", &self.dq), Array::vector("dp", &self.dp)];
        if let Some([dq, dp]) = &self.correction {
            arrays.extend([Array::vector("ito_dq", dq), Array::vector("ito_dp", dp)]);
        }
        if let Some(solved) = &self.solved {
            arrays.push(Array::unnamed(&solved.rhs));
            arrays.push(Array::rows("", &solved.mass).without_names());
        }
        arrays
    }

    /// The number of vectors of results.
    fn results(&self) -> usize {
        if self.correction.is_some() { 4 } else { 2 }
    }
}

/// Writes the scheduled increment.
struct Writer<'a> {
    euler: &'a Euler,
    formulas: Formulas<'a>,
    sizes: [Literal; 2],
    kernel: &'a Kernel,
}

impl Writer<'_> {
    /// `euler_numbers` and the increment of a single state.
    fn scalar(&self, is_inlined: bool) -> TokenStream {
        let private = self.formulas.private;
        let mut printer = self.formulas.printer(self.kernel, Place::Single);
        let kept = printer.split_prepared(&self.used());
        let (prepare, array) = (printer.prepare(), printer.array(&kept));
        let ty = self.numbers(kept.len());
        let numbers = match self.constant_mass() {
            Some(mass) => {
                let mass = printer.shaped(mass);
                quote!((#array, #private::euler::inverse(&#mass)?))
            }
            None => array,
        };
        let inline = if is_inlined {
            quote!(#[inline(always)])
        } else {
            quote!(#[inline])
        };
        let function = self.function(&quote!(euler_increment), &ty, &self.body(&printer, false));
        quote! {
            type EulerNumbers = #ty;
            const HAS_EULER_INCREMENT: bool = true;
            #[inline]
            fn euler_numbers(&self, h: f64) -> ::core::option::Option<#ty> {
                #prepare
                ::core::option::Option::Some(#numbers)
            }
            #inline
            #function
        }
    }

    /// The increment of a state in a loop over the lanes.
    fn in_lane(&self, stages: usize) -> TokenStream {
        let stages = Literal::usize_unsuffixed(stages);
        let mut printer = self.formulas.printer(self.kernel, Place::WithinLoop);
        let kept = printer.split_prepared(&self.used());
        let name = quote!(euler_increment_in_lane);
        let ty = self.numbers(kept.len());
        let function = self.function(&name, &ty, &self.body(&printer, true));
        quote! {
            const EULER_STAGES_IN_LANES: usize = #stages;
            #[inline(always)]
            #function
        }
    }

    fn function(
        &self,
        name: &TokenStream,
        numbers: &TokenStream,
        body: &TokenStream,
    ) -> TokenStream {
        let (private, [n, m]) = (self.formulas.private, &self.sizes);
        quote! {
            fn #name(
                &self,
                prepared: &#numbers,
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

    /// The type of what `euler_numbers` returns, which has so many numbers beside the inverse of a
    /// constant mass matrix.
    fn numbers(&self, count: usize) -> TokenStream {
        let (count, [n, _]) = (Literal::usize_unsuffixed(count), &self.sizes);
        match self.constant_mass() {
            Some(_) => quote!(([f64; #count], [[f64; #n]; #n])),
            None => quote!([f64; #count]),
        }
    }

    /// The mass matrix, if it is inverted in `euler_numbers`.
    fn constant_mass(&self) -> Option<&Array<Value>> {
        let is_constant = self.euler.solved.as_ref()?.is_constant;
        self.kernel.arrays.last().filter(|_| is_constant)
    }

    /// The values that the increment uses other than by instructions.
    fn used(&self) -> Vec<Value> {
        let arrays = &self.kernel.arrays;
        let early = usize::from(self.constant_mass().is_some());
        entries(&arrays[..arrays.len() - early])
    }

    /// The body of the increment, with the solve for the velocity between the statements before and
    /// after it.
    fn body(&self, printer: &Printer<'_>, in_lane: bool) -> TokenStream {
        let private = self.formulas.private;
        let load = printer.load(&self.used());
        let [noise, state, late] =
            [Tier::Noise, Tier::State, Tier::Iterate(0)].map(|tier| printer.statements(tier));
        let open = self
            .constant_mass()
            .map(|_| quote!(let (prepared, inverse) = prepared;));
        let arrays: Vec<TokenStream> = (self.kernel.arrays.iter())
            .map(|array| printer.shaped(array))
            .collect();
        let (results, of_velocity) = arrays.split_at(self.euler.results());
        let velocity = match (of_velocity, &self.euler.solved) {
            ([rhs, _], Some(solved)) if solved.is_constant => {
                quote!(let v = #private::euler::product(inverse, &#rhs);)
            }
            ([rhs, mass], _) if in_lane => quote!(let v = #private::lane::solve(&#mass, &#rhs);),
            ([rhs, mass], _) => quote!(let v = #private::solve(&#mass, &#rhs)?;),
            _ => TokenStream::new(),
        };
        let fields = results.chunks(2);
        let mut fields =
            fields.map(|field| record(&quote!(#private::euler::Field), &["q", "p"], field));
        let increment = fields.next();
        let correction = match fields.next() {
            Some(correction) => quote!(::core::option::Option::Some(#correction)),
            None => quote!(::core::option::Option::None),
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
