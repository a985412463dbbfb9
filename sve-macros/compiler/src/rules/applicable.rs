//! Which rules are for a system: errors for those that take no noise, no force, no constraint or no rotations, and for options that need noise.

use super::{Rule, RuleOption, names};
use crate::errors::Errors;
use crate::syntax::arguments::ListedRule;
use crate::syntax::parse::Annotated;
use crate::system::model::Model;

/// Returns an error for each rule that is not for this system.
pub(crate) fn check(block: &Annotated, model: &Model) -> syn::Result<()> {
    let mut errors = Errors::new();
    if model.configuration().has_rotations()
        && let Some(constraint) = block.constraints.first()
    {
        errors.push(
            constraint.name.span(),
            "constraints are not for configurations with rotations: hold a point of a body by a stiff spring, or leave the constraint out",
        );
    }
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
        if !model.constraints.is_empty() {
            check_constrained(listed, &mut errors);
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

/// Reports a rule or an option that is not for systems with constraints.
fn check_constrained(listed: &ListedRule, errors: &mut Errors) {
    let (rule, name) = (listed.rule, listed.rule.name());
    if rule.takes_constraints() {
        let weak2 = listed.options.iter().filter(|o| o.0 == RuleOption::Weak2);
        for &(_, place) in weak2 {
            let without = rule.without(RuleOption::Weak2).name();
            let message = format!(
                "`weak2` is an option for systems without constraints: its potential is that of free motion; write `{without}`"
            );
            errors.push(place, message);
        }
        return;
    }
    let others = listed_where(|rule| rule.takes_constraints());
    let order = if rule.deterministic_order() > 2 {
        "; for a higher order compose one of them, as in `Composed::new(Midpoint, KahanLi8)`"
    } else {
        ""
    };
    let message = format!(
        "`{name}` is a rule for systems without constraints, and this block has a constraint: use {others}{order}"
    );
    errors.push(listed.place, message);
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
