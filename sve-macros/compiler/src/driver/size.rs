//! How large a system may be: the work that its derivatives and each of its rules may take, and the errors of systems that are larger.

use super::{derive_step, nodes};
use crate::algebra::Arena;
use crate::catalogue::Rule;
use crate::model::Model;
use crate::rules::applicable;
use crate::syntax::parse::Annotated;
use crate::system::mechanics::Mechanics;

/// Work that the derivatives may take, and then each rule, in the units of the arena's budget; a unit is some 20 nanoseconds of
/// an optimised build. A dense system of 48 coordinates takes five sixths of it.
pub(super) const WORK: usize = 200_000_000;

/// Second derivatives of L and of the noises that are written down, zeros included.
const ENTRIES: usize = 200_000;

/// The work that is granted to the derivatives, and then to each rule.
pub(super) struct Budget<'a> {
    pub(super) block: &'a Annotated,
    pub(super) model: &'a Model,
    pub(super) work: usize,
}

/// The work that was granted is used up.
pub(super) struct Exhausted;

/// Runs a stage. Returns [`Exhausted`] if the work that was granted is used up.
pub(super) fn within_budget<T>(
    arena: &mut Arena,
    run: impl FnOnce(&mut Arena) -> T,
) -> Result<T, Exhausted> {
    let result = run(arena);
    if arena.is_exhausted() {
        Err(Exhausted)
    } else {
        Ok(result)
    }
}

impl<'a> Budget<'a> {
    pub(super) fn new(block: &'a Annotated, model: &'a Model, work: usize) -> Self {
        Self { block, model, work }
    }

    /// Runs a stage that all rules share. Returns an error if the work that was granted is used up.
    pub(super) fn stage<T>(
        &self,
        arena: &mut Arena,
        run: impl FnOnce(&mut Arena) -> T,
    ) -> syn::Result<T> {
        within_budget(arena, run)
            .map_err(|Exhausted| self.too_large("the derivatives that every rule needs take", ""))
    }

    /// The error of a rule that takes too much work. It names the other rules that do not; each of them is derived to know this, from
    /// the derivatives in `arena`.
    pub(super) fn rule_too_large(
        &self,
        rule: Rule,
        mechanics: &Mechanics,
        arena: &Arena,
    ) -> syn::Error {
        let others = Rule::all().into_iter().filter(|other| {
            let is_tried = other.stages().is_none_or(|stages| stages == 2);
            is_tried && other.name() != rule.name() && applicable::is_for(*other, self.model)
        });
        let within = others.filter(|&other| {
            let mut own = arena.clone();
            own.grant(self.work);
            match other.stages() {
                None => derive_step(other, None, false, self, mechanics, own).is_ok(),
                Some(stages) => nodes::fits(stages, self.model, mechanics, &mut own),
            }
        });
        let names: Vec<String> = within.map(|rule| format!("`{}`", rule.name())).collect();
        let instead = match names.as_slice() {
            [] => String::new(),
            [name] => format!("; {name} is within the limit"),
            names => format!("; within the limit are {}", names.join(", ")),
        };
        self.too_large(&format!("`{}` takes", rule.name()), &instead)
    }

    fn too_large(&self, what: &str, instead: &str) -> syn::Error {
        let message = format!(
            "this system is too large to unroll: with {} coordinates and {} noise terms {what} more than {} operations of the macro, which is the limit{instead}; use fewer coordinates or noise terms, shorter loops, or helpers that are called less often",
            self.model.dof(),
            self.model.noises.len(),
            self.work,
        );
        syn::Error::new(self.block.lagrangian.name.span(), message)
    }
}

/// Returns an error if there would be too many second derivatives.
pub(super) fn check_entries(block: &Annotated, model: &Model) -> syn::Result<()> {
    let (n, m) = (model.dof(), model.noises.len());
    let entries = (m + 1).saturating_mul(3 * n * n);
    if entries <= ENTRIES {
        return Ok(());
    }
    let message = format!(
        "this system is too large to unroll: {n} coordinates and {m} noise terms have {entries} second derivatives, which every rule needs, and the limit is {ENTRIES}; use fewer of them"
    );
    Err(syn::Error::new(block.lagrangian.name.span(), message))
}
