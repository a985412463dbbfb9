//! Which rules are for a system: errors for those that take no noise, no force or no rotations, and for options that need noise.

use super::{Rule, names};
use crate::errors::Errors;
use crate::syntax::parse::Annotated;
use crate::system::model::Model;

/// Returns an error for each rule that is not for this system.
pub(crate) fn check(block: &Annotated, model: &Model) -> syn::Result<()> {
    let mut errors = Errors::new();
    for listed in &block.arguments.rules {
        let (rule, name) = (listed.rule, listed.rule.name());
        if !model.noises.is_empty() && !rule.takes_noise() {
            let others = listed_where(|rule| rule.takes_noise());
            errors.push(
                listed.place,
                format!("`{name}` is a rule for systems without noise, and this block has noise terms: use {others}"),
            );
        }
        if model.noises.is_empty() {
            for &(option, place) in &listed.options {
                let (option, without) = (option.name(), rule.without(option).name());
                let message = format!(
                    "`{option}` is an option for systems with noise, and this block has no noise terms: write `{without}`"
                );
                errors.push(place, message);
            }
        }
        if model.configuration().has_rotations() && !rule.takes_rotations(rule.options) {
            errors.push(
                listed.place,
                format!("`{name}` is not for rotations, and the configuration of this block has one: use `midpoint`, or a composition of it (`Composed::new(Midpoint, KahanLi8)`)"),
            );
        }
        if model.force.is_some() && !rule.takes_force() {
            let others = listed_where(|rule| rule.takes_force());
            errors.push(
                listed.place,
                format!("`{name}` is a rule for systems without forces, and this block has a force: use {others}"),
            );
        }
    }
    errors.finish(())
}

/// The names of some rules: `a`, `b` or `c`.
fn listed_where(wanted: impl Fn(&Rule) -> bool) -> String {
    let mut rules = Rule::all();
    rules.retain(wanted);
    let mut names = names(&rules);
    names.reverse();
    match names.split_last() {
        Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => names.concat(),
    }
}
