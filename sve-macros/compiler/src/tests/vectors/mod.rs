//! Vectors and matrices of nalgebra: a body with vectors has the same expressions as a body with
//! arrays, and mistakes are reported at their tokens.

mod mistakes;
mod operations;
mod parameters;
mod signatures;

use crate::algebra::Arena;
use crate::errors::Errors;
use crate::interpret;
use crate::model::Model;
use crate::syntax::parse;
use crate::tests::tokens;

/// Returns the model of a block, or its mistakes: the source text at which each is reported, and
/// the message.
pub(super) fn model(members: &str, arena: &mut Arena) -> Result<Model, Vec<(String, String)>> {
    let text = format!("impl P {{ {members} }}");
    let block = syn::parse2(tokens(&text)).expect("a block");
    let mut errors = Errors::new();
    let read = parse::annotated(tokens("midpoint"), block, &mut errors);
    let model = read.and_then(|block| interpret::interpret(&block, arena, &mut errors));
    match errors.finish(model) {
        Ok(model) => Ok(model.expect("a model or an error")),
        Err(errors) => Err(errors
            .into_iter()
            .map(|error| {
                let at = error.span().source_text().unwrap_or_default();
                (at, error.to_string())
            })
            .collect()),
    }
}
