//! Checks that rules apply to a system. Rules that take no noise, force, constraint or rotations
//! are reported, and options that need noise.

use syn::spanned::Spanned;

use crate::catalogue::{Nodes, Rule, RuleOption, names};
use crate::errors::Errors;
use crate::model::Model;
use crate::syntax::arguments::ListedRule;
use crate::syntax::parse::{Annotated, RoleFunction};
use crate::syntax::roles::Role as FunctionRole;
use crate::system::classify::Classified;
use crate::system::degeneracy::{Degeneracy, Role};
use crate::system::symmetry::check_name;

/// Returns an error for each rule that does not apply to this system.
pub(crate) fn check(block: &Annotated, model: &Model) -> syn::Result<()> {
    let mut errors = Errors::new();
    if let Some(scale) = &block.time_scale {
        check_time_scale(scale, block, model, &mut errors);
    }
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
        if !model.noises.is_empty() && !rule.takes.noise {
            let others = listed_where(|rule| rule.takes.noise);
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
        if model.configuration().has_rotations() && !rule.takes_rotations() {
            errors.push(
                listed.place,
                format!("`{name}` is not for rotations, and the configuration of this block has one: use `midpoint`, `stormer_verlet`, or a composition of them (`Composed::new(Midpoint, KahanLi8)`)"),
            );
        }
        if !model.constraints.is_empty() {
            check_constrained(listed, &mut errors);
        }
        if model.force.is_some() && !rule.takes.force {
            let others = listed_where(|rule| rule.takes.force);
            errors.push(
                listed.place,
                format!("`{name}` is a rule for systems without forces, and this block has a force: use {others}"),
            );
        }
    }
    errors.finish(())
}

/// Reports all that does not apply to a system with a time scale.
fn check_time_scale(scale: &RoleFunction, block: &Annotated, model: &Model, errors: &mut Errors) {
    const WITHOUT: &str = "leave `#[time_scale]` out and take equal steps of t";
    for function in block.noises.iter().chain(&block.forces) {
        let reason = match function.role {
            FunctionRole::Force => {
                "the energy E on which its path stays is constant, and a force changes it"
            }
            _ => {
                "its steps keep no structure with noise, since the energy E of a path is then not constant"
            }
        };
        let message = format!(
            "`#[{}]` is not for a system with a time scale: {reason}; {WITHOUT}",
            function.role.attribute()
        );
        errors.push(function.name.span(), message);
    }
    for constraint in &block.constraints {
        let message = format!(
            "a constraint in a system with a time scale is not derived: use coordinates along the constraint, or {WITHOUT}"
        );
        errors.push(constraint.name.span(), message);
    }
    if model.configuration().has_rotations() {
        let message = format!("a time scale is not for configurations with rotations: {WITHOUT}");
        errors.push(scale.name.span(), message);
    }
    if block.inputs.is_some() {
        let message = format!(
            "a time scale is not for systems with an input `u`: the energy E on which a path stays would jump with it; {WITHOUT}"
        );
        errors.push(scale.name.span(), message);
    }
    for function in [scale, &block.lagrangian] {
        if let Some((time, _)) = function.arguments.first().filter(|_| function.is_timed) {
            let message = format!(
                "a time scale is for systems that do not depend on t, whose energy is constant: leave `t` out, or {WITHOUT}"
            );
            errors.push(time.span(), message);
        }
    }
    for listed in &block.arguments.rules {
        if matches!(listed.rule.nodes, Nodes::Taylor) {
            let name = listed.rule.name();
            let message = format!(
                "`{name}` is not for systems with a time scale, since its step tells no time: use `midpoint` or `gauss(2)`"
            );
            errors.push(listed.place, message);
        }
    }
}

/// Returns an error for each rule, option and function that does not apply to scenes, whose
/// coordinates are slices.
pub(crate) fn check_scene(block: &Annotated) -> syn::Result<()> {
    const RULES: [&str; 4] = ["initial_point", "endpoint", "midpoint", "stormer_verlet"];
    let mut errors = Errors::new();
    let has_h1 = block.noises.iter().any(|f| f.role == FunctionRole::H1);
    for listed in &block.arguments.rules {
        let (rule, name) = (listed.rule, listed.rule.name());
        if !RULES.contains(&rule.attribute_name) {
            let message = format!(
                "`{name}` is not for scenes, systems whose coordinates are slices: use `initial_point`, `endpoint`, `midpoint`, `stormer_verlet`, or a composition of them"
            );
            errors.push(listed.place, message);
        } else if has_h1 && ["initial_point", "endpoint"].contains(&rule.attribute_name) {
            let message = format!(
                "`{name}` with `#[h1]` has a correction with products of all noises, which scenes do not have: use `midpoint`, `stormer_verlet`, or a composition of them"
            );
            errors.push(listed.place, message);
        }
        for &(option, place) in &listed.options {
            let message = format!(
                "`{}` is not for scenes, systems whose coordinates are slices: write `{}`",
                option.name(),
                rule.attribute_name
            );
            errors.push(place, message);
        }
    }
    let tangent = block.noises.iter();
    let tangent = tangent.filter(|f| f.role == FunctionRole::TangentH1);
    for symmetry in &block.symmetries {
        check_name(symmetry, block, &mut errors);
    }
    for function in tangent.chain(&block.constraints).chain(&block.time_scale) {
        let attribute = match function.role {
            FunctionRole::TangentH1 => "h1(tangent)",
            role => role.attribute(),
        };
        let message = format!(
            "`#[{attribute}]` is not for scenes, systems whose coordinates are slices: their functions are `lagrangian`, `#[gamma]`, `#[h1]`, `#[force]`, `#[symmetry]` and helpers"
        );
        errors.push(function.name.span(), message);
    }
    errors.finish(())
}

/// Returns whether a rule without options applies to a system. The Lagrangian must determine every
/// velocity.
pub(crate) fn is_for(rule: Rule, system: &Classified) -> bool {
    let model = &system.model;
    let is_taken = [
        (!model.noises.is_empty(), rule.takes.noise),
        (model.force.is_some(), rule.takes.force),
        (!model.constraints.is_empty(), rule.takes.constraints),
        (
            model.configuration().has_rotations(),
            rule.takes_rotations(),
        ),
    ];
    let is_regular = system.degeneracy.is_none();
    is_regular && is_taken.iter().all(|&(has, takes)| !has || takes)
}

/// Reports a rule or an option that does not apply to systems with constraints.
fn check_constrained(listed: &ListedRule, errors: &mut Errors) {
    let (rule, name) = (listed.rule, listed.rule.name());
    if rule.takes.constraints {
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
    let others = listed_where(|rule| rule.takes.constraints);
    let order = if rule.order > 2 {
        "; for a higher order compose one of them, as in `Composed::new(Midpoint, KahanLi8)`"
    } else {
        ""
    };
    let message = format!(
        "`{name}` is a rule for systems without constraints, and this block has a constraint: use {others}{order}"
    );
    errors.push(listed.place, message);
}

/// Returns an error for each rule, option and function that does not apply to a degenerate
/// Lagrangian.
pub(crate) fn check_degenerate(block: &Annotated, degeneracy: &Degeneracy) -> syn::Result<()> {
    let mut errors = Errors::new();
    let is_linear = !degeneracy.of(Role::Massless).is_empty();
    let is_partial = !degeneracy.of(Role::Massive).is_empty();
    let what = if is_linear {
        "L is affine in velocities"
    } else {
        "some velocities do not occur in L"
    };
    for listed in &block.arguments.rules {
        let (rule, name) = (listed.rule, listed.rule.name());
        for &(option, place) in &listed.options {
            let (option, without) = (option.name(), rule.without(option).name());
            let message = format!("`{option}` is no option where {what}: write `{without}`");
            errors.push(place, message);
        }
        let Some(node) = rule.node() else {
            let message = format!(
                "`{name}` is a rule for Lagrangians that determine every velocity, and {what}: use `midpoint`"
            );
            errors.push(listed.place, message);
            continue;
        };
        if node == 0.5 || !is_linear {
            continue;
        }
        match &degeneracy.internal {
            None if is_partial => errors.push(
                listed.place,
                format!("{what}, and some coordinates have a kinetic energy: `{name}` would integrate another equation; use `midpoint`"),
            ),
            None => errors.push(
                listed.place,
                format!("{what}: `{name}` would integrate another equation; use `midpoint`, or remove the velocities of half of the coordinates from L by adding a total derivative"),
            ),
            Some(form) if form.shifts.is_none() => errors.push(
                listed.place,
                format!("the correction of `{name}` for the noises has no formula, since more than three coordinates are coupled by ∂²L/∂q∂v: use `midpoint`"),
            ),
            Some(_) => {}
        }
    }
    for noise in &block.noises {
        if is_linear && noise.role == FunctionRole::H1 {
            let message = if is_partial {
                "this noise moves momenta, and ∂L/∂v of some coordinates is a function α(q): steps with both are not derived; write the noise as `#[gamma]`, a function of q alone"
            } else {
                "p = α(q) here: write this noise as `#[gamma]`, −H₁(q, α(q))"
            };
            errors.push(noise.name.span(), message);
        }
    }
    if let Some(scale) = &block.time_scale {
        let message = format!(
            "{what}, and steps with a time scale are not derived there: give each velocity a kinetic term, or leave `#[time_scale]` out"
        );
        errors.push(scale.name.span(), message);
    }
    for constraint in &block.constraints {
        let message = format!(
            "{what}, and steps with constraints are not derived there: use coordinates along the constraints, or give each velocity a kinetic term"
        );
        errors.push(constraint.name.span(), message);
    }
    for force in block.forces.iter().chain(&block.noises) {
        let instead = match force.role {
            FunctionRole::Force => "the force as a part of L",
            FunctionRole::NoiseForce => "a force that is a gradient in q as `#[gamma]`",
            _ => continue,
        };
        let message = format!(
            "{what}, and steps with a force are not derived there: write {instead}, or give each velocity a kinetic term"
        );
        errors.push(force.name.span(), message);
    }
    errors.finish(())
}

/// Returns the names of some rules: `a`, `b` or `c`.
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
