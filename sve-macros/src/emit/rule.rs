//! `impl Variational<Rule>`: what surrounds a step.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::code::Printer;
use super::linearise::linearise;
use super::plan::plan;
use super::step::schedule;
use super::{attributes, private};
use crate::action::Action;
use crate::mechanics::Mechanics;
use crate::model::{Model, Symbols};
use crate::parse::Annotated;
use crate::rule::Rule;
use crate::structure::{Form, Scheme};
use crate::symbolic::Arena;
use crate::tangent::Linearisation;

#[allow(clippy::too_many_arguments)] // every stage's output is read here, and nowhere after
pub(crate) fn rule(
    rule: Rule,
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    action: &Action,
    scheme: &Scheme,
    linearisation: &Linearisation,
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
    let mut printer = Printer::new(&step.program, symbols, &private);
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
        &step.program,
        symbols,
    );
    let returns_state = scheme.form == Form::State;
    let unknowns = Literal::usize_unsuffixed(linearisation.unknowns.len());
    let linearise = linearise(&private, model, linearisation, symbols, arena);
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
            ) -> ::core::result::Result<([f64; #n], [f64; #n], [f64; #unknowns]), #private::SolveError> {
                #body
            }
            #linearise
        }
    }
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
