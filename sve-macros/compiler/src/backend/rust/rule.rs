//! `impl StepEquations<Rule>`: what surrounds a step.

use std::cell::RefCell;

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens, quote};

use super::cold::Cold;
use super::configuration::{Received, received};
use super::implementation::Implementation;
use super::lanes::lanes;
use super::linearise::{linearise, multipliers};
use super::plan::plan;
use super::step::{self, Code};
use super::tangents::linearise_lanes;
use super::time_scale::nodes;
use super::{Context, Derived, allowed, documented, unstructured, verbatim};
use crate::algebra::{Expr, Symbol};
use crate::explain::StepTexts;
use crate::model::{Family, Meaning, Symbols, Unknown};
use crate::structure::{Block, Returns, Solution};

pub(crate) fn rule(context: &Context<'_>, derived: &Derived, texts: &StepTexts) -> TokenStream {
    let private = context.private;
    let self_ty = context.self_ty();
    let (scheme, symbols) = (&derived.scheme, &derived.symbols);
    let unknowns = &derived.linearisation.unknowns;
    let rule_type = rule_type(context, derived);
    let [n, m] = context.sizes();
    let count = Literal::usize_unsuffixed(unknowns.len());
    let received = received(context.block, context.model, private);
    let cold = Cold {
        formulas: context.formulas_of(derived),
        self_ty,
        received: &received,
        noises: m.clone(),
        functions: RefCell::default(),
    };
    let Code {
        prepared,
        carried,
        prepare,
        body,
        work,
    } = code(derived, &cold, context);
    let Received {
        flat, open_state, ..
    } = &received;
    let lanes = in_lanes(context, derived);
    let [proves_start, domain] = [proves_start(context, derived), domain(texts)];
    let multipliers = multipliers(context, derived);
    let nodes = nodes(context, derived.rule);
    let [doc, increment_doc] = documentation(texts);
    let implementation = Implementation {
        private,
        doc,
        header: quote!(impl #private::StepEquations<#rule_type> for #self_ty),
        sizes: [&n, &m, &count],
        types: [quote!(#private::State<#flat>), prepared, memory(carried)],
        plan: plan(context, derived, lanes.is_some(), texts, &work),
        returns: returns(scheme.returns),
        more: quote!(#proves_start #domain #lanes #multipliers #nodes),
        prepare,
        start: start(unknowns, context.model.dof(), symbols),
        increment: quote!(#open_state #body),
        linearise: linearise(context, derived, open_state),
        increment_doc,
    };
    let functions = cold.functions.into_inner();
    if functions.is_empty() {
        return implementation.print();
    }
    let (allowed, implementation) = (allowed(), implementation.print());
    quote! {
        #allowed
        const _: () = {
            #implementation
            #(#functions)*
        };
    }
}

/// `PROVES_START`, where it holds.
fn proves_start(context: &Context<'_>, derived: &Derived) -> Option<TokenStream> {
    finds_singular_masses(context, derived).then(|| {
        quote!(
            const PROVES_START: bool = true;
        )
    })
}

/// Returns whether a step refuses its solution if the mass matrix at the start is singular. This
/// holds if bounds test all blocks: the bounds contain the matrices in the limit of no noise and
/// h → 0, where the product of their determinants is the determinant of the mass matrix.
fn finds_singular_masses(context: &Context<'_>, derived: &Derived) -> bool {
    let mechanics = context.mechanics;
    let has_own_start = context.degeneracy.is_some() || !mechanics.constraints.is_empty();
    let is_judged = |block: &Block<Expr>| match &block.solution {
        Solution::Iteration(iteration) => iteration.judge.is_some(),
        Solution::Formula(_) | Solution::System { .. } => false,
    };
    mechanics.affine_momentum
        && !has_own_start
        && !derived.is_unstructured
        && derived.scheme.blocks.iter().all(is_judged)
}

/// `increment_lanes`, if ensembles step this system in lanes, with `linearise_lanes` where there is
/// one. Rotations are stepped lane by lane.
fn in_lanes(context: &Context<'_>, derived: &Derived) -> Option<TokenStream> {
    let has_lanes = context.settings.lanes && !context.model.configuration().has_rotations();
    if !has_lanes || derived.is_unstructured {
        return None;
    }
    let formulas = context.formulas_of(derived);
    let step = lanes(&derived.scheme, context.sizes(), formulas)?;
    let tangents = linearise_lanes(context, derived);
    Some(quote!(#step #tangents))
}

/// The type of what a trajectory carries, `count` numbers.
fn memory(count: usize) -> TokenStream {
    let numbers = Literal::usize_unsuffixed(count);
    match count {
        0 => quote!(()),
        _ => quote!(::core::option::Option<[f64; #numbers]>),
    }
}

/// The name in the runtime of what a step returns.
fn returns(of_scheme: Returns) -> TokenStream {
    match of_scheme {
        Returns::Increment => quote!(Increment),
        Returns::State => quote!(State),
        Returns::MatrixTimesState => quote!(MatrixTimesState),
    }
}

/// The conditions on where functions are evaluated, if there are any.
fn domain(texts: &StepTexts) -> Option<TokenStream> {
    let conditions = texts.domain.iter().map(|text| verbatim(text));
    (!texts.domain.is_empty()).then(|| {
        quote! {
            const DOMAIN: &'static [&'static str] = &[#(#conditions),*];
        }
    })
}

/// The values of the unknowns in the limit of no noise and h → 0, where nothing moves and the
/// acceleration is that of the motion. Unknowns of later stages stand behind the unknowns of
/// the first.
fn start(unknowns: &[Symbol], coordinates: usize, symbols: &Symbols) -> TokenStream {
    let entries = unknowns.iter().map(|&symbol| {
        let Meaning::Unknown(Unknown { family, index }) = *symbols.meaning(symbol) else {
            return quote!(0f64);
        };
        let i = Literal::usize_unsuffixed(index % coordinates);
        match family {
            Family::Displacement
            | Family::NodeDisplacement
            | Family::Projection
            | Family::AccelerationMultiplier
            | Family::StartMultiplier
            | Family::EndMultiplier => quote!(0f64),
            Family::Velocity | Family::StageVelocity | Family::EndVelocity => quote!(velocity[#i]),
            Family::Acceleration => quote!(acceleration[#i]),
            // the multiplier of the velocity is the momentum
            Family::Momentum | Family::VelocityMultiplier => quote!(state.p[#i]),
        }
    });
    quote!([#(#entries),*])
}

/// The rule, or the type that stands for its step without structure.
fn rule_type(context: &Context<'_>, derived: &Derived) -> TokenStream {
    let runtime = context.block.arguments.runtime.to_token_stream();
    let rule = super::rule_type(derived.rule, &runtime);
    if derived.is_unstructured {
        quote!(#runtime::__private::Unstructured<#rule>)
    } else {
        rule
    }
}

fn code(derived: &Derived, cold: &Cold<'_>, context: &Context<'_>) -> Code {
    let Derived {
        scheme,
        linearisation,
        ..
    } = derived;
    match scheme.blocks.as_slice() {
        [
            Block {
                solution: Solution::Iteration(iteration),
                ..
            },
        ] if derived.is_unstructured => unstructured::code(scheme, iteration, cold.formulas),
        _ => {
            let finds_singular_masses = finds_singular_masses(context, derived);
            let unknowns = &linearisation.unknowns;
            step::code(scheme, finds_singular_masses, unknowns, cold)
        }
    }
}

/// Of the implementation and of `increment`.
fn documentation(texts: &StepTexts) -> [TokenStream; 2] {
    let StepTexts {
        action,
        step,
        domain: _,
    } = texts;
    let of_action = "Discrete action, of which `p₀ = −∂S/∂q₀`, `p₁ = ∂S/∂q₁`, `0 = ∂S/∂(each internal variable)`:";
    let of_increment =
        "One step from `q₀`, `p₀`: `(q₁ − q₀, p₁ − p₀)`, or `(q₁, p₁)` where `RETURNS` is `State`.";
    [
        documented(&[(of_action, action), ("Equations of the step:", step)]),
        documented(&[(of_increment, step)]),
    ]
}
