//! The gradients of terms → the impulses of steps, in forms that do not cancel.

use super::Derived;
use super::share::share;
use crate::algebra::{Arena, Expr, Purpose};

impl Derived {
    /// Puts the expressions into forms that do not cancel, after the slopes of each term have been
    /// kept.
    pub(super) fn stabilise(&mut self, arena: &mut Arena) {
        let [kicks, shifts] = &mut self.h1;
        let mut all = [&mut self.terms, &mut self.drags, kicks, shifts];
        for term in all.iter_mut().flat_map(|terms| terms.iter_mut()) {
            term.slopes.clone_from(&term.gradient);
        }
        let gradients = all.iter_mut().flat_map(|terms| terms.iter_mut());
        let gradients = gradients.flat_map(|t| t.gradient.iter_mut().flatten());
        let slopes = gradients.chain(self.kinetic.derivatives_mut());
        arena.stabilise(Purpose::Step, slopes.collect());
        let totals = self.totals.iter_mut().flat_map(|t| &mut t.summands);
        let momenta = self.momenta.iter_mut().flat_map(|m| &mut m.summands);
        let summands = self.lagrangian.iter_mut().chain(totals).chain(momenta);
        arena.stabilise(Purpose::Values, summands.map(|s| &mut s.value).collect());
    }

    /// Computes the impulses of each term: its gradient, times the step size unless it is a noise.
    pub(super) fn compute_impulses(&mut self, arena: &mut Arena) {
        let step = arena.symbol(self.step);
        let [kicks, shifts] = &mut self.h1;
        let all = [&mut self.terms, &mut self.drags, kicks, shifts];
        for term in all.into_iter().flatten() {
            term.impulses.clone_from(&term.gradient);
            let impulses = term.impulses.iter_mut().flatten();
            let mut impulses: Vec<&mut Expr> = impulses.collect();
            if !term.is_noise {
                for impulse in &mut impulses {
                    **impulse = arena.mul(step, **impulse);
                }
            }
            share(impulses, arena);
        }
    }
}
