//! A derivation → the implementations of a block.

use proc_macro2::TokenStream;

use super::{
    Context, bounded, gauss, inputs, momenta, private, rule, stages, start_of_step, system,
    time_scale,
};
use crate::derivation::{Derivation, Nodes};
use crate::explain;

/// Prints all that was derived from a block.
pub(crate) fn print(derivation: &Derivation) -> TokenStream {
    let Derivation {
        settings,
        block,
        system: classified,
        functions,
        start,
        nodes,
        steps,
        arena,
    } = derivation;
    let model = &classified.model;
    let private = &private(block);
    let context = Context {
        settings: *settings,
        block,
        model,
        mechanics: &classified.mechanics,
        commutation: &classified.commutation,
        degeneracy: classified.degeneracy.as_ref(),
        momenta: &classified.momenta,
        about: &explain::system(classified, arena),
        arena,
        private,
        stepped: &inputs::stepped(block),
    };
    let mut output = system(&context, functions);
    output.extend(start_of_step(&context, start));
    output.extend(momenta(&context));
    output.extend(time_scale::time_scale(&context));
    output.extend(
        nodes
            .iter()
            .map(|nodes| rules_of_nodes(&context, derivation, nodes)),
    );
    for derived in steps {
        let arena = &derived.arena;
        let texts = explain::step(derived, classified);
        output.extend(rule(&Context { arena, ..context }, derived, &texts));
    }
    output.extend(inputs::unread(
        block,
        &model.symbols,
        model.formulas(),
        arena,
    ));
    let of = (context.block, &context.model.symbols);
    bounded(inputs::within(context.private, of, output))
}

/// Prints the equations at a node, and the steps of the rules that share these equations.
fn rules_of_nodes(context: &Context<'_>, derivation: &Derivation, nodes: &Nodes) -> TokenStream {
    let (equations, arena) = (&nodes.stages, &nodes.arena);
    let context = Context { arena, ..*context };
    let at_node = Context {
        model: &nodes.model,
        mechanics: &nodes.mechanics,
        ..context
    };
    let code = stages(&at_node, nodes);
    let mut output = TokenStream::new();
    for &(rule, weak_order) in &nodes.rules {
        let count = rule.stages().unwrap_or_default();
        let term = rule.weak2().filter(|_| nodes.has_potential);
        let half = term.map(|term| 0.5 * term.factor);
        let texts = explain::gauss(rule, count, half, equations, &derivation.system, arena);
        let rule = (rule, weak_order);
        output.extend(gauss(&context, rule, count, half, equations, &code, &texts));
    }
    output.extend(code.tokens);
    output
}
