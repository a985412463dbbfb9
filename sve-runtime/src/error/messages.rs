//! Messages of errors that depend on their numbers.

use crate::solve::{MomentumVelocities, SingularRow};

/// The message of `StepError::Time`.
pub(super) fn no_time(t: f64, h: f64, end: f64) -> String {
    if end.is_finite() {
        let next = t.abs().next_up() - t.abs();
        return format!(
            "the step from t = {t} with h = {h:e} does not change the time, whose next number is {next:e} away: \
             take a longer step, or measure time from a nearer origin"
        );
    }
    format!(
        "the step from t = {t} with h = {h:e} ends at t = {end}: take a smaller h, or fewer steps"
    )
}

/// The message of `StepError::WithinStep`.
pub(super) fn within_step(t: f64, from: f64, h: f64, stages: usize) -> String {
    let what = format!(
        "a state at t = {t} is to be saved, within the step from t = {from} with h = {h}, and"
    );
    if stages > 1 {
        return format!(
            "{what} increments at {stages} stages belong to whole steps: give times of whole steps, or use the rule without stage noise"
        );
    }
    format!(
        "{what} this noise does not know its path within a step: give times of whole steps, or a noise that does, such as `Wiener`"
    )
}

/// The message of `StepError::Stiff`.
pub(super) fn stiff(t: f64, h: f64, what: &str, [lower, upper]: [f64; 2]) -> String {
    let step = format!("the step from t = {t} with h = {h:e}");
    if !(upper - lower).is_finite() {
        return format!(
            "{step}: the derivatives of the impulse of {what} have no bounds near the motion, \
             so another solution of its equations cannot be excluded: take a smaller h, or an explicit rule such as `StormerVerlet`"
        );
    }
    // the bounds grow at least with h: those of potentials with h², those of friction with h
    let size = (-lower / 0.5).max(upper / 60.0);
    let smaller = h.abs() / size.max(1.0);
    let reason = if lower <= -1.0 {
        "below -1 its equations may have other solutions than the one of short steps"
    } else {
        "the solution of its equations would take more than 200 sweeps"
    };
    format!(
        "{step} is too long near {what}: h²/4 M⁻¹ ∂²V/∂q², with noise and friction, lies between {lower:.4} and {upper:.4}, and {reason}; \
         take |h| below about {smaller:.1e}, or an explicit rule such as `StormerVerlet`"
    )
}

/// Number of iterations from which on the limit may be too small: a step within reach of the method
/// takes fewer.
const MANY: u32 = 8;

/// The part of a message about the limit of iterations.
pub(super) fn iteration_limit(iterations: u32) -> &'static str {
    // no iteration means a limit of 0
    if iterations == 0 || iterations >= MANY {
        ", or raise `max_iterations` with `with_newton` if that was the limit"
    } else {
        ""
    }
}

/// The message of `StepError::BranchLost`.
pub(super) fn branch_lost(t: f64, h: f64, dw: &[f64], step: f64, reached: f64) -> String {
    let knobs = "take a smaller h, or let the trajectory do so with `refine` where it has that";
    if step < 1.0 {
        return format!(
            "the step from t = {t} with h = {h:e}: its solution was followed from h = 0 without noise and lost at {step:.3} of h, \
             where it ends, branches or leaves the domain of L: {knobs}"
        );
    }
    format!(
        "the step from t = {t} with h = {h:e} and the increments {dw:?}: its solution was followed from no noise and lost at \
         {reached:.3} of the increments, where it ends, branches or leaves the domain of L: {knobs}"
    )
}

/// The message of `StepError::SingularMass`.
pub(super) fn singular_mass([t, h]: [f64; 2], q: &[f64], p: &[f64], found: &SingularRow) -> String {
    let SingularRow {
        row,
        pivot,
        terms,
        velocities,
    } = *found;
    let step = if h == 0.0 {
        String::new()
    } else {
        format!(", where the step with h = {h:e} starts")
    };
    let elsewhere =
        "choose coordinates that are regular there, give the coordinate a mass, or start elsewhere";
    let (found, remedy) = match velocities {
        MomentumVelocities::None { distance } => (
            format!(
                "to rounding no velocity has the momentum p = {p:?}, whose p[{row}] is {distance:e} away from its only value beside the others"
            ),
            elsewhere,
        ),
        MomentumVelocities::Many => (
            format!("many velocities have the momentum p = {p:?}"),
            elsewhere,
        ),
        MomentumVelocities::Rest => (
            format!(
                "rest has the momentum p = {p:?}, but velocities are no differentiable function of the momentum there, as a step needs"
            ),
            "start with another momentum, or add a quadratic kinetic energy",
        ),
        MomentumVelocities::Unknown => (
            format!(
                "∂²L/∂v² is singular at all velocities that were tried for the momentum p = {p:?}"
            ),
            elsewhere,
        ),
    };
    format!(
        "the mass matrix ∂²L/∂v² is singular at t = {t}, q = {q:?}{step}: its elimination leaves {pivot:e} of the row of p[{row}], with terms of size {terms:e}; \
         {found}, so no step starts there: {remedy}"
    )
}
