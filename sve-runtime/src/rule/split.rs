//! Substeps that alternate between the initial-point rule and its adjoint, the endpoint rule:
//! splittings of T(v) − V(q).

use core::borrow::Borrow as _;

use super::coefficients::{BlanesMoan4, BlanesMoanRkn6};
use super::sequence::{plan_of, visited};
use super::{Endpoint, InitialPoint, Mode, Rule, Walker};
use crate::system::equations::Memory;
use crate::system::plan::Plan;

/// A system with `L = T(v) − V(t, q)`. Implemented by `#[variational(…)]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be split: its Lagrangian is not T(v) − V(t, q)",
    note = "`Split` needs a kinetic energy that depends on v alone; `Composed::new(Midpoint, KahanLi8)` and `Gauss::<S>` take any Lagrangian"
)]
pub trait Separable {}

/// A system with `L = ½ vᵀMv − V(t, q)` and a constant matrix M. Implemented by
/// `#[variational(…)]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no Runge–Kutta–Nyström splitting: its kinetic energy is not ½ vᵀMv with a constant M",
    note = "use `Split::new(BlanesMoan4)` where L = T(v) − V(t, q), or `Composed::new(Midpoint, KahanLi8)`"
)]
pub trait QuadraticKineticEnergy: Separable {}

/// The fractions of the step in a splitting: α₁, β₁, α₂, β₂, … of the initial-point and the
/// endpoint rule.
pub trait Coefficients {
    /// A value for each pair α, β.
    type Each<T: Clone>: Clone + AsRef<[T]>;
    /// Name of the splitting and its order.
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

/// A splitting of the step into kicks by the potential and drifts: steps of the initial-point rule
/// alternate with steps of the endpoint rule.
///
/// For Lagrangians T(v) − V(t, q) whose attribute lists both rules. The step is explicit if noise
/// is in q alone.
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
/// With noise the increments are divided like the step, and the strong order is 1 if the noises
/// commute. A force of friction is amplified in the substeps of negative length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Split<C> {
    splitting: C,
}

impl<C: Coefficients> Split<C> {
    /// Returns the splitting with these coefficients.
    pub const fn new(splitting: C) -> Self {
        Self { splitting }
    }
}

/// The values that both rules prepare for a pair of fractions.
type Prepared<S> = (
    <InitialPoint as Rule<S>>::Prepared,
    <Endpoint as Rule<S>>::Prepared,
);

/// The increments that both rules take.
type IncrementsOf<S> = <InitialPoint as Rule<S>>::Increments;

impl<S, C> Rule<S> for Split<C>
where
    InitialPoint: Rule<S>,
    Endpoint: Rule<S, Increments = IncrementsOf<S>>,
    C: Splitting<S>,
{
    type Increments = IncrementsOf<S>;
    type Prepared = C::Each<Prepared<S>>;
    type Memory = ();
    const STAGES: usize = 1;
    const SUBSTEPS: usize = C::FRACTIONS.len();
    const PLAN: &'static Plan = &plan_of(
        [<InitialPoint as Rule<S>>::PLAN, <Endpoint as Rule<S>>::PLAN],
        "initial_point, endpoint",
        C::NAME,
        C::ORDER,
        C::FRACTIONS.len(),
    );
    const HAS_INCREMENTS: bool =
        <InitialPoint as Rule<S>>::HAS_INCREMENTS && <Endpoint as Rule<S>>::HAS_INCREMENTS;

    fn prepare(system: &S, h: f64) -> Self::Prepared {
        C::each(|pair| {
            let [alpha, beta] = [C::FRACTIONS[2 * pair], C::FRACTIONS[2 * pair + 1]];
            (
                InitialPoint::prepare(system, alpha * h),
                Endpoint::prepare(system, beta * h),
            )
        })
    }

    #[inline(always)]
    fn walk<M: Mode<S, IncrementsOf<S>>>(
        walker: Walker<'_, S, Self>,
        prepared: &Self::Prepared,
        (): &mut (),
        h: f64,
        dw: &M::Increments,
        mode: &mut M,
    ) -> Result<(), M::Failure> {
        let start = mode.begin();
        for at in 0..C::FRACTIONS.len() {
            let (number, part) = visited::<S, IncrementsOf<S>, M>(C::FRACTIONS, at);
            let (first, second) = &prepared.as_ref()[number / 2];
            let (h, part) = (part * h, M::part(dw, part));
            let dw = part.borrow();
            if number.is_multiple_of(2) {
                InitialPoint::walk(walker.by(), first, &mut Memory::none(), h, dw, mode)?;
            } else {
                Endpoint::walk(walker.by(), second, &mut Memory::none(), h, dw, mode)?;
            }
        }
        mode.end(start, h);
        Ok(())
    }
}
