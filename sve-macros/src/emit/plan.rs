//! The plan of a step, as a constant.

use proc_macro2::TokenStream;
use quote::quote;

use super::verbatim;
use crate::explain::{self, StepTexts, SystemTexts};
use crate::mechanics::Mechanics;
use crate::model::{Model, Symbols};
use crate::parse::Annotated;
use crate::rule::Rule;
use crate::schedule::{Operation, Program, Tier};
use crate::structure::{Band, Block, Kind, Scheme};
use crate::symmetry::MomentumMap;

#[allow(clippy::too_many_arguments)] // what a plan reports is spread over the stages
pub(super) fn plan(
    private: &TokenStream,
    rule: Rule,
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    scheme: &Scheme,
    momenta: &[MomentumMap],
    about: &SystemTexts,
    texts: &StepTexts,
    program: &Program,
    symbols: &Symbols,
) -> TokenStream {
    let StepTexts {
        action,
        step: equations,
    } = texts;
    let texts = [&about.system(), &about.motion, action, equations];
    let [terms, motion, action, equations] = texts.map(|text| verbatim(text));
    let self_ty = &block.item.self_ty;
    let system = quote!(#self_ty).to_string();
    let (name, order) = (rule.attribute_name(), rule.deterministic_order());
    let (n, m) = (model.dof(), model.noises.len());
    let strong = match &mechanics.clash {
        _ if m == 0 => quote!(Deterministic),
        None => quote!(One),
        Some((a, b)) => quote!(Half { pair: (#a, #b) }),
    };
    let blocks = scheme.blocks.iter().map(|Block { kind, unknowns, nonzeros, band, solution: _ }| {
        let kind = match kind {
            Kind::Explicit => quote!(Explicit),
            Kind::Linear => quote!(Linear),
            Kind::Newton => quote!(Newton),
        };
        let unknowns = unknowns.iter().map(|&u| explain::unknown(symbols, u));
        let band = match band {
            Some(Band { lower, upper }) => quote!(::core::option::Option::Some((#lower, #upper))),
            None => quote!(::core::option::Option::None),
        };
        quote!(#private::Block { kind: #private::BlockKind::#kind, unknowns: &[#(#unknowns),*], nonzeros: #nonzeros, band: #band })
    });
    let conserved = momenta.iter().filter(|map| map.affine);
    let conserved = conserved.map(|map| format!("{}_momentum", map.name));
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
            conserved: &[#(#conserved),*],
            prepare: #prepare,
            step: #step,
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
