//! `impl Variational<Rule>`: what surrounds a step.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::code::Printer;
use super::lanes::lanes;
use super::linearise::linearise;
use super::plan::plan;
use super::step::schedule;
use super::{attributes, documented, private};
use crate::explain::{StepTexts, SystemTexts};
use crate::mechanics::Mechanics;
use crate::model::{Model, Symbols};
use crate::parse::Annotated;
use crate::rule::Rule;
use crate::structure::{Form, Scheme};
use crate::symbolic::Arena;
use crate::symmetry::MomentumMap;
use crate::tangent::Linearisation;

#[allow(clippy::too_many_arguments)] // every stage's output is read here, and nowhere after
pub(crate) fn rule(
    rule: Rule,
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    scheme: &Scheme,
    linearisation: &Linearisation,
    momenta: &[MomentumMap],
    about: &SystemTexts,
    texts: &StepTexts,
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let (private, attributes) = (private(block), attributes());
    let runtime = &block.arguments.runtime;
    let rule_type = format_ident!("{}", rule.type_name());
    let self_ty = &block.item.self_ty;
    let n = Literal::usize_unsuffixed(model.dof());
    let m = Literal::usize_unsuffixed(model.noises.len());

    let step = schedule(scheme, &linearisation.unknowns, symbols, &private, arena);
    let mut printer = Printer::new(&step.program, symbols, &step.labels, &private);
    let kept = printer.split_prepared(&step.results);
    let prepared = Literal::usize_unsuffixed(kept.len());
    let (prepare, kept) = (printer.prepare(), printer.array(&kept));
    let body = step.body(&private, &printer, symbols);
    let plan = plan(
        &private,
        rule,
        block,
        model,
        mechanics,
        scheme,
        momenta,
        about,
        texts,
        &step.program,
        symbols,
    );
    let returns_state = scheme.form == Form::State;
    let unknowns = Literal::usize_unsuffixed(linearisation.unknowns.len());
    let linearise = linearise(&private, model, linearisation, symbols, arena);
    let lanes = cfg!(feature = "lanes")
        .then(|| lanes(scheme, model.noises.len(), symbols, &private, arena))
        .flatten();
    let StepTexts {
        action,
        step: equations,
    } = texts;
    let increment_doc = documented(&[(
        "One step from `q₀`, `p₀`: `(q₁ − q₀, p₁ − p₀)`, or `(q₁, p₁)` where `RETURNS_STATE`.",
        equations,
    )]);
    let doc = documented(&[
        (
            "Discrete action, of which `p₀ = −∂S/∂q₀`, `p₁ = ∂S/∂q₁`, `0 = ∂S/∂(each internal variable)`:",
            action,
        ),
        ("Equations of the step:", equations),
    ]);
    quote! {
        #doc
        #attributes
        impl #private::Variational<#runtime::#rule_type> for #self_ty {
            type Prepared = [f64; #prepared];
            const PLAN: &'static #private::Plan = &#plan;
            const RETURNS_STATE: bool = #returns_state;
            /// What depends on parameters and step size alone.
            #[inline]
            fn prepare(&self, h: f64) -> [f64; #prepared] {
                #prepare
                #kept
            }
            #increment_doc
            #[inline]
            fn increment(
                &self,
                prepared: &[f64; #prepared],
                state: &#private::State<#n>,
                h: f64,
                dw: &[f64; #m],
                newton: &#private::Solver<'_>,
            ) -> ::core::result::Result<([f64; #n], [f64; #n], [f64; #unknowns]), #private::SolveError> {
                #body
            }
            #lanes
            #linearise
        }
    }
}
