//! Limits of the size of a system: the work that its derivatives and each of its rules may take,
//! and the errors of larger systems.

use proc_macro2::Span;

use crate::algebra::Arena;
use crate::model::Model;
use crate::syntax::parse::Annotated;

/// Work granted to the derivatives, and then to each rule, in the units of the arena's budget. A
/// unit is some 20 nanoseconds of an optimised build. A dense system of 48 coordinates takes five
/// sixths of this work.
pub(crate) const WORK: usize = 200_000_000;

/// Largest number of second derivatives of L and of the noises, zeros included.
const ENTRIES: usize = 200_000;

/// The work granted to the derivatives, and then to each rule, of a system.
#[derive(Clone, Copy)]
pub(crate) struct Budget {
    pub(crate) work: usize,
    degrees_of_freedom: usize,
    noises: usize,
    /// The place of errors: the name of the Lagrangian.
    place: Span,
}

/// The error of a stage that has used up its work.
pub(crate) struct Exhausted;

/// Runs a stage. Returns [`Exhausted`] if the granted work is used up.
pub(crate) fn within_budget<T>(
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

impl Budget {
    /// Returns the budget of a system, or an error if there would be too many second derivatives.
    pub(crate) fn new(block: &Annotated, model: &Model, work: usize) -> syn::Result<Self> {
        let place = block.lagrangian.name.span();
        let (n, m) = (model.dof(), model.noises.len());
        let entries = (m + 1).saturating_mul(3 * n * n);
        if entries > ENTRIES {
            let message = format!(
                "this system is too large to unroll: {n} coordinates and {m} noise terms have {entries} second derivatives, which every rule needs, and the limit is {ENTRIES}; use fewer of them"
            );
            return Err(syn::Error::new(place, message));
        }
        Ok(Self {
            work,
            degrees_of_freedom: n,
            noises: m,
            place,
        })
    }

    /// Runs a stage that all rules share. Returns an error if the granted work is used up.
    pub(crate) fn stage<T>(
        &self,
        arena: &mut Arena,
        run: impl FnOnce(&mut Arena) -> T,
    ) -> syn::Result<T> {
        within_budget(arena, run)
            .map_err(|Exhausted| self.too_large("the derivatives that every rule needs take", ""))
    }

    /// Returns the error of a system in which `what` takes too much work. The message advises
    /// `instead`.
    pub(crate) fn too_large(&self, what: &str, instead: &str) -> syn::Error {
        let message = format!(
            "this system is too large to unroll: with {} coordinates and {} noise terms {what} more than {} operations of the macro, which is the limit{instead}; use fewer coordinates or noise terms, shorter loops, or helpers that are called less often",
            self.degrees_of_freedom, self.noises, self.work,
        );
        syn::Error::new(self.place, message)
    }
}
