//! Explicit methods, whose steps consist of increments of Euler's method.
//!
//! Input: the formula of a method and the increments of a system. Output: steps of single states
//! and of lanes. The fast path evaluates the straight-line code that the macro wrote, and checks a
//! step once, at its end. If this check fails, the step is repeated from the derivatives of L,
//! which finds the error. Systems without such code always take the second path.
//!
//! Invariant: a stage that is not finite is an error, even if the result is finite.

use crate::error::{StepError, step_error};
use crate::integrator::accept;
use crate::lanes::{ALL, LANES, Lane, Mask, needs_scalar_step};
use crate::mechanics::{Noises, solve_drift};
use crate::phase::Field;
use crate::phase::configuration::{FlatConfiguration, VectorCoordinates};
use crate::phase::lanes::StateLanes;
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::system::euler::EulerIncrement;
use crate::system::{Dims, System};

/// The formula of an explicit method.
pub(super) trait ExplicitFormula {
    /// Number of increments of Euler's method in a step.
    const STAGES: usize;
    /// Returns the increment of a step. `euler` returns the increment of Euler's method at a stage,
    /// over the length of the whole step; its first call is for the start.
    fn formula<const N: usize, E>(
        &self,
        start: &State<[f64; N]>,
        h: f64,
        euler: impl FnMut(&State<[f64; N]>) -> Result<EulerIncrement<[f64; N]>, E>,
    ) -> Result<Field<[f64; N]>, E>;
}

/// Returns the state of a stage: the time moved by `h`, position and momentum by `scale · field`.
#[inline(always)]
pub(super) fn stage<const N: usize>(
    state: &State<[f64; N]>,
    h: f64,
    scale: f64,
    field: &Field<[f64; N]>,
) -> State<[f64; N]> {
    let mut at = State {
        t: state.t + h,
        ..*state
    };
    for i in 0..N {
        at.q[i] += scale * field.q[i];
        at.p[i] += scale * field.p[i];
    }
    at
}

/// A system with the formula of a method.
pub(super) struct Explicit<'a, S, F> {
    pub(super) system: &'a S,
    pub(super) formula: &'a F,
}

/// A sum that is zero if all coordinates are finite, otherwise NaN. Unlike the sum of the
/// coordinates it cannot overflow.
#[derive(Clone, Copy)]
struct Finiteness(f64);

impl Finiteness {
    /// Adds the coordinates of a state.
    #[inline(always)]
    fn add<const N: usize>(&mut self, q: &[f64; N], p: &[f64; N]) {
        for i in 0..N {
            self.0 += 0.0 * q[i] + 0.0 * p[i];
        }
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        self.0 == 0.0
    }
}

impl<S, F, Q, const N: usize, const M: usize> Explicit<'_, S, F>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
    F: ExplicitFormula,
{
    /// Makes one step.
    ///
    /// # Errors
    /// A [`StepError`] if a stage or the result is not finite, or a velocity has no value; the
    /// state is then unchanged.
    #[inline(always)]
    pub(super) fn step(
        &self,
        numbers: Option<&S::EulerNumbers>,
        state: &mut State<[f64; N]>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), StepError> {
        if !S::HAS_EULER_INCREMENT {
            return self.careful_step(state, h, dw);
        }
        let Err(error) = self.fast_step(numbers, state, h, dw) else {
            return Ok(());
        };
        match explained(self.system, self.formula, error, (*state, h, *dw)) {
            Err(error) => Err(error),
            // This arm is never reached: `explained` ends with an error. With `Err(explained(…))`
            // in its place the compiler would not see that a loop of steps ends here, since the
            // value of an error has room for `Ok`, and a loop that may continue after a call cannot
            // keep the state in registers.
            Ok(()) => unreachable!("`explained` ends with an error"),
        }
    }

    /// Makes one step by the code that the macro wrote.
    #[inline(always)]
    fn fast_step(
        &self,
        numbers: Option<&S::EulerNumbers>,
        state: &mut State<[f64; N]>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), SolveError> {
        let singular = SolveError::Singular { iteration: 0 };
        let numbers = numbers.ok_or(singular)?;
        let start = *state;
        let (mut finiteness, mut is_start) = (Finiteness(0.0), true);
        let d = self.formula.formula(&start, h, |at| {
            let State { t, q, p } = at;
            if !is_start {
                finiteness.add(q, p);
            }
            is_start = false;
            self.system
                .euler_increment(numbers, *t, q, p, h, dw)
                .ok_or(singular)
        })?;
        let (q, p) = <[f64; N]>::moved(&start, &d.q, &d.p);
        finiteness.add(&q, &p);
        if !finiteness.is_finite() {
            return Err(SolveError::NonFinite);
        }
        accept::replace_by_finite(state, h, q, p)
    }

    /// Makes one step by the derivatives of L and checks each stage.
    #[inline]
    fn careful_step(
        &self,
        state: &mut State<[f64; N]>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), StepError> {
        let euler = |at: &State<[f64; N]>| careful_increment(self.system, at, h, dw);
        match self.formula.formula(state, h, euler) {
            Ok(d) => accept::advance(state, h, dw, &d.q, &d.p),
            Err(error) => Err(step_error(error, state, h, dw)),
        }
    }

    /// Advances every lane; see [`OneStepMethod::step_lanes`](crate::OneStepMethod::step_lanes).
    #[inline(always)]
    pub(super) fn step_lanes(
        &self,
        numbers: Option<&S::EulerNumbers>,
        states: &StateLanes<N>,
        next: &mut StateLanes<N>,
        h: f64,
        dw: &[Lane; M],
    ) -> Mask {
        let Some(numbers) = numbers.filter(|_| F::STAGES <= S::EULER_STAGES_IN_LANES) else {
            next.clone_from(states);
            return ALL;
        };
        let mut sums = [0.0; LANES];
        let mut any = 0;
        for lane in 0..LANES {
            let start = states.get(lane);
            let dw: [f64; M] = core::array::from_fn(|a| dw[a][lane]);
            let (mut finiteness, mut is_start) = (Finiteness(0.0), true);
            let increment = self.formula.formula(&start, h, |at| {
                let State { t, q, p } = at;
                if !is_start {
                    finiteness.add(q, p);
                }
                is_start = false;
                self.system
                    .euler_increment_in_lane(numbers, *t, q, p, h, &dw)
                    .ok_or(())
            });
            let no_increment = Field {
                q: [f64::NAN; N],
                p: [f64::NAN; N],
            };
            let d = increment.unwrap_or(no_increment);
            let (q, p) = <[f64; N]>::moved(&start, &d.q, &d.p);
            for i in 0..N {
                next.q[i][lane] = q[i];
                next.p[i][lane] = p[i];
            }
            sums[lane] = finiteness.0;
            any |= needs_scalar_step(q, p, finiteness.is_finite());
        }
        next.restore_unsolved(states, any, |lane| Finiteness(sums[lane]).is_finite())
    }
}

/// Returns the error of a step on which the fast path failed: the error that the derivatives of L
/// show, otherwise the error of the fast path.
#[cold]
#[inline(never)]
fn explained<S, F, Q, const N: usize, const M: usize>(
    system: &S,
    formula: &F,
    error: SolveError,
    (state, h, dw): (State<[f64; N]>, f64, [f64; M]),
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
    F: ExplicitFormula,
{
    let step = Explicit { system, formula };
    step.careful_step(&mut { state }, h, &dw)?;
    Err(step_error(error, &state, h, &dw))
}

/// Returns the increment of Euler's method from the derivatives of L.
///
/// # Errors
/// [`SolveError::NonFinite`] if the stage overflowed, which a force that is bounded at infinity
/// would hide; the errors of the Legendre transform.
#[inline]
fn careful_increment<S, Q, const N: usize, const M: usize>(
    system: &S,
    at: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
) -> Result<EulerIncrement<[f64; N]>, SolveError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let mut is_finite = true;
    for i in 0..N {
        is_finite &= at.q[i].is_finite() & at.p[i].is_finite();
    }
    if !is_finite {
        return Err(SolveError::NonFinite);
    }
    let drift = solve_drift(system, at)?;
    let noises = Noises::at(system, at);
    let mut increment = noises.field(dw);
    increment.add_scaled(h, &drift);
    let mut correction = noises.correction();
    for i in 0..N {
        correction.q[i] *= h;
        correction.p[i] *= h;
    }
    Ok(EulerIncrement {
        increment,
        correction: Some(correction),
    })
}

/// Implements `OneStepMethod` for an explicit method that has a field `system` and an
/// [`ExplicitFormula`].
///
/// The second argument names the number of Wiener processes; without it, the method is for systems
/// without noise. The brackets list the fields that are options of the method.
macro_rules! explicit_method {
    ($name:ident) => {
        explicit_method!(@ $name, [], 0,);
    };
    ($name:ident, $m:ident, [$($option:ident),*]) => {
        explicit_method!(@ $name, [$($option),*], $m, const $m: usize);
    };
    (@ $name:ident, [$($option:ident),*], $m:tt, $($generic:tt)*) => {
        impl<S, Q, const N: usize, $($generic)*> crate::method::OneStepMethod for $name<S>
        where
            S: System<Dims = Dims<N, $m, Q>>,
            Q: VectorCoordinates<N>,
        {
            type System = S;
            type Increments = [f64; $m];
            type Prepared = Option<S::EulerNumbers>;

            fn system(&self) -> &S {
                &self.system
            }

            fn identify(&self, to: &mut dyn core::hash::Hasher) {
                to.write(stringify!($name).as_bytes());
                $(to.write(format!("{:?}", self.$option).as_bytes());)*
            }

            fn describe(&self) -> String {
                let options: &[String] = &[$(format!(", {} = {:?}", stringify!($option), self.$option)),*];
                stringify!($name).to_owned() + &options.concat()
            }

            #[inline]
            fn prepare(&self, h: f64) -> Result<Self::Prepared, crate::error::StepError> {
                const { crate::mechanics::constraints::assert_unconstrained::<S>() }
                crate::integrator::accept::check_step_size(h)?;
                Ok(self.system.euler_numbers(h))
            }

            #[inline(always)]
            fn step_prepared(
                &self,
                prepared: &Self::Prepared,
                state: &mut State<Q>,
                h: f64,
                dw: &[f64; $m],
            ) -> Result<(), crate::error::StepError> {
                const { assert!(S::ROLES.is_empty(), "{}", crate::mechanics::degenerate::NEEDS_REGULAR) };
                let explicit = crate::baseline::explicit::Explicit { system: &self.system, formula: self };
                Q::in_coordinates(state, |state| explicit.step(prepared.as_ref(), state, h, dw))
            }

            #[inline(always)]
            fn step_lanes(
                &self,
                prepared: &Self::Prepared,
                states: &crate::phase::lanes::StateLanes<N>,
                next: &mut crate::phase::lanes::StateLanes<N>,
                h: f64,
                dw: &[crate::lanes::Lane; $m],
            ) -> crate::lanes::Mask {
                let explicit = crate::baseline::explicit::Explicit { system: &self.system, formula: self };
                explicit.step_lanes(prepared.as_ref(), states, next, h, dw)
            }
        }
    };
}
pub(super) use explicit_method;

#[cfg(test)]
mod tests {
    use super::{Field, State, stage};

    #[test]
    fn a_stage_moves_time_and_state() {
        let field = Field {
            q: [2.0, -4.0],
            p: [8.0, 1e300],
        };
        let start = State::at(1.0, [1.0, 1.0], [0.0, 0.0]);
        let expected = State::at(1.5, [1.5, 0.0], [2.0, 0.25e300]);
        assert_eq!(stage(&start, 0.5, 0.25, &field), expected);
    }
}
