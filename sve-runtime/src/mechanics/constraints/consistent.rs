//! Projection of a state onto the constraints: φ(q) = 0, then ∂φ/∂t + ∂φ/∂q v = 0.
//!
//! The configuration moves along `M⁻¹ ∂φ/∂qᵀ` (Gauss–Newton, mass-orthogonal), the momentum along
//! `∂φ/∂qᵀ`.

use nalgebra::DVector;

use super::{Dependent, Linearised};
use crate::error::StepError;
use crate::phase::configuration::{Coordinates, FlatConfiguration, VectorCoordinates};
use crate::phase::state::State;
use crate::system::{Dims, System};

/// Largest number of Gauss–Newton steps. From a start within reach the projection makes about 5.
const MAX_ITERATIONS: u32 = 60;

/// Violation of a constraint, relative to its terms, that is only rounding error.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Largest violation at which the last iterations may stop: rounding errors of φ can be larger than
/// the rounding errors of its terms.
const ROUNDING_OF_FUNCTIONS: f64 = 1e-12;

/// Returns the state on the constraints that is nearest to a given state in the metric of the
/// masses.
pub(crate) fn project<S, Q, const N: usize, const M: usize>(
    system: &S,
    given: &State<[f64; N]>,
) -> Result<State<[f64; N]>, StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let t = given.t;
    let numbers = [("q", &given.q), ("p", &given.p)];
    for (name, values) in numbers {
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            let (what, value) = (format!("{name}[{i}]"), values[i]);
            return Err(StepError::NonFiniteInput { what, value, t });
        }
    }
    let (q, here) = configuration_on(system, given)?;
    if let Some(error) = rank_error::<S, Q, N, M>(system, &here, t, &q) {
        return Err(error);
    }
    let p = momentum_along(&here, given.p).ok_or_else(|| singular(t, &q))?;
    Ok(State { t, q, p })
}

/// Returns the configuration on the constraints, with the constraints and masses there.
fn configuration_on<S, Q, const N: usize, const M: usize>(
    system: &S,
    given: &State<[f64; N]>,
) -> Result<([f64; N], Linearised<N>), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let t = given.t;
    let mut q = given.q;
    let mut here = Linearised::at(system, t, &q).ok_or_else(|| singular(t, &q))?;
    for iterations in 0.. {
        let (worst, violation) = here.worst();
        if violation <= ROUNDING {
            break;
        }
        let lost = || StepError::NoConsistentState {
            t,
            q: given.q.to_vec(),
            iterations,
            constraint: S::CONSTRAINTS[worst].into(),
            value: here.jets[worst].value,
        };
        if iterations == MAX_ITERATIONS || !violation.is_finite() {
            return Err(lost());
        }
        if let Some(error) = dependence_error::<S, Q, N, M>(&here, t, &q) {
            return Err(error);
        }
        let values = DVector::from_iterator(here.jets.len(), here.jets.iter().map(|j| j.value));
        let step = here.solve(&values).ok_or_else(lost)?;
        let step = &here.directions * step;
        // a step that increases the violation is halved
        let (mut part, mut next) = (1.0, None);
        while part > 1e-4 {
            let to: [f64; N] = core::array::from_fn(|i| q[i] - part * step[i]);
            let there = Linearised::at(system, t, &to).ok_or_else(|| singular(t, &to))?;
            if there.worst().1 < violation {
                next = Some((to, there));
                break;
            }
            part *= 0.5;
        }
        match next {
            Some((to, there)) => (q, here) = (to, there),
            None if violation <= ROUNDING_OF_FUNCTIONS => break,
            None => return Err(lost()),
        }
    }
    Ok((q, here))
}

/// Returns the momentum whose velocity keeps the constraints; `None` if the mass matrix is
/// singular.
fn momentum_along<const N: usize>(here: &Linearised<N>, given: [f64; N]) -> Option<[f64; N]> {
    let mut p = given;
    // the second pass removes the rounding errors of the first
    for _ in 0..2 {
        let relative = DVector::from_fn(N, |i, _| p[i] - here.rest[i]);
        let velocity = here.mass.clone().lu().solve(&relative)?;
        let rates = here.jets.iter().map(|jet| {
            let along = jet.dq.iter().zip(velocity.iter());
            jet.dt + along.map(|(a, v)| a * v).sum::<f64>()
        });
        let rates = DVector::from_iterator(here.jets.len(), rates);
        let multipliers = here.solve(&rates)?;
        for (jet, &multiplier) in here.jets.iter().zip(multipliers.iter()) {
            for i in 0..N {
                p[i] -= multiplier * jet.dq[i];
            }
        }
    }
    Some(p)
}

fn singular<const N: usize>(t: f64, q: &[f64; N]) -> StepError {
    StepError::Singular {
        t,
        h: 0.0,
        q: q.to_vec(),
        iteration: 0,
    }
}

/// Returns the error of dependent constraints, or of a constraint whose gradient vanishes with it.
pub(super) fn rank_error<S, Q, const N: usize, const M: usize>(
    system: &S,
    here: &Linearised<N>,
    t: f64,
    q: &Q::Flat,
) -> Option<StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    if let Some(error) = dependence_error::<S, Q, N, M>(here, t, q) {
        return Some(error);
    }
    let Dependent { k, pivot } = here.vanishing::<S, Q, M>(system, t, q)?;
    let jet = &here.jets[k];
    Some(StepError::ConstraintGradient {
        t,
        q: q.values(),
        constraint: S::CONSTRAINTS[k].into(),
        value: jet.value,
        magnitude: jet.magnitude,
        gradient: jet.dq.to_vec(),
        change: pivot,
    })
}

/// Returns the error of dependent constraints.
fn dependence_error<S, Q, const N: usize, const M: usize>(
    here: &Linearised<N>,
    t: f64,
    q: &Q::Flat,
) -> Option<StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let Dependent { k, pivot } = here.dependent()?;
    Some(StepError::ConstraintRank {
        t,
        q: q.values(),
        k,
        constraint: S::CONSTRAINTS[k].into(),
        pivot,
    })
}
