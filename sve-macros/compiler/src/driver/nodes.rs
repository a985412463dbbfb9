//! The rules of many stages: the equations at a node, which these rules share, and once more with the potential of the option `weak2`.

use proc_macro2::TokenStream;

use super::Budget;
use crate::algebra::Arena;
use crate::backend::rust::{self, Context};
use crate::discretise::stages::{self, Stages};
use crate::errors::Errors;
use crate::explain;
use crate::rules::weak2::Potential;
use crate::rules::{Rule, RuleOption};
use crate::syntax::arguments::ListedRule;
use crate::syntax::parse::Annotated;
use crate::system::mechanics::Mechanics;
use crate::system::model::Model;

/// The equations at a node.
pub(super) struct Nodes {
    /// Without a potential, if there is a rule of many stages.
    plain: Option<Stages>,
    /// With the potential, if a rule has one.
    corrected: Option<Corrected>,
}

/// A system with the potential as the last of its noises.
struct Corrected {
    model: Model,
    mechanics: Mechanics,
    stages: Stages,
}

impl Nodes {
    /// Derives the equations without a potential.
    pub(super) fn new(
        budget: &Budget<'_>,
        mechanics: &Mechanics,
        arena: &mut Arena,
    ) -> syn::Result<Self> {
        let mut nodes = Self {
            plain: None,
            corrected: None,
        };
        let mut rules = budget.block.arguments.rules.iter();
        if rules.any(|listed| listed.rule.stages().is_some()) {
            arena.grant(budget.work);
            let stages = |arena: &mut Arena| stages::stages(budget.model, mechanics, arena);
            let plain = budget.stage(arena, stages)?;
            check(budget.block, budget.model, &plain)?;
            nodes.plain = Some(plain);
        }
        Ok(nodes)
    }

    /// Derives the equations with the potential, if a rule of many stages among these has one. The potential of all these rules is the same.
    pub(super) fn correct(
        &mut self,
        rules: &[&ListedRule],
        potentials: &[Option<Potential>],
        budget: &Budget<'_>,
        mechanics: &Mechanics,
        arena: &mut Arena,
    ) -> syn::Result<()> {
        let mut of_stages = rules.iter().zip(potentials);
        let potential = of_stages.find_map(|(listed, potential)| {
            listed.rule.stages()?;
            potential.as_ref()
        });
        if let Some(potential) = potential {
            arena.grant(budget.work);
            let corrected = |arena: &mut Arena| {
                let (noise, jet) = potential.noise(budget.model, arena);
                let model = budget.model.with_noise(noise);
                let mechanics = mechanics.with_noise(jet);
                let stages = stages::stages(&model, &mechanics, arena);
                Corrected {
                    model,
                    mechanics,
                    stages,
                }
            };
            self.corrected = Some(budget.stage(arena, corrected)?);
        }
        Ok(())
    }

    /// Replaces the derivatives by forms that are stable in floating-point arithmetic.
    pub(super) fn stabilise(&mut self, arena: &mut Arena) {
        if let Some(corrected) = &mut self.corrected {
            corrected.mechanics.stabilise(arena);
        }
    }

    /// Prints the equations, and the steps of the rules, beside which their weak orders stand.
    pub(super) fn output(&self, rules: &[(Rule, u32)], context: &Context<'_>) -> TokenStream {
        let has_term =
            |rule: Rule| self.corrected.is_some() && rule.options.contain(RuleOption::Weak2);
        let (with, without): (Vec<_>, Vec<_>) = rules.iter().partition(|(rule, _)| has_term(*rule));
        let mut output = TokenStream::new();
        if let Some(stages) = self.plain.as_ref().filter(|_| !without.is_empty()) {
            output.extend(steps(&without, context, context, stages));
        }
        if let Some(corrected) = &self.corrected {
            let of_node = Context {
                model: &corrected.model,
                mechanics: &corrected.mechanics,
                ..*context
            };
            output.extend(steps(&with, context, &of_node, &corrected.stages));
        }
        output
    }
}

/// Prints the equations of a system, whose noises may have the potential among them, and the steps of some rules.
fn steps(
    rules: &[&(Rule, u32)],
    context: &Context<'_>,
    of_node: &Context<'_>,
    stages: &Stages,
) -> TokenStream {
    let has_potential = of_node.model.noises.len() > context.model.noises.len();
    let code = rust::stages(of_node, stages, has_potential);
    let mut output = TokenStream::new();
    for &&(rule, weak_order) in rules {
        let count = rule.stages().unwrap_or_default();
        let term = rule.weak2(rule.options).filter(|_| has_potential);
        let half_factor = term.map(|term| 0.5 * term.factor);
        let (model, mechanics) = (context.model, context.mechanics);
        let texts = explain::gauss(
            rule,
            count,
            half_factor,
            stages,
            model,
            mechanics,
            context.arena,
        );
        let rule = (rule, weak_order);
        output.extend(rust::gauss(
            context,
            rule,
            count,
            half_factor,
            stages,
            &code,
            &texts,
        ));
    }
    output.extend(code.tokens);
    output
}

/// Unknowns of all stages of a step. Newton's method keeps a matrix of this size on the stack, where it is needed.
const UNKNOWNS_OF_STAGES: usize = 160;

/// Returns an error for each rule whose stages have too many unknowns together.
fn check(block: &Annotated, model: &Model, at_node: &Stages) -> syn::Result<()> {
    let mut errors = Errors::new();
    for listed in &block.arguments.rules {
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
        let fewer = Rule::all()
            .into_iter()
            .filter(|rule| rule.stages().is_some_and(|s| s <= most));
        let instead = match fewer.last() {
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
