//! Functions of a system that all Gauss rules share: the function at a node as a loop over the
//! stages, and derivatives by the parameters.
//!
//! Input: the equations at a node. Output: implementations of traits in the runtime's `gauss`.
//! Invariant: no branches and no calls within a loop over the stages, so that the compiler turns it
//! into vector instructions.

mod masses;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::axis::Axis;
use super::code::Place;
use super::function::Formulas;
use super::jets::{parameter_jets, with_potential};
use super::node_bounds::node_bounds;
use super::step::inside;
use super::{Context, attributes, ident};
use crate::algebra::Expr;
use crate::derivation::Nodes;
use crate::discretise::stages::{Form, Impulse, Stages};
use crate::model::domain::Condition;
use crate::model::{Meaning, Model};
use crate::program::{Array, Kernel, Operations, Scheduler, Tier, Tiers};

/// The implementations, and the operations of a sweep at one stage.
pub(crate) struct StageCode {
    pub(crate) tokens: TokenStream,
    pub(crate) operations: Operations,
}

/// Prints the equations at a node. The last noise of the context may be the potential of the option
/// `weak2`. The loops over the stages are printed where a rule iterates to a fixed point.
pub(crate) fn stages(context: &Context<'_>, nodes: &Nodes) -> StageCode {
    let (private, attributes) = (context.private, attributes());
    let (self_ty, sizes) = (context.self_ty(), context.sizes());
    let (stages, sizes) = (&nodes.stages, quote!(#(#sizes),*));
    let parameters = parameter_jets(context, stages);
    let potential = nodes.has_potential.then(|| with_potential(context));
    let bounds = node_bounds(context, stages);
    let writer = Writer {
        private,
        model: context.model,
        stages,
        sizes: &sizes,
        formulas: Formulas {
            symbols: &stages.symbols,
            ..context.formulas()
        },
    };
    let (form, (body, operations)) = match &stages.form {
        Form::General => (quote!(General), Default::default()),
        Form::SecondOrder {
            has_diagonal_mass,
            impulse,
        } => {
            let (body, operations) = writer.impulses(impulse);
            let constant = quote!(const HAS_DIAGONAL_MASS: bool = #has_diagonal_mass;);
            (quote!(SecondOrder), (quote!(#constant #body), operations))
        }
        Form::Partitioned {
            mass,
            is_diagonal,
            offset,
            impulse,
            shift,
        } => {
            let sweep = writer.sweep((mass, *is_diagonal), offset, impulse, shift);
            (quote!(Partitioned), sweep)
        }
    };
    let mut counts = nodes.rules.iter().filter_map(|(rule, _)| rule.stages());
    let is_swept = counts.any(|count| stages.has_fixed_point(count));
    let loops = is_swept.then(|| {
        quote! {
            #attributes
            impl #private::gauss::#form<#sizes> for #self_ty {
                #body
            }
        }
    });
    StageCode {
        tokens: quote! {
            #attributes
            impl #private::gauss::ByParameters<#sizes> for #self_ty {
                #parameters
            }
            #loops
            #bounds
            #potential
        },
        operations,
    }
}

/// Writes the loops over the stages.
struct Writer<'a> {
    private: &'a TokenStream,
    model: &'a Model,
    stages: &'a Stages,
    /// `N, M`.
    sizes: &'a TokenStream,
    formulas: Formulas<'a>,
}

/// The statements of one loop: those before the loop, those that need the position of a stage, and
/// those that need its velocity.
struct Body {
    before: TokenStream,
    known: TokenStream,
    late: TokenStream,
    results: Vec<TokenStream>,
    operations: Operations,
}

impl Writer<'_> {
    /// The program of some expressions.
    fn body(&self, roots: &[Expr]) -> Body {
        let mut tiers = Tiers::new();
        let early = [self.model.time, self.stages.weight];
        let early = early
            .iter()
            .chain(&self.model.q)
            .chain(&self.model.p)
            .chain(&self.stages.dw);
        tiers.extend(early.map(|&s| (s, Tier::State)));
        tiers.extend(self.model.v.iter().map(|&s| (s, Tier::Iterate(0))));
        let Formulas { arena, symbols, .. } = self.formulas;
        let mut scheduler = Scheduler::new(arena, symbols, tiers, roots);
        scheduler.join_reciprocals();
        let kernel = Kernel::new(scheduler, &[Array::unnamed(roots)]);
        let printer = self.formulas.printer(&kernel, Place::Over(Axis::Stages));
        let print = |tier| printer.statements(tier);
        let results = kernel.arrays[0].entries();
        Body {
            before: print(Tier::Prepare),
            known: print(Tier::State),
            late: print(Tier::Iterate(0)),
            results: results.map(|value| printer.operand(value)).collect(),
            operations: Operations::of(&kernel.program, |tier| tier != Tier::Prepare),
        }
    }

    /// A function with a loop over the stages: its name with further arguments, and the statements
    /// before and within the loop.
    fn function(
        &self,
        (name, arguments): (&str, &TokenStream),
        [before, body]: [&TokenStream; 2],
    ) -> TokenStream {
        let (private, sizes, name) = (self.private, self.sizes, ident(name));
        let sweep = Axis::Stages.sweep(body, private);
        quote! {
            #[inline(always)]
            fn #name<const __S: usize>(
                &self,
                stages: &#private::gauss::StageLanes<'_, __S, #sizes>,
                #arguments
            ) {
                #before
                #sweep
            }
        }
    }

    /// `fn impulses`.
    fn impulses(&self, impulse: &Impulse) -> (TokenStream, Operations) {
        let n = self.model.dof();
        let domain = impulse.domain.iter().map(|c| c.value);
        let roots: Vec<Expr> = impulse.value.iter().copied().chain(domain).collect();
        let Body {
            before,
            known,
            late,
            results,
            operations,
        } = self.body(&roots);
        let [poison, poisoned] = poison(&impulse.domain, &results[n..]);
        let stores = store(&quote!(impulses), &results[..n], &poisoned);
        let n = Literal::usize_unsuffixed(n);
        let tokens = self.function(
            ("impulses", &quote!(impulses: &mut [[f64; __S]; #n])),
            [&before, &quote!(#known #late #poison #stores)],
        );
        (tokens, operations)
    }

    /// `fn impulses` and `fn displacements` of a system with masses that depend on the position.
    fn sweep(
        &self,
        (mass, is_diagonal): (&[Vec<Expr>], bool),
        offset: &[Expr],
        impulse: &Impulse,
        shift: &[Expr],
    ) -> (TokenStream, Operations) {
        let n = self.model.dof();
        let (impulses, of_impulses) = self.impulses_of_masses((mass, is_diagonal), offset, impulse);
        let (displacements, of_displacements) = self.displacements(shift, is_diagonal);
        let solves = Operations {
            arithmetic: 2 * n * (2 * n + 1),
            ..Operations::default()
        };
        let tokens = quote!(#impulses #displacements);
        (tokens, of_impulses + of_displacements + solves)
    }

    fn impulses_of_masses(
        &self,
        (mass, is_diagonal): (&[Vec<Expr>], bool),
        offset: &[Expr],
        impulse: &Impulse,
    ) -> (TokenStream, Operations) {
        let n = self.model.dof();
        let mut roots = impulse.value.clone();
        roots.extend(impulse.domain.iter().map(|c| c.value));
        let first_of_mass = roots.len();
        roots.extend(mass.iter().flatten().chain(offset));
        let Body {
            before,
            known,
            late,
            results,
            operations,
        } = self.body(&roots);
        let (matrix, offsets) = results[first_of_mass..].split_at(n * n);
        let inverse = self.inverse(matrix, is_diagonal);
        let [poison, poisoned] = poison(&impulse.domain, &results[n..first_of_mass]);
        let keep_impulses = store(&quote!(impulses), &results[..n], &poisoned);
        let keep_offsets = store(&quote!(masses.offset), offsets, &TokenStream::new());
        let [keep_inverse, _] = self.kept_inverse(is_diagonal);
        let velocity = self.velocity(is_diagonal);
        let (size, private) = (Literal::usize_unsuffixed(n), self.private);
        let tokens = self.function(
            (
                "impulses",
                &quote! {
                    kicks: &[[f64; __S]; #size],
                    impulses: &mut [[f64; __S]; #size],
                    masses: &mut #private::gauss::Masses<__S, #size>,
                },
            ),
            [
                &before,
                &quote! {
                    #known
                    #inverse
                    #keep_inverse
                    #keep_offsets
                    let offset: [f64; #size] = [#(#offsets),*];
                    let v: [f64; #size] = #velocity;
                    #late
                    #poison
                    #keep_impulses
                },
            ],
        );
        (tokens, operations)
    }

    fn displacements(&self, shift: &[Expr], is_diagonal: bool) -> (TokenStream, Operations) {
        let Body {
            before,
            known,
            late,
            results,
            operations,
        } = self.body(shift);
        let [_, kept_inverse] = self.kept_inverse(is_diagonal);
        let velocity = self.velocity(is_diagonal);
        let (size, private) = (Literal::usize_unsuffixed(self.model.dof()), self.private);
        let offset = Axis::Stages.entries(&quote!(masses.offset), self.model.dof());
        let weight = Axis::Stages.input(&Meaning::StepSize);
        let velocities = || (0..self.model.dof()).map(Literal::usize_unsuffixed);
        let displacements = velocities().zip(&results);
        let displacements = displacements.map(|(i, shift)| quote!(#weight * v[#i] + #shift));
        let keep_displacements = Axis::Stages.store(&quote!(motion.displacements), displacements);
        let velocities = velocities().map(|i| quote!(v[#i]));
        let keep_velocities = Axis::Stages.store(&quote!(motion.velocities), velocities);
        let tokens = self.function(
            (
                "displacements",
                &quote! {
                    kicks: &[[f64; __S]; #size],
                    masses: &#private::gauss::Masses<__S, #size>,
                    motion: &mut #private::gauss::Motion<__S, #size>,
                },
            ),
            [
                &before,
                &quote! {
                    #kept_inverse
                    let offset: [f64; #size] = #offset;
                    let v: [f64; #size] = #velocity;
                    #known
                    #late
                    #keep_displacements
                    #keep_velocities
                },
            ],
        );
        (tokens, operations)
    }
}

/// Writes values to the rows of an array, with `more` added to each.
fn store(rows: &TokenStream, values: &[TokenStream], more: &TokenStream) -> TokenStream {
    Axis::Stages.store(rows, values.iter().map(|value| quote!(#value #more)))
}

/// `+ 0`, or `+ NaN` where a function is not defined.
fn poison(domain: &[Condition<Expr>], values: &[TokenStream]) -> [TokenStream; 2] {
    if domain.is_empty() {
        return [TokenStream::new(), TokenStream::new()];
    }
    let conditions = domain.iter().zip(values);
    let conditions = conditions.map(|(c, value)| inside(value, c.is_closed));
    let poison = quote! {
        let poison = if true #(& (#conditions))* { 0f64 } else { f64::NAN };
    };
    [poison, quote!(+ poison)]
}
