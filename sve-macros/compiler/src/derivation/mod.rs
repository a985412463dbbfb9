//! `Classified` → [`Derivation`]: the steps of all rules of a block, each in an arena of its own,
//! and the functions that no step needs.
//!
//! Invariant: a rule is derived from the classified system alone. The terms of a sum stand in the
//! order in which their expressions were created, so in a common arena a rule would change the
//! rounding of other rules.

mod nodes;
mod step;

use std::borrow::Cow;

use crate::algebra::Arena;
use crate::catalogue::RuleOption;
use crate::errors::Errors;
use crate::rules::correction::{self, Correction};
use crate::rules::weak2::{self, Potential};
use crate::settings::Settings;
use crate::structure::StartTest;
use crate::syntax::arguments::ListedRule;
use crate::syntax::parse::Annotated;
use crate::system::classify::Classified;
use crate::system::functions::{Functions, functions};
use crate::system::inverse_mass::NoFormula;
use crate::system::size::Budget;
pub(crate) use nodes::Nodes;
pub(crate) use step::Derived;

/// The results of the derivation of a block.
pub(crate) struct Derivation {
    pub(crate) settings: Settings,
    pub(crate) block: Annotated,
    pub(crate) system: Classified,
    /// The functions of the system that no step needs.
    pub(crate) functions: Functions,
    /// The tests of the start of a step.
    pub(crate) start: StartTest,
    /// The rules of many stages, in groups that share the equations at a node.
    pub(crate) nodes: Vec<Nodes>,
    /// The other rules, and the steps without structure.
    pub(crate) steps: Vec<Derived>,
    /// Owner of the expressions of `system`, `functions` and `start`.
    pub(crate) arena: Arena,
}

/// Derives the rules of a block. The arena has the expressions of the system.
pub(crate) fn derive(
    block: Annotated,
    system: Classified,
    budget: &Budget,
    settings: Settings,
    mut arena: Arena,
) -> syn::Result<Derivation> {
    let source = Source {
        block: &block,
        system: &system,
        budget,
    };
    let starts = source.starts(&arena)?;
    let nodes = source.nodes(&starts)?;
    let steps = source.steps(&starts, settings.unstructured)?;
    drop(starts);
    // the remaining work is proportional to the size of the expressions built so far
    arena.grant(usize::MAX);
    let functions = functions(&system, settings.lanes, &mut arena);
    let start = StartTest::new(&system, &functions.mechanics, &mut arena);
    Ok(Derivation {
        settings,
        block,
        system,
        functions,
        start,
        nodes,
        steps,
        arena,
    })
}

/// The input that all rules share.
struct Source<'a> {
    block: &'a Annotated,
    system: &'a Classified,
    budget: &'a Budget,
}

/// The input of the derivation of one rule.
struct Start<'a> {
    listed: &'a ListedRule,
    /// The potential of the option `weak2`, if it changes the step.
    potential: Option<Potential>,
    /// The corrections of the noises with forces.
    correction: Vec<Correction>,
    /// The expressions of the derivatives and of the potential.
    arena: Cow<'a, Arena>,
}

impl<'a> Source<'a> {
    /// Returns the input of each rule, or an error at each option `weak2` that has no use.
    fn starts(&self, arena: &'a Arena) -> syn::Result<Vec<Start<'a>>> {
        let mut errors = Errors::new();
        let mut starts = Vec::new();
        for listed in &self.block.arguments.rules {
            let mut start = Start {
                listed,
                potential: None,
                correction: Vec::new(),
                arena: Cow::Borrowed(arena),
            };
            if listed.rule.has_correction() && self.system.has_noise_forces() {
                match self.correction(start.arena.to_mut())? {
                    Ok(correction) => start.correction = correction,
                    Err(reason) => errors.push(listed.place, without_correction(listed, reason)),
                }
            }
            if listed.rule.options.contain(RuleOption::Weak2) {
                let takes_h1 = listed.rule.weak2().is_some_and(|option| option.takes_h1);
                let own = start.arena.to_mut();
                own.grant(self.budget.work);
                let potential = self
                    .budget
                    .stage(own, |own| weak2::potential(self.system, takes_h1, own))?;
                match potential {
                    Ok(potential) => start.potential = potential,
                    Err(obstacle) => errors.push(
                        listed.place_of(RuleOption::Weak2),
                        obstacle.message(listed.rule),
                    ),
                }
            }
            starts.push(start);
        }
        errors.finish(starts)
    }

    /// Returns the corrections of the noises with forces, for a rule with one node at an end.
    fn correction(&self, arena: &mut Arena) -> syn::Result<Result<Vec<Correction>, NoFormula>> {
        arena.grant(self.budget.work);
        let stage = |arena: &mut Arena| correction::corrections(self.system, arena);
        self.budget.stage(arena, stage)
    }
}

/// Returns the message for a rule whose correction has no formula.
fn without_correction(listed: &ListedRule, reason: NoFormula) -> String {
    let (NoFormula::TooManyCoupled(coupled) | NoFormula::NoPivot(coupled)) = reason;
    format!(
        "the Stratonovich correction of `{}` for a noise force that depends on velocities needs the inverse of the mass matrix as a formula, and ∂²L/∂v² couples {coupled} coordinates: use `midpoint` or `stormer_verlet`",
        listed.rule.name()
    )
}
