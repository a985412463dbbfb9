//! Substeps of one symmetric rule.

use core::borrow::Borrow as _;

use super::sequence::{plan_of, visited};
use super::{Gauss, Midpoint, Mode, Rule, StormerVerlet, Walker};
use crate::system::equations::Memory;
use crate::system::plan::Plan;

/// A symmetric rule: a step of length −h undoes a step of length h. Compositions of substeps raise
/// its order.
#[diagnostic::on_unimplemented(
    message = "a composition does not raise the order of `{Self}`",
    note = "it raises that of the symmetric rules without options: `Midpoint`, `StormerVerlet` and `Gauss::<S>`; `Split::new` composes the initial-point and the endpoint rule"
)]
pub trait Symmetric {}

impl Symmetric for Midpoint {}
impl Symmetric for StormerVerlet {}
impl<const S: usize> Symmetric for Gauss<S> {}

/// The fractions of the step in a composition of a symmetric rule.
pub trait Composition {
    /// A value for each different fraction.
    type Each<T: Clone>: Clone + AsRef<[T]>;
    /// Name of the composition and its order.
    const NAME: &'static str;
    /// Order of convergence without noise.
    const ORDER: u32;
    /// The fractions in order. They add up to 1.
    const FRACTIONS: &'static [f64];
    /// Returns the value of each different fraction.
    fn each<T: Clone>(prepare: impl Fn(f64) -> T) -> Self::Each<T>;
    /// Returns the number of a substep's fraction among the different fractions.
    fn distinct(number: usize) -> usize;
}

/// A symmetric rule in substeps whose lengths are fractions of the step, some of them negative: a
/// rule of a higher order.
///
/// Each substep is a step of the rule, so the composition is symplectic and symmetric, and
/// conserves the same quantities as the rule. The step is explicit if the step of the rule is
/// explicit.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Pendulum { g: f64 }
///
/// #[variational(stormer_verlet)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Integrator::new(Pendulum { g: 1.0 }, Composed::new(StormerVerlet, KahanLi8));
/// assert_eq!(pendulum.plan().deterministic_order, 8);
/// let start = State::new([1.0], [0.0]);
/// let energy = |state: &State<[f64; 1]>| pendulum.system().hamiltonian(state);
/// let before = energy(&start)?;
/// let end = pendulum.trajectory(start, 0.25, NoNoise).take(400).last().unwrap()?;
/// assert!((energy(&end)? - before).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
///
/// With noise the increments are divided like the step. The error is then O(h⁸ + σh) for noise of
/// strength σ: the strong order is the strong order of the rule, and the higher order shows where
/// noise is weak.
///
/// A force of friction is amplified in the substeps of negative length. The composition is correct,
/// but its steps have to resolve the friction. Take a momentum that decays at the rate ν, and
/// [`KahanLi8`](crate::KahanLi8) of the midpoint rule: the relative error is 10⁻⁹ for hν = ½,
/// 4·10⁻⁷ for hν = 1, and a tenth for hν = 3; at hν = 3.3 a substep is singular.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Composed<R, C> {
    rule: R,
    composition: C,
}

impl<R: Symmetric, C: Composition> Composed<R, C> {
    /// Returns the rule in the substeps of the composition.
    pub const fn new(rule: R, composition: C) -> Self {
        Self { rule, composition }
    }
}

/// A composition of symmetric substeps is symmetric if its fractions are the same in reverse order.
impl<R: Symmetric, C> Symmetric for Composed<R, C> {}

/// Returns the higher of two orders: a composition lowers the order of no rule.
const fn higher(a: u32, b: u32) -> u32 {
    if a > b { a } else { b }
}

impl<S, R, C> Rule<S> for Composed<R, C>
where
    R: Rule<S> + Symmetric,
    C: Composition,
{
    type Increments = R::Increments;
    type Prepared = C::Each<R::Prepared>;
    type Memory = R::Memory;
    const STAGES: usize = R::STAGES;
    const SUBSTEPS: usize = C::FRACTIONS.len() * R::SUBSTEPS;
    const PLAN: &'static Plan = &plan_of(
        [R::PLAN],
        R::PLAN.rule,
        C::NAME,
        higher(C::ORDER, R::PLAN.deterministic_order),
        C::FRACTIONS.len(),
    );
    const HAS_INCREMENTS: bool = R::HAS_INCREMENTS;

    fn prepare(system: &S, h: f64) -> Self::Prepared {
        C::each(|part| R::prepare(system, part * h))
    }

    #[inline(always)]
    fn walk<M: Mode<S, R::Increments>>(
        walker: Walker<'_, S, Self>,
        prepared: &Self::Prepared,
        memory: &mut R::Memory,
        h: f64,
        dw: &M::Increments,
        mode: &mut M,
    ) -> Result<(), M::Failure> {
        let start = mode.begin();
        for at in 0..C::FRACTIONS.len() {
            let (number, part) = visited::<S, R::Increments, M>(C::FRACTIONS, at);
            let prepared = &prepared.as_ref()[C::distinct(number)];
            let (h, dw) = (part * h, M::part(dw, part));
            if let Err(failure) = R::walk(walker.by(), prepared, memory, h, dw.borrow(), mode) {
                *memory = R::Memory::none();
                return Err(failure);
            }
        }
        mode.end(start, h);
        Ok(())
    }
}
