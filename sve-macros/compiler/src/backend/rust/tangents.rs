//! `linearise_lanes`: tangent vectors of many states at once, carried along a step that was solved
//! in lanes.
//!
//! Input: the linearised step. Output: the function, or nothing for a system that is too large for
//! it, or has constraints. A first loop over the lanes evaluates the entries of the linearised step
//! and the inverse of ∂R/∂x; entries that depend on parameters and step size alone are computed
//! before it. For each tangent vector a further loop over the lanes multiplies the vector by the
//! entries, without branches. Vectors that are not finite are left to `linearise`.

use std::collections::BTreeMap;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::Context;
use super::axis::Axis;
use super::code::{Place, Printer};
use super::lanes::stores;
use super::solve::names;
use crate::derivation::Derived;
use crate::linearise::{Entry, Linearisation};
use crate::model::Symbols;
use crate::program::limits::in_lanes;
use crate::program::{Array, Kernel, Operation, Program, Scheduler, Tier, Tiers, Value, entries};
use crate::structure::{Returns, Scheme};

/// Returns the function, unless the step has constraints or intermediate values, or takes too many
/// operations.
pub(super) fn linearise_lanes(context: &Context<'_>, derived: &Derived) -> Option<TokenStream> {
    let Derived {
        scheme,
        linearisation,
        symbols,
        ..
    } = derived;
    let unknowns = linearisation.unknowns.len();
    let is_split = linearisation.through.is_some();
    if scheme.is_constrained() || is_split || unknowns > in_lanes::UNKNOWNS {
        return None;
    }
    let formulas = context.formulas_of(derived);
    let tiers: Tiers = (linearisation.unknowns.iter())
        .map(|&symbol| (symbol, Tier::Solved(0)))
        .collect();
    let arrays = linearisation.matrices.each_ref().map(|matrix| {
        let entries = matrix.iter().map(|entry| entry.value);
        Array::unnamed(&entries.collect::<Vec<_>>())
    });
    let mut scheduler = Scheduler::new(formulas.arena, symbols, tiers, &entries(&arrays));
    scheduler.disable_angle_addition();
    let kernel = Kernel::new(scheduler, &arrays);
    let kept = Kept::new(&kernel, unknowns);
    if kernel.program.all().count() > in_lanes::INSTRUCTIONS || kept.count > in_lanes::KEPT {
        return None;
    }
    let private = context.private;
    let matrices = linearisation.matrices.iter().zip(&kernel.arrays);
    let writer = Writer {
        private,
        printer: &formulas.printer(&kernel, Place::Over(Axis::Lanes)),
        linearisation,
        kept,
        program: &kernel.program,
        matrices: matrices
            .map(|(matrix, values)| matrix.iter().zip(values.entries()).collect())
            .collect(),
        is_increment: scheme.returns != Returns::State,
    };
    let evaluate = writer.evaluate(symbols);
    let carry = writer.carry(context.model.dof());
    let ([n, m], k) = (context.sizes(), Literal::usize_unsuffixed(unknowns));
    Some(quote! {
        #[inline(always)]
        fn linearise_lanes(
            &self,
            states: &#private::lane::StateLanes<#n>,
            h: f64,
            dw: &[#private::lane::Lane; #m],
            unknowns: &#private::lane::Aligned<[#private::lane::Lane; #k]>,
            tangents: #private::lane::LaneDirections<'_, #private::lane::TangentLanes<#n>>,
        ) -> #private::lane::Mask {
            #evaluate
            #carry
        }
    })
}

/// Binds the unknowns of a block that a step in lanes has solved, and stores them for the
/// linearised step. They follow the unknowns of the blocks before it.
pub(super) fn bound<T, R>(
    scheme: &Scheme<T, R>,
    at: usize,
    solution: &TokenStream,
    symbols: &Symbols,
) -> TokenStream {
    let names = names(scheme.blocks[at].solution.solved(), symbols);
    let before = scheme.blocks[..at].iter();
    let first: usize = before.map(|block| block.solution.solved().len()).sum();
    let first = Literal::usize_unsuffixed(first);
    quote!(let #names = #solution; unknowns.keep(lane, #first, #names);)
}

/// The entries of the four matrices, as values.
type Entries<'a> = Vec<(&'a Entry, Value)>;

/// The rows that the first loop keeps for the later ones.
struct Kept {
    /// The row of each entry that differs from lane to lane.
    rows: BTreeMap<Value, usize>,
    /// The first row of the inverse of ∂R/∂x, if it differs from lane to lane.
    inverse: Option<usize>,
    count: usize,
}

impl Kept {
    fn new(kernel: &Kernel, unknowns: usize) -> Self {
        let mut rows = BTreeMap::new();
        let is_in_lanes = |value: &Value| is_in_lanes(&kernel.program, *value);
        for value in entries(&kernel.arrays[1..]).into_iter().filter(is_in_lanes) {
            let next = rows.len();
            rows.entry(value).or_insert(next);
        }
        let inverse = kernel.arrays[0].entries().any(|value| is_in_lanes(&value));
        let count = rows.len() + usize::from(inverse) * unknowns * unknowns;
        Self {
            inverse: inverse.then_some(rows.len()),
            rows,
            count,
        }
    }
}

/// Returns whether a value differs from lane to lane.
fn is_in_lanes(program: &Program, value: Value) -> bool {
    let instruction = program.get(value);
    instruction.tier != Tier::Prepare && !matches!(instruction.operation, Operation::Constant(_))
}

/// Writes the loops.
struct Writer<'a> {
    private: &'a TokenStream,
    printer: &'a Printer<'a>,
    linearisation: &'a Linearisation,
    kept: Kept,
    program: &'a Program,
    matrices: Vec<Entries<'a>>,
    /// True if the results are differences to the state at the start, whose derivative is added.
    is_increment: bool,
}

impl Writer<'_> {
    /// The statements that evaluate the entries of the linearised step.
    fn evaluate(&self, symbols: &Symbols) -> TokenStream {
        let (private, printer) = (self.private, self.printer);
        let prepare = printer.statements(Tier::Prepare);
        let unknowns = self.linearisation.unknowns.len();
        let inverse = (unknowns > 0).then(|| {
            let matrix = self.residual_by_unknowns();
            quote!(let inverse = #private::lane::regular_inverse(&#matrix);)
        });
        if self.kept.count == 0 {
            return quote!(#prepare #inverse);
        }
        let statements = [Tier::Noise, Tier::State, Tier::Solved(0)].map(|t| printer.statements(t));
        let solved = (unknowns > 0).then(|| {
            let pattern = names(&self.linearisation.unknowns, symbols);
            let solution = Axis::Lanes.entries(&quote!(unknowns.0), unknowns);
            quote!(let #pattern = #solution;)
        });
        let entries = self.kept.rows.iter().map(|(&value, &row)| {
            let (value, kept) = (printer.operand(value), Axis::Lanes.kept(row));
            quote!(#kept = #value;)
        });
        let of_inverse = self.kept.inverse.into_iter().flat_map(|first| {
            (0..unknowns * unknowns).map(move |at| {
                let kept = Axis::Lanes.kept(first + at);
                let [i, j] = [at / unknowns, at % unknowns].map(Literal::usize_unsuffixed);
                quote!(#kept = inverse[#i][#j];)
            })
        });
        let (early, late) = match self.kept.inverse {
            None => (inverse, None),
            Some(_) => (None, inverse),
        };
        let rows = Literal::usize_unsuffixed(self.kept.count);
        let body = quote!(#solved #(#statements)* #late #(#entries)* #(#of_inverse)*);
        let sweep = Axis::Lanes.sweep(&body, private);
        let given = Axis::inputs(symbols, private);
        quote! {
            #prepare
            #given
            #early
            let mut kept = #private::lane::rows::<#rows>();
            #sweep
        }
    }

    /// The matrix ∂R/∂x.
    fn residual_by_unknowns(&self) -> TokenStream {
        let unknowns = self.linearisation.unknowns.len();
        let mut rows = vec![vec![quote!(0f64); unknowns]; unknowns];
        for &(entry, value) in &self.matrices[0] {
            rows[entry.row][entry.column] = self.printer.operand(value);
        }
        let rows = rows.iter().map(|row| quote!([#(#row),*]));
        quote!([#(#rows),*])
    }

    /// An entry, in a loop over the lanes.
    fn entry(&self, value: Value) -> TokenStream {
        if !is_in_lanes(self.program, value) {
            return self.printer.operand(value);
        }
        Axis::Lanes.kept(self.kept.rows[&value])
    }

    /// The loop over the tangent vectors, and the mask of the lanes where one is not finite.
    fn carry(&self, n: usize) -> TokenStream {
        let private = self.private;
        let unknowns = self.linearisation.unknowns.len();
        let by_inputs = &self.matrices[1];
        let rhs = (0..unknowns).map(|row| {
            let terms = of_row(by_inputs, row).map(|(entry, value)| {
                let (value, input) = (self.entry(value), input(entry.column, n));
                quote!(+ #value * #input)
            });
            quote!(0f64 #(#terms)*)
        });
        let solution = (0..unknowns).map(|i| {
            let terms = (0..unknowns).map(|j| {
                let inverse = self.inverse(i, j);
                let j = Literal::usize_unsuffixed(j);
                quote!(+ #inverse * rhs[#j])
            });
            quote!(0f64 #(#terms)*)
        });
        let solve = (unknowns > 0).then(|| {
            quote! {
                let rhs = [#(#rhs),*];
                let solution = [#(#solution),*];
            }
        });
        let result = |row: usize| self.result(row, n);
        let (q, p) = ((0..n).map(result), (n..2 * n).map(result));
        let [store_q, store_p] = stores(n);
        let [outputs, inputs] = [self.linearisation.outputs, self.linearisation.inputs];
        let has_seeds = (self.matrices.iter().skip(1).flatten())
            .any(|(entry, _)| entry.column >= outputs && inputs > outputs);
        let parameters = Literal::usize_unsuffixed(inputs - outputs);
        let seeds =
            has_seeds.then(|| quote!(let seeds = #private::lane::seeds::<#parameters>(*varied);));
        let varied = if has_seeds { quote!(varied) } else { quote!(_) };
        let body = quote! {
            #solve
            let q_lane = [#(#q),*];
            let p_lane = [#(#p),*];
            #store_q
            #store_p
            any |= #private::lane::needs_scalar_step(q_lane, p_lane, true);
        };
        let sweep = Axis::Lanes.sweep(&body, private);
        quote! {
            let mut any = 0u64;
            let pairs = ::core::iter::Iterator::zip(tangents.start.iter(), tangents.next.iter_mut());
            for ((start, next), #varied) in ::core::iter::Iterator::zip(pairs, tangents.parameters) {
                #seeds
                #sweep
            }
            #private::lane::unfinished(any, tangents.next)
        }
    }

    /// An entry of the inverse of ∂R/∂x, in a loop over the lanes.
    fn inverse(&self, i: usize, j: usize) -> TokenStream {
        let unknowns = self.linearisation.unknowns.len();
        match self.kept.inverse {
            Some(first) => Axis::Lanes.kept(first + i * unknowns + j),
            None => {
                let [i, j] = [i, j].map(Literal::usize_unsuffixed);
                quote!(inverse[#i][#j])
            }
        }
    }

    /// A component of the vector after the step: ∂y/∂z of the vector before it, less ∂y/∂x of the
    /// solution. The terms have the order of `linearise`.
    fn result(&self, row: usize, n: usize) -> TokenStream {
        let (by_unknowns, by_inputs) = (&self.matrices[2], &self.matrices[3]);
        let first = if self.is_increment {
            input(row, n)
        } else {
            quote!(0f64)
        };
        let direct = of_row(by_inputs, row).map(|(entry, value)| {
            let (value, input) = (self.entry(value), input(entry.column, n));
            quote!(+ #value * #input)
        });
        let through_unknowns = of_row(by_unknowns, row).map(|(entry, value)| {
            let (value, j) = (self.entry(value), Literal::usize_unsuffixed(entry.column));
            quote!(- #value * solution[#j])
        });
        quote!(#first #(#direct)* #(#through_unknowns)*)
    }
}

/// The entries of a row.
fn of_row<'a>(entries: &'a Entries<'a>, row: usize) -> impl Iterator<Item = (&'a Entry, Value)> {
    let entries = entries.iter().copied();
    entries.filter(move |(entry, _)| entry.row == row)
}

/// A component of the vector before the step, or the derivative of a parameter.
fn input(column: usize, n: usize) -> TokenStream {
    if column < n {
        Axis::Lanes.entry(&quote!(start.q), column)
    } else if column < 2 * n {
        Axis::Lanes.entry(&quote!(start.p), column - n)
    } else {
        let i = Literal::usize_unsuffixed(column - 2 * n);
        quote!(seeds[#i])
    }
}
