//! The rules of many stages: the equations at a node, which these rules share, and once more with the potential of the option `weak2`.

use proc_macro2::TokenStream;

use super::Start;
use super::size::{Budget, Exhausted, within_budget};
use crate::algebra::Arena;
use crate::backend::rust::{self, Context};
use crate::catalogue::Rule;
use crate::discretise::stages::{self, Stages};
use crate::errors::Errors;
use crate::explain;
use crate::model::Model;
use crate::rules::weak2;
use crate::syntax::arguments::ListedRule;
use crate::system::mechanics::Mechanics;

/// The equations at a node, in an arena of their own, with the rules that share these equations.
pub(super) struct Nodes {
    /// The system; if the rules have a potential, it is the last of the noises.
    model: Model,
    /// The derivatives of this system, in stable forms.
    mechanics: Mechanics,
    stages: Stages,
    /// Each rule with its weak order.
    rules: Vec<(Rule, u32)>,
    has_potential: bool,
    arena: Arena,
}

/// Derives the equations at a node of the rules of many stages: of those without a potential, and of those with the potential, which
/// is the same for all of these.
pub(super) fn nodes(
    starts: &[Start<'_>],
    budget: &Budget<'_>,
    mechanics: &Mechanics,
) -> syn::Result<Vec<Nodes>> {
    let of_stages = starts
        .iter()
        .filter(|start| start.listed.rule.stages().is_some());
    let (with, without): (Vec<_>, Vec<_>) = of_stages.partition(|start| start.potential.is_some());
    let groups = [without, with].into_iter();
    groups
        .filter(|group| !group.is_empty())
        .map(|group| Nodes::new(&group, budget, mechanics))
        .collect()
}

impl Nodes {
    /// Derives the equations of rules that have the same potential, or none of which has one.
    fn new(group: &[&Start<'_>], budget: &Budget<'_>, mechanics: &Mechanics) -> syn::Result<Self> {
        let mut arena = group[0].arena.clone().into_owned();
        let potential = group[0].potential.as_ref();
        arena.grant(budget.work);
        let (mut model, mut own) = (budget.model.clone(), mechanics.clone());
        let stages = within_budget(&mut arena, |arena| {
            if let Some(potential) = potential {
                let (noise, jet) = potential.noise(&model, arena);
                (model, own) = (model.with_noise(noise), own.with_noise(jet));
            }
            stages::stages(&model, &own, arena)
        });
        let mut stages = stages.map_err(|Exhausted| {
            budget.rule_too_large(group[0].listed.rule, mechanics, &group[0].arena)
        })?;
        let listed: Vec<&ListedRule> = group.iter().map(|start| start.listed).collect();
        check(&listed, &model, &stages)?;
        let mut weak_order = |rule| weak2::weak_order(rule, budget.model, mechanics, &mut arena);
        let rules = listed.iter().map(|listed| listed.rule);
        let rules = rules.map(|rule| (rule, weak_order(rule))).collect();
        // what is left to do is in proportion to what has been built
        arena.grant(usize::MAX);
        let stable = own.stabilised(&mut arena);
        stages.bound(&model, &own, &mut arena);
        Ok(Self {
            model,
            mechanics: stable,
            stages,
            rules,
            has_potential: potential.is_some(),
            arena,
        })
    }

    /// Prints the equations, and the steps of the rules.
    pub(super) fn output(&self, context: &Context<'_>) -> TokenStream {
        let (stages, arena) = (&self.stages, &self.arena);
        let context = Context { arena, ..*context };
        let of_node = Context {
            model: &self.model,
            mechanics: &self.mechanics,
            ..context
        };
        let code = rust::stages(&of_node, stages, self.has_potential);
        let mut output = TokenStream::new();
        for &(rule, weak_order) in &self.rules {
            let count = rule.stages().unwrap_or_default();
            let term = rule.weak2().filter(|_| self.has_potential);
            let half = term.map(|term| 0.5 * term.factor);
            let (model, mechanics) = (context.model, context.mechanics);
            let texts = explain::gauss(rule, count, half, stages, model, mechanics, arena);
            let rule = (rule, weak_order);
            output.extend(rust::gauss(
                &context, rule, count, half, stages, &code, &texts,
            ));
        }
        output.extend(code.tokens);
        output
    }
}

/// Unknowns of all stages of a step. Newton's method keeps a matrix of this size on the stack, where it is needed.
const UNKNOWNS_OF_STAGES: usize = 160;

/// Returns whether the rule of so many stages is within the limits, in an arena that has the derivatives.
pub(super) fn fits(count: usize, model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> bool {
    let at_node = within_budget(arena, |arena| stages::stages(model, mechanics, arena));
    at_node.is_ok_and(|stages| stages.unknowns(count, model.dof()) <= UNKNOWNS_OF_STAGES)
}

/// Returns an error for each rule whose stages have too many unknowns together.
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
