//! `impl Variational<Rule>`: the step and its plan.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::code::{Printer, input_name};
use super::{attributes, private};
use crate::action::Action;
use crate::mechanics::Mechanics;
use crate::model::{Model, Symbols};
use crate::parse::Annotated;
use crate::rule::Rule;
use crate::schedule::{Operation, Program, Scheduler, Tier, Tiers, Value};
use crate::structure::{Block, Form, Iteration, Kind, Scheme, Solution};
use crate::symbolic::{Arena, Expr, Symbol};

/// A block with values for expressions.
enum Solve {
    Formula,
    System {
        matrix: Vec<Vec<Value>>,
        rhs: Vec<Value>,
        solved: Vec<Symbol>,
    },
    Iteration {
        guess: (Vec<Vec<Value>>, Vec<Value>),
        residual: Vec<Value>,
        magnitude: Vec<Value>,
        jacobian: Vec<Vec<Value>>,
        iterates: Vec<Symbol>,
        solved: Vec<Symbol>,
    },
}

/// A step with values for expressions.
struct Scheduled {
    solves: Vec<Solve>,
    dq: Vec<Value>,
    dp: Vec<Value>,
    /// Every value that is used other than by an instruction.
    results: Vec<Value>,
    program: Program,
}

#[allow(clippy::too_many_arguments)] // every stage's output is read here, and nowhere after
pub(crate) fn rule(
    rule: Rule,
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    action: &Action,
    scheme: &Scheme,
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let (private, attributes) = (private(block), attributes());
    let runtime = &block.arguments.runtime;
    let rule_type = format_ident!("{}", rule.type_name());
    let self_ty = &block.item.self_ty;
    let n = Literal::usize_unsuffixed(model.dof());
    let m = Literal::usize_unsuffixed(model.noises.len());

    let scheduled = schedule(scheme, symbols, arena);
    let mut printer = Printer::new(&scheduled.program, symbols, &private);
    let kept = printer.split_prepared(&scheduled.results);
    let prepared = Literal::usize_unsuffixed(kept.len());
    let (prepare, kept) = (printer.prepare(), printer.array(&kept));
    let body = body(&private, &printer, &scheduled, symbols);
    let plan = plan(
        &private,
        rule,
        block,
        model,
        mechanics,
        scheme,
        &scheduled.program,
        symbols,
    );
    let returns_state = scheme.form == Form::State;
    let doc = doc(action, symbols, arena);
    quote! {
        #attributes
        impl #private::Variational<#runtime::#rule_type> for #self_ty {
            type Prepared = [f64; #prepared];
            const PLAN: &'static #private::Plan = &#plan;
            const RETURNS_STATE: bool = #returns_state;
            #[inline]
            fn prepare(&self, h: f64) -> [f64; #prepared] {
                #prepare
                #kept
            }
            #[doc = #doc]
            #[inline]
            fn increment(
                &self,
                prepared: &[f64; #prepared],
                state: &#private::State<#n>,
                h: f64,
                dw: &[f64; #m],
                newton: &#private::Newton,
            ) -> ::core::result::Result<([f64; #n], [f64; #n]), #private::SolveError> {
                #body
            }
        }
    }
}

fn schedule(scheme: &Scheme, symbols: &Symbols, arena: &Arena) -> Scheduled {
    let Scheme {
        blocks,
        dq,
        dp,
        form: _,
    } = scheme;
    let mut tiers = Tiers::new();
    let mut all: Vec<Expr> = [dq.as_slice(), dp].concat();
    for (at, block) in blocks.iter().enumerate() {
        match &block.solution {
            Solution::Formula => {}
            Solution::System {
                matrix,
                rhs,
                solved,
            } => {
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                all.extend(matrix.iter().flatten().chain(rhs));
            }
            Solution::Iteration(iteration) => {
                let Iteration {
                    guess_matrix,
                    guess_rhs,
                    residual,
                    jacobian,
                    iterates,
                    solved,
                } = &**iteration;
                tiers.extend(iterates.iter().map(|&s| (s, Tier::Iterate(at))));
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                all.extend(
                    guess_matrix
                        .iter()
                        .chain(jacobian)
                        .flatten()
                        .chain(guess_rhs)
                        .chain(residual),
                );
            }
        }
    }
    let mut scheduler = Scheduler::new(arena, symbols, tiers, &all);
    let mut solves = Vec::new();
    for block in blocks {
        let mut matrix = |rows: &[Vec<Expr>]| -> Vec<Vec<Value>> {
            rows.iter().map(|row| scheduler.values(row)).collect()
        };
        solves.push(match &block.solution {
            Solution::Formula => Solve::Formula,
            Solution::System {
                matrix: a,
                rhs,
                solved,
            } => {
                let a = matrix(a);
                Solve::System {
                    matrix: a,
                    rhs: scheduler.values(rhs),
                    solved: solved.clone(),
                }
            }
            Solution::Iteration(iteration) => {
                let (guess_matrix, jacobian) =
                    (matrix(&iteration.guess_matrix), matrix(&iteration.jacobian));
                let (residual, magnitude) = iteration
                    .residual
                    .iter()
                    .map(|&r| scheduler.residual(r))
                    .unzip();
                Solve::Iteration {
                    guess: (guess_matrix, scheduler.values(&iteration.guess_rhs)),
                    residual,
                    magnitude,
                    jacobian,
                    iterates: iteration.iterates.clone(),
                    solved: iteration.solved.clone(),
                }
            }
        });
    }
    let (dq, dp) = (scheduler.values(dq), scheduler.values(dp));
    let results = roots(&solves, &dq, &dp);
    Scheduled {
        program: scheduler.finish(&results),
        solves,
        dq,
        dp,
        results,
    }
}

/// Every value that is used other than by an instruction.
fn roots(solves: &[Solve], dq: &[Value], dp: &[Value]) -> Vec<Value> {
    let mut roots = [dq, dp].concat();
    for solve in solves {
        match solve {
            Solve::Formula => {}
            Solve::System {
                matrix,
                rhs,
                solved: _,
            } => roots.extend(matrix.iter().flatten().chain(rhs)),
            Solve::Iteration {
                guess,
                residual,
                magnitude,
                jacobian,
                iterates: _,
                solved: _,
            } => {
                roots.extend(
                    guess
                        .0
                        .iter()
                        .chain(jacobian)
                        .flatten()
                        .chain(&guess.1)
                        .chain(residual)
                        .chain(magnitude),
                );
            }
        }
    }
    roots
}

/// The body of `increment`.
fn body(
    private: &TokenStream,
    printer: &Printer<'_>,
    scheduled: &Scheduled,
    symbols: &Symbols,
) -> TokenStream {
    let Scheduled {
        solves,
        dq,
        dp,
        results,
        program,
    } = scheduled;
    let load = printer.load(results);
    let time = program
        .all()
        .any(|(_, i)| matches!(i.operation, Operation::Input(s) if matches!(symbols.meaning(s), crate::model::Meaning::Time)))
        .then(|| quote!(let time = state.t;));
    let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
    let blocks = solves.iter().enumerate().map(|(at, solve)| {
        let solve = solve_tokens(private, printer, at, solve, symbols);
        let after = printer.statements(Tier::Solved(at));
        quote!(#solve #after)
    });
    let (dq, dp) = (printer.array(dq), printer.array(dp));
    quote! {
        #load
        #time
        #(#start)*
        #(#blocks)*
        ::core::result::Result::Ok((#dq, #dp))
    }
}

fn solve_tokens(
    private: &TokenStream,
    printer: &Printer<'_>,
    at: usize,
    solve: &Solve,
    symbols: &Symbols,
) -> TokenStream {
    let names = |list: &[Symbol]| {
        let names = list.iter().map(|&s| input_name(symbols, s));
        quote!([#(#names),*])
    };
    match solve {
        Solve::Formula => TokenStream::new(),
        Solve::System {
            matrix,
            rhs,
            solved,
        } => {
            let (matrix, rhs, solved) = (printer.matrix(matrix), printer.array(rhs), names(solved));
            quote! {
                let #solved = match #private::solve(&#matrix, &#rhs) {
                    ::core::option::Option::Some(solution) => solution,
                    ::core::option::Option::None => {
                        return ::core::result::Result::Err(#private::SolveError::Singular { iteration: 0 });
                    }
                };
            }
        }
        Solve::Iteration {
            guess,
            residual,
            magnitude,
            jacobian,
            iterates,
            solved,
        } => {
            let size = Literal::usize_unsuffixed(iterates.len());
            let (guess_matrix, guess_rhs) = (printer.matrix(&guess.0), printer.array(&guess.1));
            let (residual, magnitude, jacobian) = (
                printer.array(residual),
                printer.array(magnitude),
                printer.matrix(jacobian),
            );
            let (iterates, solved) = (names(iterates), names(solved));
            let statements = printer.statements(Tier::Iterate(at));
            quote! {
                let guess = match #private::solve(&#guess_matrix, &#guess_rhs) {
                    ::core::option::Option::Some(guess) => guess,
                    ::core::option::Option::None => [0.0; #size],
                };
                let #solved = newton.solve(guess, |&#iterates: &[f64; #size]| {
                    #statements
                    #private::Evaluation { residual: #residual, magnitude: #magnitude, jacobian: #jacobian }
                })?;
            }
        }
    }
}

#[allow(clippy::too_many_arguments)] // as above
fn plan(
    private: &TokenStream,
    rule: Rule,
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    scheme: &Scheme,
    program: &Program,
    symbols: &Symbols,
) -> TokenStream {
    let self_ty = &block.item.self_ty;
    let system = quote!(#self_ty).to_string();
    let (name, order) = (rule.attribute_name(), rule.deterministic_order());
    let (n, m) = (model.dof(), model.noises.len());
    let strong = match &mechanics.clash {
        _ if m == 0 => quote!(Deterministic),
        None => quote!(One),
        Some((a, b)) => quote!(Half { pair: (#a, #b) }),
    };
    let blocks = scheme.blocks.iter().map(|Block { kind, unknowns, nonzeros, solution: _ }| {
        let kind = match kind {
            Kind::Explicit => quote!(Explicit),
            Kind::Linear => quote!(Linear),
            Kind::Newton => quote!(Newton),
        };
        let unknowns = unknowns.iter().map(|&u| symbols.name(u));
        quote!(#private::Block { kind: #private::BlockKind::#kind, unknowns: &[#(#unknowns),*], nonzeros: #nonzeros })
    });
    let count = |wanted: &dyn Fn(Tier) -> bool| operations(private, program, wanted);
    let prepare = count(&|tier| tier == Tier::Prepare);
    let iteration = count(&|tier| matches!(tier, Tier::Iterate(_)));
    let step = count(&|tier| !matches!(tier, Tier::Prepare | Tier::Iterate(_)));
    quote! {
        #private::Plan {
            system: #system,
            rule: #name,
            degrees_of_freedom: #n,
            noises: #m,
            blocks: &[#(#blocks),*],
            deterministic_order: #order,
            strong_order: #private::StrongOrder::#strong,
            prepare: #prepare,
            step: #step,
            iteration: #iteration,
        }
    }
}

/// Counts operations of some tiers; a sine with its cosine is one call.
fn operations(
    private: &TokenStream,
    program: &Program,
    wanted: &dyn Fn(Tier) -> bool,
) -> TokenStream {
    let (mut arithmetic, mut transcendental) = (0usize, 0usize);
    for (_, instruction) in program.all().filter(|(_, i)| wanted(i.tier)) {
        match instruction.operation {
            Operation::Constant(_)
            | Operation::Input(_)
            | Operation::SinOf(_)
            | Operation::CosOf(_) => {}
            Operation::Add(..)
            | Operation::Sub(..)
            | Operation::Mul(..)
            | Operation::Div(..)
            | Operation::Neg(_)
            | Operation::Abs(_)
            | Operation::Recip(_) => {
                arithmetic += 1;
            }
            Operation::Call(..)
            | Operation::Call2(..)
            | Operation::SinCos(_)
            | Operation::Turn(..) => {
                transcendental += 1;
            }
        }
    }
    quote!(#private::Operations { arithmetic: #arithmetic, transcendental: #transcendental })
}

/// Longest formula that is worth reading, in characters.
const READABLE: usize = 600;

fn doc(action: &Action, symbols: &Symbols, arena: &Arena) -> String {
    let mut doc = String::from(
        "One step: solves `p0 = -∂S/∂q0`, `0 = ∂S/∂(internal variables)` for the displacement `d = q1 - q0`, and returns `(d, p1 - p0)`.",
    );
    if let Some(formula) = arena.display(action.value, READABLE, &|s| symbols.name(s)) {
        doc.push_str("\n\n```text\nS = ");
        doc.push_str(&formula);
        doc.push_str("\n```");
    }
    doc
}
