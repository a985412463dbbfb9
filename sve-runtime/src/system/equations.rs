//! The equations of a step: the interface between the code that the macro derives for a rule and
//! the integrator.
//!
//! Invariant: nothing here changes a state. The integrator decides which solutions are accepted.

use core::fmt::Debug;

use crate::lanes::{ALL, Mask};
use crate::phase::tangents::{KeepUnknowns, LaneDirections};
use crate::solve::SolveError;
use crate::solve::newton::{BlockSolver, Newton};
use crate::system::linearisation::{Linearisation, Unknowns};
use crate::system::plan::Plan;
use crate::system::start::StartOfStep;
use crate::system::{
    FlatOf, FlatStateOf, IncrementLanesOf, Increments, StateLanesOf, TangentLanesOf, VectorOf,
};

/// Numbers that a trajectory carries from one step to the next: results that the next step would
/// compute again, or starting points of its iteration.
///
/// A step without these numbers gives the same result, up to the rounding error of the iteration.
pub trait Memory: Clone + Debug {
    /// Returns the memory before the first step.
    fn none() -> Self;
    /// Returns the numbers; none before the first step.
    fn numbers(&self) -> &[f64];
    /// Returns the memory with these numbers; `None` if their count is wrong.
    fn from_numbers(numbers: &[f64]) -> Option<Self>;
}

/// The memory of a step that carries nothing.
impl Memory for () {
    #[inline(always)]
    fn none() -> Self {}

    fn numbers(&self) -> &[f64] {
        &[]
    }

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        numbers.is_empty().then_some(())
    }
}

/// A memory of `K` numbers, or of none before the first step.
impl<const K: usize> Memory for Option<[f64; K]> {
    #[inline(always)]
    fn none() -> Self {
        None
    }

    fn numbers(&self) -> &[f64] {
        self.as_ref().map_or(&[], |numbers| numbers.as_slice())
    }

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        if numbers.is_empty() {
            return Some(None);
        }
        numbers.try_into().ok().map(Some)
    }
}

/// The form in which a step returns its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Returns {
    /// `q₁ − q₀` and `p₁ − p₀`.
    Increment,
    /// `q₁` and `p₁`: a matrix that differs from step to step times the state, and an offset.
    /// Adding an increment would only lengthen the chain of operations.
    State,
    /// `q₁ − q₀` and `p₁ − p₀` as a matrix, the same in all steps, times the state, and an offset.
    MatrixTimesState,
}

impl Returns {
    /// Returns whether the step returns the state at its end, in place of an increment of the state
    /// at its start.
    pub(crate) const fn is_state(self) -> bool {
        matches!(self, Self::State)
    }
}

/// The equations of the step of a rule, solved and linearised. `#[variational]` implements this
/// trait for each rule that it derives.
///
/// Integrators, and code for all rules, ask for a [`Rule`](crate::Rule), since compositions are
/// rules too.
#[diagnostic::on_unimplemented(
    message = "no step of the rule `{R}` has been derived for `{Self}`",
    label = "this rule is not in the attribute of the `impl` block",
    note = "list the rule in the attribute, for example `#[variational(midpoint, endpoint)]`; \
            the attribute names are `initial_point`, `endpoint`, `midpoint`, `stormer_verlet`, `gauss(2)` to `gauss(8)`, `taylor2`"
)]
pub trait StepEquations<R>: StartOfStep {
    /// The increments of a step, one number for each process.
    type Increments: Increments;
    /// Values that depend on parameters and step size only.
    type Prepared: Clone;
    /// The numbers that a trajectory carries from step to step.
    type Memory: Memory;
    /// The unknowns of all blocks, `[f64; K]`.
    type Unknowns: Unknowns;
    /// The conditions of the domain, as text: they hold where the functions in L and in the noises
    /// are defined.
    const DOMAIN: &'static [&'static str] = &[];
    /// Number of increments of a process in a step: 1, or the number of stages of a rule with stage
    /// noise.
    const STAGES: usize = 1;
    /// The plan of the step.
    const PLAN: &'static Plan;
    /// True if the equations are not solved where the mass matrix at the start is singular, or
    /// where no velocity of the momentum is found, so that no further test of the start is needed.
    const PROVES_START: bool = false;
    /// The form of the result of [`increment`](Self::increment).
    const RETURNS: Returns;
    /// Computes the values that depend on parameters and step size only.
    fn prepare(&self, h: f64) -> Self::Prepared;
    /// Returns the unknowns of all blocks in the limit of no noise and h → 0, from velocity and
    /// acceleration at the start of the step.
    fn start(
        &self,
        state: &FlatStateOf<Self>,
        velocity: &VectorOf<Self>,
        acceleration: &VectorOf<Self>,
    ) -> Self::Unknowns;
    /// Solves one step. Returns `(q₁ − q₀, p₁ − p₀)` or `(q₁, p₁)`, see [`RETURNS`](Self::RETURNS),
    /// and the unknowns of all blocks. `memory` has the numbers of the step before; the step may
    /// use them, and writes its own numbers.
    ///
    /// # Errors
    /// A [`SolveError`] if an implicit equation of the step cannot be solved.
    fn increment(
        &self,
        prepared: &Self::Prepared,
        memory: &mut Self::Memory,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
        newton: &BlockSolver<'_>,
    ) -> Result<StepOf<Self, R>, SolveError>;
    /// Advances every lane on the fast path and writes the result to `next`, and the unknowns of
    /// all blocks to `unknowns`. Returns the mask of lanes that the fast path could not solve;
    /// their states are copied unchanged, and the caller steps them with
    /// [`increment`](Self::increment). Times in `next` are not written.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)] // the arguments of a step and the unknowns
    fn increment_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self::Increments>,
        newton: &Newton,
        unknowns: &mut impl KeepUnknowns,
    ) -> Mask {
        let _ = (prepared, h, dw, newton, unknowns);
        next.clone_from(states);
        ALL
    }
    /// Carries tangent vectors along a step in lanes, around the unknowns that solve it. Returns
    /// the mask of lanes whose vectors are invalid. The default implementation marks every lane.
    #[inline(always)]
    fn linearise_lanes(
        &self,
        states: &StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self::Increments>,
        unknowns: &<Self::Unknowns as Unknowns>::Lanes,
        tangents: LaneDirections<'_, TangentLanesOf<Self>>,
    ) -> Mask {
        let _ = (states, h, dw, unknowns, tangents);
        ALL
    }
    /// Visits the multipliers of the constraints of a solved step: the impulses at the start of the
    /// step, then the impulses at its end.
    fn multipliers(
        &self,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
        unknowns: &Self::Unknowns,
        visit: &mut dyn FnMut(f64),
    ) {
        let _ = (state, h, dw, unknowns, visit);
    }
    /// Visits the positions of the nodes of a solved step with their weights in the action, for a
    /// system with a time scale. The derivative of the action by the energy is h times the weighted
    /// sum of the time scale at the nodes.
    #[inline(always)]
    fn nodes(
        &self,
        start: &FlatStateOf<Self>,
        end: &FlatStateOf<Self>,
        h: f64,
        unknowns: &Self::Unknowns,
        visit: &mut dyn FnMut(f64, &FlatOf<Self>),
    ) {
        let _ = (start, end, h, unknowns, visit);
    }
    /// Linearises the step's equations and results around a solved step. Returns the result of
    /// `then`.
    fn linearise<T>(
        &self,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
        unknowns: &Self::Unknowns,
        then: impl FnOnce(Linearisation<'_>) -> T,
    ) -> T;
}

/// Visits nodes between the ends of a step: each with its weight, and its place as a fraction of
/// the displacement.
#[inline]
pub fn nodes_between<const N: usize>(
    start: &[f64; N],
    end: &[f64; N],
    nodes: &[(f64, f64)],
    visit: &mut dyn FnMut(f64, &[f64; N]),
) {
    for &(weight, place) in nodes {
        let at = core::array::from_fn(|n| start[n] + place * (end[n] - start[n]));
        visit(weight, &at);
    }
}

/// The result of [`StepEquations::increment`].
pub type StepOf<S, R> = (VectorOf<S>, VectorOf<S>, <S as StepEquations<R>>::Unknowns);
