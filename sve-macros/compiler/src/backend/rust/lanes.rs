//! The step of many states at once, a lane each: loops over the lanes that the compiler turns into vector instructions.
//!
//! Input: a scheme. Output: `increment_lanes`, or nothing for a system that is too large for it. Invariant: no
//! branches within a loop; what leaves the fast path is marked, and stepped by `increment`.
//!
//! The code is cut into loops where an iteration begins and ends. A value that a later loop needs is stored in an array over
//! the lanes, a row of `kept`.

use std::collections::BTreeMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::code::Printer;
use super::solve::{accepted, names, sum_of_stages};
use super::step::inside;
use super::values::{Chosen, Newton, Solve, Step, System};
use crate::algebra::Arena;
use crate::program::{Operation, Tier, Value, operands};
use crate::structure::{Block, Form, Iteration, Judge, Linear, Scheme, Solution};
use crate::system::model::{Meaning, Symbols};

/// Unknowns of a block up to which it is solved in lanes.
const UNKNOWNS: usize = 6;

/// Instructions up to which a step is written for lanes: beyond, its values fit neither registers nor the first cache.
const INSTRUCTIONS: usize = 1500;

/// Values kept between loops, likewise.
const KEPT: usize = 96;

/// `increment_lanes` of a scheme with so many noises.
pub(super) fn lanes(
    scheme: &Scheme,
    noises: usize,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> Option<TokenStream> {
    if !scheme.blocks.iter().all(fits) {
        return None;
    }
    let chosen = Chosen {
        start,
        bounds: Judge::full,
    };
    let step = Step::new(scheme, chosen, symbols, arena);
    if step.program.all().count() > INSTRUCTIONS {
        return None;
    }
    let plan = Loops::new(scheme, &step);
    if plan.rows.len() > KEPT {
        return None;
    }
    let printer = Printer::of_lanes(&step.program, symbols, &step.labels, private);
    let writer = Writer {
        scheme,
        step: &step,
        loops: &plan,
        printer: &printer,
        symbols,
        private,
    };
    let body = writer.body();
    let [n, m] = [scheme.dq.len(), noises].map(Literal::usize_unsuffixed);
    Some(quote! {
        #[inline(always)]
        fn increment_lanes(
            &self,
            _: &Self::Prepared,
            states: &#private::lane::StateLanes<#n>,
            next: &mut #private::lane::StateLanes<#n>,
            h: f64,
            dw: &[#private::lane::Lane; #m],
            newton: &#private::Newton,
        ) -> #private::lane::Mask {
            #body
        }
    })
}

/// Whether a block is small and dense, and its solution judged where it is iterated: only the scalar step can follow a solution.
fn fits(block: &Block) -> bool {
    let is_judged = match &block.solution {
        Solution::Formula(_) | Solution::System { .. } => true,
        Solution::Iteration(iteration) => iteration.judge.is_some(),
    };
    is_judged && block.band.is_none() && block.unknowns.len() <= UNKNOWNS
}

/// What the iteration starts from. That of a single unknown is worth a division, since a lane waits for the slowest of all:
/// the linearly implicit step is second order in h, and two evaluations are enough mostly.
fn start(iteration: &Iteration) -> &Linear {
    if iteration.iterates.len() == 1 {
        &iteration.fallback
    } else {
        &iteration.guess
    }
}

/// Which loop computes and which one uses a value. The loops are numbered in order: 0 up to the first iteration, 1 the
/// iteration, 2 from there to the next, …
struct Loops {
    /// The loop before or at which each block stands.
    of_block: Vec<usize>,
    /// For each loop, the values of earlier ones that it uses, in order.
    uses: Vec<Vec<Value>>,
    /// Their rows in `kept`; inputs are read again.
    rows: BTreeMap<Value, usize>,
}

impl Loops {
    fn new(scheme: &Scheme, step: &Step) -> Self {
        let mut of_block = Vec::new();
        let mut current = 0;
        for block in &scheme.blocks {
            of_block.push(current);
            if matches!(block.solution, Solution::Iteration(_)) {
                current += 2;
            }
        }
        let mut loops = Self {
            of_block,
            uses: vec![Vec::new(); current + 1],
            rows: BTreeMap::new(),
        };
        for (_, instruction) in step.program.all() {
            let user = loops.of_tier(instruction.tier, scheme);
            for operand in operands(instruction.operation) {
                loops.note(operand, user, scheme, step);
            }
        }
        for (at, solve) in step.solves.iter().enumerate() {
            let begin = loops.of_block[at];
            for value in solve.begin() {
                loops.note(value, Some(begin), scheme, step);
            }
            for value in solve.iterate() {
                loops.note(value, Some(begin + 1), scheme, step);
            }
        }
        for (at, solve) in step.solves.iter().enumerate() {
            let end = loops.of_block[at] + 2;
            for value in solve.judge() {
                loops.note(value, Some(end), scheme, step);
            }
        }
        let domain = step.domain.iter().map(|c| &c.0);
        for &value in step.dq.iter().chain(&step.dp).chain(domain) {
            loops.note(value, Some(current), scheme, step);
        }
        for uses in &mut loops.uses {
            uses.sort_unstable();
            uses.dedup();
        }
        loops
    }

    /// The loop in which values of a tier are computed; none where they are before all lanes.
    fn of_tier(&self, tier: Tier, scheme: &Scheme) -> Option<usize> {
        let iterates = |at: usize| matches!(scheme.blocks[at].solution, Solution::Iteration(_));
        let after = |at: usize| if iterates(at) { 2 } else { 0 };
        match tier {
            Tier::Prepare => None,
            Tier::Noise | Tier::State => Some(0),
            Tier::Guess(at) => Some(self.of_block[at]),
            Tier::Iterate(at) => Some(self.of_block[at] + 1),
            Tier::Solved(at) => Some(self.of_block[at] + after(at)),
        }
    }

    /// Notes that a loop uses a value.
    fn note(&mut self, value: Value, user: Option<usize>, scheme: &Scheme, step: &Step) {
        let instruction = step.program.get(value);
        let (Some(user), Some(computed)) = (user, self.of_tier(instruction.tier, scheme)) else {
            return;
        };
        if user == computed || matches!(instruction.operation, Operation::Constant(_)) {
            return;
        }
        self.uses[user].push(value);
        let next = self.rows.len();
        self.rows.entry(value).or_insert(next);
    }
}

/// Writes the loops.
struct Writer<'a> {
    scheme: &'a Scheme,
    step: &'a Step,
    loops: &'a Loops,
    printer: &'a Printer<'a>,
    symbols: &'a Symbols,
    private: &'a TokenStream,
}

impl Writer<'_> {
    fn body(&self) -> TokenStream {
        let (private, printer) = (self.private, self.printer);
        let rows = Literal::usize_unsuffixed(self.loops.rows.len());
        let prepare = printer.statements(Tier::Prepare);
        let mut tokens = quote! {
            #prepare
            let mut kept = #private::lane::rows::<#rows>();
        };
        let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
        let mut section = quote!(#(#start)*);
        for (at, (solve, block)) in self.step.solves.iter().zip(&self.scheme.blocks).enumerate() {
            let after = printer.statements(Tier::Solved(at));
            match (solve, &block.solution) {
                (Solve::System(system), Solution::System { solved, .. }) => {
                    let solved = names(solved, self.symbols);
                    let solution = self.solution(system, &system.rhs);
                    section.extend(quote!(let #solved = #solution; #after));
                }
                (Solve::Iteration(newton), Solution::Iteration(iteration)) => {
                    let (course, guess) = (course(at), self.guess(at, newton, iteration));
                    let limit = self.limit(newton, iteration);
                    section.extend(quote!(#course.start(lane, #guess, #limit);));
                    let size = Literal::usize_unsuffixed(iteration.iterates.len());
                    let one = self.one(self.loops.of_block[at], &section);
                    let iterate = self.iterate(at, newton, iteration);
                    tokens.extend(quote! {
                        let mut #course = #private::lane::NewtonLanes::<#size>::new(newton);
                        #one
                        #iterate
                    });
                    let solved = names(&iteration.solved, self.symbols);
                    let judge = self.judge(&course, newton, iteration);
                    section = match judge {
                        Some([limits, judge]) => {
                            quote!(let #solved = #course.point(lane); #limits #after #judge)
                        }
                        None => quote!(let #solved = #course.point(lane); #after),
                    };
                }
                _ => section.extend(after),
            }
        }
        section.extend(self.advance());
        let last = self.one(self.loops.uses.len() - 1, &section);
        let (solved, _) = self.solved();
        quote! {
            #tokens
            let mut any = 0u64;
            #last
            next.restore_unsolved(states, any, |lane| #solved)
        }
    }

    /// A loop over the lanes: what it takes from earlier ones, its statements, what it keeps for later ones.
    fn one(&self, number: usize, statements: &TokenStream) -> TokenStream {
        let private = self.private;
        let take = self.loops.uses[number].iter().map(|&value| {
            let instruction = self.step.program.get(value);
            if self.is_read_again(value) {
                return self.printer.statement(value, instruction.operation);
            }
            let (name, row) = (self.printer.operand(value), self.row(value));
            quote!(let #name = kept.0[#row][lane];)
        });
        let keep = self.loops.rows.keys().filter_map(|&value| {
            let tier = self.step.program.get(value).tier;
            let computed = self.loops.of_tier(tier, self.scheme) == Some(number);
            let (name, row) = (self.printer.operand(value), self.row(value));
            (computed && !self.is_read_again(value)).then(|| quote!(kept.0[#row][lane] = #name;))
        });
        quote! {
            for lane in 0..#private::lane::LANES {
                #(#take)*
                #statements
                #(#keep)*
            }
        }
    }

    fn row(&self, value: Value) -> Literal {
        Literal::usize_unsuffixed(self.loops.rows.get(&value).copied().unwrap_or_default())
    }

    /// Whether a value is an input that each loop can read: a state is not changed before the last one.
    fn is_read_again(&self, value: Value) -> bool {
        match self.step.program.get(value).operation {
            Operation::Input(symbol) => !matches!(
                self.symbols.meaning(symbol),
                Meaning::Unknown(_) | Meaning::Limit(_)
            ),
            _ => false,
        }
    }

    fn solution(&self, system: &System, rhs: &[Value]) -> TokenStream {
        let private = self.private;
        let (matrix, rhs) = (
            self.printer.matrix(&system.matrix.rows),
            self.printer.array(rhs),
        );
        quote!(#private::lane::solve(&#matrix, &#rhs))
    }

    fn guess(&self, at: usize, newton: &Newton, iteration: &Iteration) -> TokenStream {
        let guess = &newton.guess;
        let first = self.solution(guess, &guess.rhs);
        let (Some(rhs), Some(refinement)) = (&newton.refinement, &iteration.refinement) else {
            return first;
        };
        let names = names(&refinement.first, self.symbols);
        let statements = self.printer.statements(Tier::Guess(at));
        let more = self.solution(guess, rhs);
        let sum = sum_of_stages(refinement.first.len());
        quote!({
            let guess = #first;
            let #names = guess;
            #statements
            let refinement = #more;
            #sum
        })
    }

    /// The limit of no noise and h → 0, where it is asked for.
    fn limit(&self, newton: &Newton, iteration: &Iteration) -> TokenStream {
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        match &newton.judge {
            None => quote!([f64::NAN; #size]),
            Some(verdict) => {
                let rhs = verdict.limit_rhs.as_ref().unwrap_or(&newton.guess.rhs);
                let matrix = newton.origin.as_ref().unwrap_or(&newton.guess.matrix);
                let (matrix, rhs) = (self.printer.matrix(&matrix.rows), self.printer.array(rhs));
                let private = self.private;
                quote!(#private::lane::solve(&#matrix, &#rhs))
            }
        }
    }

    /// Names of the limit, and the test of a solution.
    fn judge(
        &self,
        course: &Ident,
        newton: &Newton,
        iteration: &Iteration,
    ) -> Option<[TokenStream; 2]> {
        let verdict = newton.judge.as_ref()?;
        let limit = names(&iteration.judge.as_ref()?.limit, self.symbols);
        let accepted = accepted(verdict, self.printer, self.private);
        Some([
            quote!(let #limit = #course.limit(lane);),
            quote!(#course.accept(lane, #accepted);),
        ])
    }

    fn iterate(&self, at: usize, newton: &Newton, iteration: &Iteration) -> TokenStream {
        let (private, printer) = (self.private, self.printer);
        let Newton {
            guess: _,
            origin: _,
            refinement: _,
            residual,
            magnitude,
            jacobian,
            curvature,
            judge: _,
        } = newton;
        let course = course(at);
        let iterates = names(&iteration.iterates, self.symbols);
        let statements = printer.statements(Tier::Iterate(at));
        let (residual, magnitude) = (printer.array(residual), printer.array(magnitude));
        let jacobian = printer.matrix(&jacobian.rows);
        let curvature = curvature.map_or_else(|| quote!(f64::NAN), |c| printer.operand(c));
        let body = quote! {
            let #iterates = #course.point(lane);
            #statements
            #course.update(lane, &#private::Evaluation {
                residual: #residual,
                magnitude: #magnitude,
                jacobian: #jacobian,
                curvature: #curvature,
            });
        };
        let body = self.one(self.loops.of_block[at] + 1, &body);
        quote!(while #course.next_iteration() { #body })
    }

    /// The new state of a lane.
    fn advance(&self) -> TokenStream {
        let (dq, dp) = (&self.step.dq, &self.step.dp);
        let new = |row: &TokenStream, values: &[Value]| {
            let entries = values.iter().enumerate().map(|(i, &value)| {
                let (i, value) = (Literal::usize_unsuffixed(i), self.printer.operand(value));
                match self.scheme.form {
                    Form::Increment => quote!(states.#row[#i][lane] + #value),
                    Form::State => quote!(#value),
                }
            });
            quote!([#(#entries),*])
        };
        let (q, p) = (new(&quote!(q), dq), new(&quote!(p), dp));
        let (solved, domain) = self.solved();
        // a state outside of the domain of L is none
        let poison = (!self.step.domain.is_empty()).then(|| {
            let n = Literal::usize_unsuffixed(dq.len());
            quote!(let p_lane = if true #domain { p_lane } else { [f64::NAN; #n] };)
        });
        let store = |row: &str| {
            let (row, new) = (format_ident!("{row}"), format_ident!("{row}_lane"));
            (0..dq.len()).map(move |i| {
                let i = Literal::usize_unsuffixed(i);
                quote!(next.#row[#i][lane] = #new[#i];)
            })
        };
        let (store_q, store_p) = (store("q"), store("p"));
        let private = self.private;
        quote! {
            let q_lane = #q;
            let p_lane = #p;
            #poison
            #(#store_q)*
            #(#store_p)*
            any |= #private::lane::needs_scalar_step(q_lane, p_lane, #solved);
        }
    }

    /// Whether all iterations of a lane arrived, and, where the values are at hand, whether L is defined there.
    fn solved(&self) -> (TokenStream, TokenStream) {
        let iterations = self.scheme.blocks.iter().enumerate();
        let arrived = iterations.filter_map(|(at, block)| {
            let course = course(at);
            matches!(block.solution, Solution::Iteration(_))
                .then(|| quote!(& #course.has_converged(lane)))
        });
        let domain = self.step.domain.iter().map(|&(value, is_closed)| {
            let holds = inside(&self.printer.operand(value), is_closed);
            quote!(& (#holds))
        });
        (quote!(true #(#arrived)*), quote!(#(#domain)*))
    }
}

/// The iteration of a block.
fn course(at: usize) -> Ident {
    format_ident!("course_{at}")
}
