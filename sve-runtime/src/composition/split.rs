//! Substeps that alternate between the initial-point rule and its adjoint, the endpoint rule: splittings of T(v) − V(q).

use nalgebra::DMatrix;

use super::coefficients::{BlanesMoan4, BlanesMoanRkn6};
use super::sequence::{Sequence, Shared, plan_of};
use crate::error::StepError;
use crate::lanes::Mask;
use crate::lanes::tangents::LaneDirections;
use crate::linearisation::{Covector, Directions};
use crate::plan::Plan;
use crate::rules::{Endpoint, InitialPoint};
use crate::system::{
    FlatStateOf, IncrementLanesOf, IncrementsOf, StateLanesOf, TangentLanesOf, VectorOf,
};
use crate::variational::{Discretised, Memory, Variational};

/// A system with `L = T(v) − V(t, q)`. Implemented by `#[variational(…)]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be split: its Lagrangian is not T(v) − V(t, q)",
    note = "`Split` needs a kinetic energy that depends on v alone; `Composed::new(Midpoint, KahanLi8)` and `Gauss::<S>` take any Lagrangian"
)]
pub trait Separable {}

/// A system with `L = ½ vᵀMv − V(t, q)` and a constant matrix M. Implemented by `#[variational(…)]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no Runge–Kutta–Nyström splitting: its kinetic energy is not ½ vᵀMv with a constant M",
    note = "use `Split::new(BlanesMoan4)` where L = T(v) − V(t, q), or `Composed::new(Midpoint, KahanLi8)`"
)]
pub trait QuadraticKineticEnergy: Separable {}

/// The fractions of the step in a splitting: α₁, β₁, α₂, β₂, … of the initial-point and the endpoint rule.
pub trait Coefficients {
    /// A value for each pair α, β.
    type Each<T: Clone>: Clone + AsRef<[T]>;
    /// Name and order.
    const NAME: &'static str;
    /// Order of convergence without noise.
    const ORDER: u32;
    /// The fractions in order. They add up to 1.
    const FRACTIONS: &'static [f64];
    /// Returns the value of each pair, by its number.
    fn each<T: Clone>(prepare: impl Fn(usize) -> T) -> Self::Each<T>;
}

/// A splitting that the system `S` admits.
pub trait Splitting<S>: Coefficients {}

impl<S: Separable> Splitting<S> for BlanesMoan4 {}
impl<S: QuadraticKineticEnergy> Splitting<S> for BlanesMoanRkn6 {}

/// A splitting of the step into kicks by the potential and drifts: steps of the initial-point rule alternate with steps of the endpoint rule.
///
/// For Lagrangians T(v) − V(t, q), whose attribute lists both rules. The step is explicit where noise is in q alone.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Pendulum { g: f64 }
///
/// #[variational(initial_point, endpoint)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Integrator::new(Pendulum { g: 1.0 }, Split::new(BlanesMoanRkn6));
/// assert_eq!(pendulum.plan().deterministic_order, 6);
/// let start = State::new([1.0], [0.0]);
/// let energy = |state: &State<[f64; 1]>| pendulum.system().hamiltonian(state);
/// let before = energy(&start)?;
/// let end = pendulum.trajectory(start, 0.25, NoNoise).take(400).last().unwrap()?;
/// assert!((energy(&end)? - before).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
///
/// With noise the increments are divided like the step, and the strong order is 1 where noises commute. A force of friction is amplified in the substeps
/// of negative length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Split<C> {
    splitting: C,
}

impl<C: Coefficients> Split<C> {
    /// The splitting with these coefficients.
    pub const fn new(splitting: C) -> Self {
        Self { splitting }
    }
}

/// What both rules prepare for a pair of fractions, and carry.
type Prepared<S> = (
    <S as Discretised<InitialPoint>>::Prepared,
    <S as Discretised<Endpoint>>::Prepared,
);

/// Returns whether a substep is one of the initial-point rule.
const fn is_initial(number: usize) -> bool {
    number.is_multiple_of(2)
}

impl<S, C> Sequence<S> for Split<C>
where
    S: Variational<InitialPoint> + Variational<Endpoint>,
    C: Splitting<S>,
{
    type Increments = IncrementsOf<S>;
    type Prepared = C::Each<Prepared<S>>;
    type Memory = ();
    const STAGES: usize = 1;
    const PLAN: &'static Plan = &plan_of(
        [
            <S as Discretised<InitialPoint>>::PLAN,
            <S as Discretised<Endpoint>>::PLAN,
        ],
        "initial_point, endpoint",
        C::NAME,
        C::ORDER,
        C::FRACTIONS.len(),
    );
    const HAS_INCREMENTS: bool = <S as Discretised<InitialPoint>>::HAS_INCREMENTS
        && <S as Discretised<Endpoint>>::HAS_INCREMENTS;
    const FRACTIONS: &'static [f64] = C::FRACTIONS;

    fn prepare(system: &S, h: f64) -> Self::Prepared {
        C::each(|pair| {
            let [alpha, beta] = [C::FRACTIONS[2 * pair], C::FRACTIONS[2 * pair + 1]];
            (
                Discretised::<InitialPoint>::prepare(system, alpha * h),
                Discretised::<Endpoint>::prepare(system, beta * h),
            )
        })
    }

    #[inline]
    fn advance(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        (): &mut (),
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
    ) -> Result<(), StepError> {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            let memory = &mut Memory::none();
            Discretised::<InitialPoint>::advance(system, newton, first, memory, state, h, dw)
        } else {
            let memory = &mut Memory::none();
            Discretised::<Endpoint>::advance(system, newton, second, memory, state, h, dw)
        }
    }

    #[inline]
    fn advance_compensated(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        (): &mut (),
        state: [&mut FlatStateOf<S>; 2],
        h: f64,
        dw: &IncrementsOf<S>,
    ) -> Result<(), StepError> {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            let memory = &mut Memory::none();
            Discretised::<InitialPoint>::advance_compensated(
                system, newton, first, memory, state, h, dw,
            )
        } else {
            let memory = &mut Memory::none();
            Discretised::<Endpoint>::advance_compensated(
                system, newton, second, memory, state, h, dw,
            )
        }
    }

    #[inline(always)]
    fn advance_lanes(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
    ) -> Mask {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            Discretised::<InitialPoint>::advance_lanes(system, newton, first, states, next, h, dw)
        } else {
            Discretised::<Endpoint>::advance_lanes(system, newton, second, states, next, h, dw)
        }
    }

    #[inline(always)]
    fn push_forward_lanes(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
        tangents: LaneDirections<'_, TangentLanesOf<S>>,
    ) -> [Mask; 2] {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            Discretised::<InitialPoint>::push_forward_lanes(
                system, newton, first, states, next, h, dw, tangents,
            )
        } else {
            Discretised::<Endpoint>::push_forward_lanes(
                system, newton, second, states, next, h, dw, tangents,
            )
        }
    }

    fn advance_with_derivatives(
        shared: Shared<'_, S, ()>,
        number: usize,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
    ) -> Result<DMatrix<f64>, StepError> {
        let Shared { system, newton, .. } = shared;
        if is_initial(number) {
            Discretised::<InitialPoint>::advance_with_derivatives(system, newton, state, h, dw)
        } else {
            Discretised::<Endpoint>::advance_with_derivatives(system, newton, state, h, dw)
        }
    }

    fn push_forward(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
        along: Directions<'_, VectorOf<S>>,
    ) -> Result<(), StepError> {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            Discretised::<InitialPoint>::push_forward(system, newton, first, state, h, dw, along)
        } else {
            Discretised::<Endpoint>::push_forward(system, newton, second, state, h, dw, along)
        }
    }

    fn pull_back(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
        covector: Covector<'_, VectorOf<S>>,
    ) -> Result<(), StepError> {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            Discretised::<InitialPoint>::pull_back(system, newton, first, state, h, dw, covector)
        } else {
            Discretised::<Endpoint>::pull_back(system, newton, second, state, h, dw, covector)
        }
    }

    fn newton_iterations(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
    ) -> Option<u32> {
        let Shared { system, newton, .. } = shared;
        let (first, second) = &shared.prepared.as_ref()[number / 2];
        if is_initial(number) {
            Discretised::<InitialPoint>::newton_iterations(system, newton, first, state, h, dw)
        } else {
            Discretised::<Endpoint>::newton_iterations(system, newton, second, state, h, dw)
        }
    }
}
