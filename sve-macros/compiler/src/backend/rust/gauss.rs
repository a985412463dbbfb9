//! `impl StepEquations<Gauss<S>>`: a thin layer over the runtime's functions for steps of many
//! stages.

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens, quote};

use super::implementation::Implementation;
use super::plan::{Cost, plan_of};
use super::stages::StageCode;
use super::time_scale::nodes;
use super::{Context, attributes, documented};
use crate::catalogue::{Rule, RuleOption};
use crate::discretise::stages::{Form, Stages};
use crate::explain::StepTexts;
use crate::program::{Operations, Work};

/// Prints the step of a rule; `half_factor` is ½κ of the option `weak2`, if the action has its
/// term.
pub(crate) fn gauss(
    context: &Context<'_>,
    (rule, weak_order): (Rule, u32),
    count: usize,
    half_factor: Option<f64>,
    stages: &Stages,
    code: &StageCode,
    texts: &StepTexts,
) -> TokenStream {
    let private = context.private;
    let self_ty = context.self_ty();
    let runtime = context.block.arguments.runtime.to_token_stream();
    let rule_type = super::rule_type(rule, &runtime);
    let dof = context.model.dof();
    let unknowns = stages.unknowns(count, dof);
    let processes = context.model.noises.len();
    let [n, s, k] = [dof, count, unknowns].map(Literal::usize_unsuffixed);
    let noise = noise(rule, count, processes, half_factor, private);
    let Solve {
        prepared,
        prepare,
        memory,
        increment,
    } = solve(context, count, stages, &noise);
    let Noise {
        increments,
        at_stages,
        system,
        stages_constant,
        ..
    } = &noise;
    let names = names(count, dof, stages.moves_position);
    let nodes = nodes(context, rule);
    let plan = plan_of(
        context,
        (rule, weak_order),
        texts,
        &cost(&names, code, count, dof),
    );
    let proves_start = proves_start(context);
    let implementation = Implementation {
        private,
        doc: documentation(texts),
        header: quote!(impl #private::StepEquations<#rule_type> for #self_ty),
        sizes: [&n, increments, &k],
        types: [quote!(#private::State<[f64; #n]>), prepared, memory],
        plan,
        returns: quote!(Increment),
        more: quote!(#stages_constant #proves_start #nodes),
        prepare,
        start: quote!(#private::gauss::start::<#s, #n, #k>(velocity)),
        increment,
        linearise: quote!(#private::gauss::linearise(#system, state, h, #at_stages, unknowns, then)),
        increment_doc: TokenStream::new(),
    }
    .print();
    let adapted = (stages.has_adapted_steps(rule, count)).then(|| adapted(context, count, stages));
    quote!(#implementation #adapted)
}

/// Prints that Newton's method proves the start of a step, where it starts from the velocity of the
/// momentum.
fn proves_start(context: &Context<'_>) -> Option<TokenStream> {
    let is_solved = !context.mechanics.affine_momentum;
    is_solved.then(|| {
        quote!(
            const PROVES_START: bool = true;
        )
    })
}

/// Prints the steps of adapted size of a rule.
fn adapted(context: &Context<'_>, count: usize, stages: &Stages) -> Option<TokenStream> {
    let (private, self_ty) = (context.private, context.self_ty());
    let dof = context.model.dof();
    let unknowns = stages.unknowns(count, dof);
    let sizes = [count, dof, context.model.noises.len(), unknowns];
    let [s, n, m, k] = sizes.map(Literal::usize_unsuffixed);
    let (coefficients, compute, attempt) = match &stages.form {
        Form::General => return None,
        Form::SecondOrder { .. } => (
            quote!([[f64; #n]; #n]),
            quote!(#private::gauss::inverse_mass(self)),
            quote!(#private::gauss::second_order_attempt::<_, _, #s, #n, #m, #k>(self, coefficients, state, h, level, before)),
        ),
        Form::Partitioned { .. } => (
            quote!(()),
            quote!(),
            quote!(#private::gauss::partitioned_attempt::<_, _, #s, #n, #m, #k>(self, state, h, level, before)),
        ),
    };
    let attributes = attributes();
    Some(quote! {
        #attributes
        impl #private::gauss::AdaptedSteps<#s, #n> for #self_ty {
            type Coefficients = #coefficients;
            #[inline]
            fn coefficients(&self) -> #coefficients {
                #compute
            }
            #[inline]
            fn attempt(
                &self,
                coefficients: &#coefficients,
                state: &#private::State<[f64; #n]>,
                h: f64,
                level: f64,
                before: ::core::option::Option<&#private::gauss::StageSeries<#s, #n>>,
            ) -> ::core::option::Option<#private::gauss::Attempt<#s, #n>> {
                #attempt
            }
        }
    })
}

/// The types and bodies of a step, which depend on the form of the system.
struct Solve {
    /// The type of what `prepare` returns, and its body.
    prepared: TokenStream,
    prepare: TokenStream,
    /// The type of what a trajectory carries.
    memory: TokenStream,
    /// The body of `increment`.
    increment: TokenStream,
}

fn solve(context: &Context<'_>, count: usize, stages: &Stages, noise: &Noise) -> Solve {
    let Noise {
        at_stages: noise,
        processes: m,
        system,
        ..
    } = noise;
    let private = context.private;
    let (dof, processes) = (context.model.dof(), context.model.noises.len());
    let form = if stages.has_fixed_point(count) {
        &stages.form
    } else {
        &Form::General
    };
    let rows = match form {
        Form::General => 0,
        Form::SecondOrder { .. } => 1,
        Form::Partitioned { .. } => 2,
    };
    let sizes = [
        count,
        dof,
        stages.unknowns(count, dof),
        1 + rows * dof * count,
    ];
    let [s, n, k, l] = sizes.map(Literal::usize_unsuffixed);
    // with noise, stages do not predict the stages of the next step
    let carries = processes == 0 && rows > 0;
    let (memory_type, memory) = if carries {
        (quote!(::core::option::Option<[f64; #l]>), quote!(memory))
    } else {
        (quote!(()), quote!(&mut ::core::option::Option::None))
    };
    let (prepared, prepare, increment) = match form {
        Form::General => (
            quote!(()),
            quote!(),
            quote!(#private::gauss::newton_increment::<_, _, #s, #n, #m, #k>(#system, state, h, #noise, newton)),
        ),
        Form::SecondOrder { .. } => (
            quote!(#private::gauss::SecondOrderCoefficients<#s, #n>),
            quote!(#private::gauss::SecondOrderCoefficients::new(self, h)),
            quote!(#private::gauss::second_order_increment::<_, _, #s, #n, #m, #k, #l>(#system, prepared, #memory, state, h, #noise, newton)),
        ),
        Form::Partitioned { .. } => (
            quote!(()),
            quote!(),
            quote!(#private::gauss::partitioned_increment::<_, _, #s, #n, #m, #k, #l>(#system, #memory, state, h, #noise, newton)),
        ),
    };
    Solve {
        prepared,
        prepare,
        memory: memory_type,
        increment,
    }
}

fn documentation(texts: &StepTexts) -> TokenStream {
    let StepTexts { action, step, .. } = texts;
    documented(&[
        (
            "Discrete action, of which `p₀ = −∂S/∂q₀`, `p₁ = ∂S/∂q₁`, `0 = ∂S/∂(each internal variable)`:",
            action,
        ),
        ("Equations of the step:", step),
    ])
}

/// The increments of a step.
struct Noise {
    /// How many there are.
    increments: Literal,
    /// The increments of each process at the stages.
    at_stages: TokenStream,
    /// The number of processes at the stages.
    processes: Literal,
    /// The system with these processes.
    system: TokenStream,
    /// The number of stages, for a rule with stage noise.
    stages_constant: Option<TokenStream>,
}

fn noise(
    rule: Rule,
    count: usize,
    processes: usize,
    half_factor: Option<f64>,
    private: &TokenStream,
) -> Noise {
    let [s, m] = [count, processes].map(Literal::usize_unsuffixed);
    let has_stage_noise = rule.options.contain(RuleOption::StageNoise);
    let increments = if has_stage_noise {
        count * processes
    } else {
        processes
    };
    let increments = Literal::usize_unsuffixed(increments);
    let at_stages = if has_stage_noise {
        quote!(#private::gauss::by_stage::<#s, #m, #increments>(dw))
    } else {
        quote!(#private::gauss::shares::<#s, #m>(dw))
    };
    let stages_constant = has_stage_noise.then(|| quote!(const STAGES: usize = #s;));
    let Some(half_factor) = half_factor else {
        return Noise {
            increments,
            at_stages,
            processes: m,
            system: quote!(self),
            stages_constant,
        };
    };
    // the potential is one more noise, which has its place behind the others
    let more = Literal::usize_unsuffixed(processes + 1);
    Noise {
        at_stages: quote!(#private::gauss::with_potential::<#s, #m, #more>(#at_stages, h, #half_factor)),
        system: quote!(&#private::gauss::Corrected::<Self, #more>(self)),
        processes: more,
        increments,
        stages_constant,
    }
}

/// Names of the unknowns: velocities of the stages, component by component, then displacements.
fn names(stages: usize, dof: usize, moves_position: bool) -> Vec<String> {
    const DIGITS: [&str; 9] = ["", "₁", "₂", "₃", "₄", "₅", "₆", "₇", "₈"];
    let letters = if moves_position {
        &["V", "Y"][..]
    } else {
        &["V"]
    };
    let mut names = Vec::new();
    for letter in letters {
        for i in 0..dof {
            let component = if dof == 1 {
                String::new()
            } else {
                format!("[{i}]")
            };
            for digit in &DIGITS[1..=stages] {
                names.push(format!("{letter}{digit}{component}"));
            }
        }
    }
    names
}

/// The cost in the plan: an iteration is a sweep over the stages, with the products with the matrix
/// of the rule.
fn cost<'a>(names: &'a [String], code: &StageCode, stages: usize, dof: usize) -> Cost<'a> {
    let Operations {
        arithmetic,
        transcendental,
        angle_additions,
    } = code.operations;
    let iteration = Operations {
        arithmetic: stages * (arithmetic + 2 * stages * dof),
        transcendental: stages * transcendental,
        angle_additions: stages * angle_additions,
    };
    Cost {
        unknowns: names,
        work: Work {
            prepare: Operations::default(),
            carried: Operations::default(),
            step: iteration,
            iteration,
        },
    }
}
