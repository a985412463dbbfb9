//! The plan of a step, as a constant.

use proc_macro2::TokenStream;
use quote::quote;

use super::{Context, Derived, verbatim};
use crate::algebra::Expr;
use crate::catalogue::{Rule, RuleOption};
use crate::explain::StepTexts;
use crate::model::{Symbols, unknown};
use crate::program::{Operations, Work};
use crate::structure::{Block, Kind};
use crate::system::commutation::Commutation;
use crate::system::degeneracy::{Degeneracy, Form};
use crate::system::drag::Drag;
use crate::system::mechanics::Mechanics;

pub(super) fn plan(
    context: &Context<'_>,
    derived: &Derived,
    in_lanes: bool,
    texts: &StepTexts,
    work: &Work,
) -> TokenStream {
    let blocks = derived.scheme.blocks.iter();
    let blocks = blocks.map(|b| self::block(context.private, b, &derived.symbols));
    plan_with(
        context,
        (derived.rule, derived.weak_order),
        texts,
        (&quote!(#(#blocks),*), in_lanes),
        work,
    )
}

/// The unknowns of a step that is solved in one block, and what it costs. Ensembles make such a
/// step for one path after the other.
pub(super) struct Cost<'a> {
    pub(super) unknowns: &'a [String],
    pub(super) work: Work,
}

/// The plan of a step by a rule, whose weak order stands beside it, that is solved in one block
/// with a full Jacobian.
pub(super) fn plan_of(
    context: &Context<'_>,
    rule: (Rule, u32),
    texts: &StepTexts,
    cost: &Cost<'_>,
) -> TokenStream {
    let Cost { unknowns, work } = cost;
    let (private, nonzeros) = (context.private, unknowns.len() * unknowns.len());
    let block = quote! {
        #private::Block {
            kind: #private::BlockKind::Newton,
            unknowns: &[#(#unknowns),*],
            nonzeros: #nonzeros,
            band: ::core::option::Option::None,
        }
    };
    plan_with(context, rule, texts, (&block, false), work)
}

fn plan_with(
    context: &Context<'_>,
    (rule, weak_order): (Rule, u32),
    texts: &StepTexts,
    (blocks, in_lanes): (&TokenStream, bool),
    work: &Work,
) -> TokenStream {
    let Context {
        model,
        mechanics,
        about,
        private,
        ..
    } = *context;
    let texts = [&about.system(), &about.motion, &texts.action, &texts.step];
    let [terms, motion, action, equations] = texts.map(|text| verbatim(text));
    let user_ty = context.user_ty();
    let system = quote!(#user_ty).to_string();
    let (name, order) = (rule.name(), rule.order);
    let (n, m) = (model.dof(), model.noises.len());
    let strong = match context.commutation {
        _ if m == 0 => quote!(Deterministic),
        Commutation::All(_) if rule.options.contain(RuleOption::StageNoise) => {
            of_stage_noise(rule, mechanics)
        }
        Commutation::All(_) => quote!(One),
        Commutation::NonCommuting(a, b) => quote!(Half { pair: (#a, #b) }),
    };
    let conserved = context.momenta.iter().filter(|map| map.is_affine);
    let conserved = conserved.map(|map| format!("{}_momentum", map.name));
    let degenerate = degenerate(private, rule, context.degeneracy);
    let Work {
        prepare,
        step,
        carried,
        iteration,
    } = work;
    let [prepare, step, carried, iteration] =
        [prepare, step, carried, iteration].map(|w| operations(private, w));
    quote! {
        #private::Plan {
            system: #system,
            rule: #name,
            substeps: ::core::option::Option::None,
            degrees_of_freedom: #n,
            noises: #m,
            blocks: &[#blocks],
            deterministic_order: #order,
            strong_order: #private::StrongOrder::#strong,
            weak_order: #weak_order,
            conserved: &[#(#conserved),*],
            in_lanes: #in_lanes,
            degenerate: #degenerate,
            prepare: #prepare,
            step: #step,
            carried: #carried,
            iteration: #iteration,
            formulas: #private::Formulas {
                system: #terms,
                motion: #motion,
                action: #action,
                step: #equations,
            },
        }
    }
}

/// How the step treats a degenerate Lagrangian.
fn degenerate(private: &TokenStream, rule: Rule, degeneracy: Option<&Degeneracy>) -> TokenStream {
    let Some(degeneracy) = degeneracy else {
        return quote!(::core::option::Option::None);
    };
    let form = match degeneracy.form(rule.node() == Some(0.5)) {
        Form::Eliminated => quote!(Eliminated),
        Form::Plain => quote!(Affine),
        Form::Internal => quote!(Internal),
        Form::Projected => quote!(Projected),
    };
    quote!(::core::option::Option::Some(#private::DegenerateStep::#form))
}

fn block(private: &TokenStream, block: &Block<Expr>, symbols: &Symbols) -> TokenStream {
    let Block {
        kind,
        unknowns,
        nonzeros,
        pivots: _,
        solution: _,
    } = block;
    let kind = match kind {
        Kind::Explicit => quote!(Explicit),
        Kind::Linear => quote!(Linear),
        Kind::Newton => quote!(Newton),
    };
    let unknowns = unknowns.iter().map(|&u| unknown(symbols, u));
    let band = match block.bandwidths() {
        Some((lower, upper)) => quote!(::core::option::Option::Some((#lower, #upper))),
        None => quote!(::core::option::Option::None),
    };
    quote!(#private::Block { kind: #private::BlockKind::#kind, unknowns: &[#(#unknowns),*], nonzeros: #nonzeros, band: #band })
}

pub(super) fn operations(private: &TokenStream, operations: &Operations) -> TokenStream {
    let Operations {
        arithmetic,
        transcendental,
        angle_additions,
    } = operations;
    quote! {
        #private::Operations { arithmetic: #arithmetic, transcendental: #transcendental, angle_additions: #angle_additions }
    }
}

/// The strong order of a rule with stage noise, for noises that commute.
///
/// The rest of an additive noise, which the stages do not see, moves momenta by r, of the size of
/// √h, and places by ∫ r dt. A force of velocities that is not linear in them has the mean of r²,
/// as a term of order h². Where G of `Drag` depends on the place, the product of ∫ rᵢ dt and rⱼ of
/// different coordinates has the mean 0 and the size h², the global order 5/2. Of one coordinate it
/// is the derivative of a square, which is 0 at the end of a step.
fn of_stage_noise(rule: Rule, mechanics: &Mechanics) -> TokenStream {
    let has_force = mechanics.force.is_some();
    match (rule.stages(), mechanics.drag) {
        (Some(2), Drag::Linear | Drag::OfPlace) if mechanics.is_additive => quote!(Two),
        (Some(3..), Drag::OfPlace) if mechanics.is_additive => quote!(TwoAndAHalf),
        (Some(3..), Drag::Linear) if mechanics.is_additive => quote!(Three),
        (Some(2..), _) if !has_force && rule.options.contain(RuleOption::Weak2) => {
            quote!(OneAndAHalf)
        }
        _ => quote!(One),
    }
}
