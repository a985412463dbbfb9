//! The rules of many stages. They share the equations at a node; rules with the option `weak2`
//! share these equations with its potential.

use super::{Source, Start};
use crate::algebra::Arena;
use crate::catalogue::Rule;
use crate::discretise::stages::{Stages, stages};
use crate::errors::Errors;
use crate::model::Model;
use crate::rules::weak2;
use crate::syntax::arguments::ListedRule;
use crate::system::classify::Classified;
use crate::system::mechanics::Mechanics;
use crate::system::size::{Exhausted, within_budget};

/// The equations at a node, in an arena of their own, with the rules that share these equations.
pub(crate) struct Nodes {
    /// The system. If the rules have a potential, it is the last of the noises.
    pub(crate) model: Model,
    /// The derivatives of this system, in stable forms.
    pub(crate) mechanics: Mechanics,
    pub(crate) stages: Stages,
    /// Each rule with its weak order.
    pub(crate) rules: Vec<(Rule, u32)>,
    pub(crate) has_potential: bool,
    pub(crate) arena: Arena,
}

impl Source<'_> {
    /// Derives the equations at a node for the rules of many stages: once for rules without a
    /// potential, and once for rules with the potential, which is the same for all of them.
    pub(super) fn nodes(&self, starts: &[Start<'_>]) -> syn::Result<Vec<Nodes>> {
        let of_stages = starts
            .iter()
            .filter(|start| start.listed.rule.stages().is_some());
        let (with, without): (Vec<_>, Vec<_>) =
            of_stages.partition(|start| start.potential.is_some());
        let groups = [without, with].into_iter();
        groups
            .filter(|group| !group.is_empty())
            .map(|group| self.node(&group))
            .collect()
    }

    /// Derives the equations of rules that all have the same potential, or all have none.
    fn node(&self, group: &[&Start<'_>]) -> syn::Result<Nodes> {
        let mut arena = group[0].arena.clone().into_owned();
        let potential = group[0].potential.as_ref();
        arena.grant(self.budget.work);
        let (mut model, mut mechanics) = (self.system.model.clone(), self.system.mechanics.clone());
        let at_node = within_budget(&mut arena, |arena| {
            if let Some(potential) = potential {
                let (noise, jet) = potential.noise(&model, arena);
                (model, mechanics) = (model.with_noise(noise), mechanics.with_noise(jet));
            }
            stages(&model, &mechanics, arena)
        });
        let too_large = |Exhausted| self.rule_too_large(group[0].listed.rule, &group[0].arena);
        let mut stages = at_node.map_err(too_large)?;
        let listed: Vec<&ListedRule> = group.iter().map(|start| start.listed).collect();
        check(&listed, &model, &stages)?;
        let rules = within_budget(&mut arena, |arena| {
            let mut weak_order = |rule| weak2::weak_order(rule, self.system, arena);
            let rules = listed.iter().map(|listed| listed.rule);
            rules.map(|rule| (rule, weak_order(rule))).collect()
        });
        let rules = rules.map_err(too_large)?;
        // the remaining work is proportional to the size of the expressions built so far
        arena.grant(usize::MAX);
        let stable = mechanics.stabilised(&mut arena);
        stages.bound(&model, &mechanics, &mut arena);
        Ok(Nodes {
            model,
            mechanics: stable,
            stages,
            rules,
            has_potential: potential.is_some(),
            arena,
        })
    }
}

/// Largest number of unknowns of all stages of a step. Newton's method keeps a matrix of this size
/// on the stack.
const UNKNOWNS_OF_STAGES: usize = 160;

/// Returns whether a rule with this number of stages is within the limits. The arena has the
/// derivatives.
pub(super) fn fits(count: usize, system: &Classified, arena: &mut Arena) -> bool {
    let (model, mechanics) = (&system.model, &system.mechanics);
    let at_node = within_budget(arena, |arena| stages(model, mechanics, arena));
    at_node.is_ok_and(|stages| stages.unknowns(count, model.dof()) <= UNKNOWNS_OF_STAGES)
}

/// Returns an error for each rule whose stages together have too many unknowns.
fn check(rules: &[&ListedRule], model: &Model, at_node: &Stages) -> syn::Result<()> {
    let mut errors = Errors::new();
    for listed in rules {
        let Some(stages) = listed.rule.stages() else {
            continue;
        };
        let of_one = at_node.unknowns(1, model.dof());
        let (n, unknowns) = (model.dof(), stages * of_one);
        if unknowns <= UNKNOWNS_OF_STAGES {
            continue;
        }
        let name = listed.rule.name();
        let most = UNKNOWNS_OF_STAGES / of_one;
        let mut fewer = Rule::all()
            .into_iter()
            .filter(|rule| rule.stages().is_some_and(|s| s <= most));
        let instead = match fewer.next_back() {
            Some(rule) => format!("`{}`, or a composition of `midpoint`", rule.name()),
            None => "a composition of `midpoint`".to_owned(),
        };
        errors.push(
            listed.place,
            format!("`{name}` has {unknowns} unknowns for {n} coordinates, and the limit is {UNKNOWNS_OF_STAGES}: use {instead} (`Composed`)"),
        );
    }
    errors.finish(())
}
