//! The steps of rules: action → equations → scheme → linearisation.

use super::{Source, Start, nodes};
use crate::algebra::{Arena, Expr};
use crate::catalogue::{Rule, RuleOption};
use crate::discretise::equations::equations;
use crate::linearise::{Linearisation, linearise};
use crate::model::{Meaning, Symbols};
use crate::rules::action::{Action, Terms, discretise};
use crate::rules::weak2;
use crate::structure::{self, Degenerate, Scheme};
use crate::system::applicable;
use crate::system::size::{Exhausted, within_budget};

/// A rule with the results of its derivation.
pub(crate) struct Derived {
    pub(crate) rule: Rule,
    /// True if this is the step without structure.
    pub(crate) is_unstructured: bool,
    pub(crate) weak_order: u32,
    pub(crate) symbols: Symbols,
    pub(crate) action: Action,
    pub(crate) scheme: Scheme<Expr>,
    pub(crate) linearisation: Linearisation,
    /// Owner of the expressions.
    pub(crate) arena: Arena,
}

/// The reason why a rule has no step.
enum Obstacle {
    /// The granted work is used up.
    Work,
    /// The equations do not determine some unknowns. The symbols give their names.
    Degenerate(Degenerate, Symbols),
}

impl From<Exhausted> for Obstacle {
    fn from(_: Exhausted) -> Self {
        Self::Work
    }
}

impl Source<'_> {
    /// Derives the steps of the rules with few nodes. For `both`, derives the steps of all rules
    /// without structure too.
    pub(super) fn steps(&self, starts: &[Start<'_>], both: bool) -> syn::Result<Vec<Derived>> {
        let mut steps = Vec::new();
        for is_unstructured in [false, true].into_iter().take(1 + usize::from(both)) {
            for start in starts {
                // the Gauss rules are derived from one node; their whole action is used for
                // comparison only
                let rule = start.listed.rule;
                let has_stage_noise = rule.options.contain(RuleOption::StageNoise);
                if rule.stages().is_none() || (is_unstructured && !has_stage_noise) {
                    steps.push(self.step(start, is_unstructured)?);
                }
            }
        }
        Ok(steps)
    }

    /// Derives the step of a listed rule.
    fn step(&self, start: &Start<'_>, is_unstructured: bool) -> syn::Result<Derived> {
        let rule = start.listed.rule;
        let terms = Terms {
            potential: start.potential.as_ref(),
            correction: &start.correction,
        };
        let mut arena = start.arena.clone().into_owned();
        arena.grant(self.budget.work);
        let derived = self.derive(rule, terms, is_unstructured, arena);
        derived.map_err(|obstacle| match obstacle {
            Obstacle::Work => self.rule_too_large(rule, &start.arena),
            Obstacle::Degenerate(degenerate, symbols) => self.singular(&degenerate, &symbols),
        })
    }

    /// Derives the step of a rule. The arena has the derivatives and the granted work.
    fn derive(
        &self,
        rule: Rule,
        terms: Terms<'_>,
        is_unstructured: bool,
        mut arena: Arena,
    ) -> Result<Derived, Obstacle> {
        let (model, degeneracy) = (&self.system.model, self.system.degeneracy.as_ref());
        let mut symbols = model.symbols.clone();
        let (action, scheme) = within_budget(&mut arena, |arena| {
            let action = discretise(rule, model, degeneracy, terms, &mut symbols, arena);
            let equations = equations(&action, &symbols, arena);
            let scheme = if is_unstructured {
                Ok(structure::unstructured(equations, &mut symbols, arena))
            } else {
                structure::analyse(equations, &action, &mut symbols, arena)
            };
            (action, scheme)
        })?;
        let scheme = match scheme {
            Ok(scheme) => scheme,
            Err(degenerate) => return Err(Obstacle::Degenerate(degenerate, symbols)),
        };
        let (linearisation, weak_order) = within_budget(&mut arena, |arena| {
            let linearisation = linearise(&scheme, &action, &symbols, arena);
            let weak_order = weak2::weak_order(rule, self.system, arena);
            (linearisation, weak_order)
        })?;
        // printing takes work in proportion to the size of the expressions built so far
        arena.grant(usize::MAX);
        Ok(Derived {
            rule,
            is_unstructured,
            weak_order,
            symbols,
            action,
            scheme,
            linearisation,
            arena,
        })
    }

    /// Returns the error of a rule that takes too much work. The message names the other rules that
    /// do not; to find them, each is derived from the derivatives in `arena`.
    pub(super) fn rule_too_large(&self, rule: Rule, arena: &Arena) -> syn::Error {
        let others = Rule::all().into_iter().filter(|other| {
            let is_tried = other.stages().is_none_or(|stages| stages == 2);
            is_tried && other.name() != rule.name() && applicable::is_for(*other, self.system)
        });
        let within = others.filter(|&other| {
            let mut own = arena.clone();
            own.grant(self.budget.work);
            match other.stages() {
                None => self.derive(other, Terms::NONE, false, own).is_ok(),
                Some(stages) => nodes::fits(stages, self.system, &mut own),
            }
        });
        let names: Vec<String> = within.map(|rule| format!("`{}`", rule.name())).collect();
        let instead = match names.as_slice() {
            [] => String::new(),
            [name] => format!("; {name} is within the limit"),
            names => format!("; within the limit are {}", names.join(", ")),
        };
        let what = format!("`{}` takes", rule.name());
        self.budget.too_large(&what, &instead)
    }

    /// Returns the error of a structurally singular step: L does not determine some velocities.
    fn singular(&self, degenerate: &Degenerate, symbols: &Symbols) -> syn::Error {
        let names = degenerate.unknowns.iter();
        let names = names.map(|&u| match symbols.meaning(u) {
            Meaning::Unknown(unknown) => format!("`{unknown}`"),
            _ => String::new(),
        });
        let names: Vec<String> = names.collect();
        let message = format!(
            "this Lagrangian is degenerate: the step's equations do not determine {}; every velocity must occur in L, quadratically or otherwise non-linearly",
            names.join(", ")
        );
        syn::Error::new(self.block.lagrangian.name.span(), message)
    }
}
