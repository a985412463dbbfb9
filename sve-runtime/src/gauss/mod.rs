//! The Gauss rules, of any number of stages and for any Lagrangian. Generated implementations of a
//! step call these functions.
//!
//! | file | part |
//! | --- | --- |
//! | `nodes.rs`, `double_double.rs`, `tableau.rs` | the coefficients, computed by the compiler |
//! | `step.rs` | a step: its equations, and the forces at a stage |
//! | `newton.rs` | Newton's method for the equations of all stages |
//! | `fixed_point.rs`, `convergence.rs` | fixed-point iteration with the stages in lanes |
//! | `scaled.rs`, `stages.rs` | its coefficients times the step size, and sums over stages |
//! | `bounds.rs`, `connected.rs`, `room.rs` | the proof that a solution is the connected one |
//! | `stage_noise.rs` | increments at the stages |
//! | `memory.rs` | the numbers that a trajectory carries from step to step |
//! | `linearise.rs` | the linearised step |
//! | `potential.rs` | the term of the option `weak2` |
//! | `legendre.rs`, `adapted.rs`, `step_size.rs` | steps whose size is adapted to a tolerance |
//!
//! A step with four stages or more is first solved by fixed-point iteration if its Lagrangian
//! allows it. The solution is accepted if the iteration contracts, which is sampled along the
//! iterates. Where the iteration does not contract, and with fewer stages, Newton's method solves
//! the step. Its solution is accepted
//! - for linear equations, which have one solution;
//! - for systems of up to four coordinates whose functions have bounds, if the bounds prove that
//!   the solution is the connected one;
//! - for other systems, if each iteration leaves at most 1/64 of the residual.
//!
//! If a solution is not accepted, [`continuation`](crate::continuation) follows it from the limit.

pub(crate) mod adapted;
mod bounds;
mod connected;
pub(crate) mod convergence;
mod double_double;
mod fixed_point;
mod jacobian;
mod legendre;
mod linearise;
mod memory;
mod newton;
mod nodes;
mod partitioned;
mod potential;
mod room;
mod scaled;
pub(crate) mod stage_noise;
mod stages;
mod step;
pub(crate) mod step_size;
mod tableau;

pub use adapted::{AdaptedSteps, Attempt, StageSeries, partitioned_attempt, second_order_attempt};
pub use bounds::{NodeBounds, NoiseBounds, Radii, StageBounds, Uniqueness};
pub use fixed_point::{SecondOrder, StageLanes};
pub(crate) use legendre::integral;
pub use linearise::{ByParameters, ParameterJet};
pub use partitioned::{Masses, Motion, Partitioned};
pub use potential::{Corrected, WithPotential, with_potential};
pub use scaled::{SecondOrderCoefficients, inverse_mass};

use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::solve::newton::BlockSolver;
use crate::system::linearisation::Linearisation;
use crate::system::{Dims, System};
use memory::solve_from_memory;
use newton::Solved;
use step::{Step, at_stage};
use tableau::Tableau;

/// Solves a step by Newton's method.
///
/// # Errors
/// A [`SolveError`] if the equations cannot be solved.
pub fn newton_increment<Sys, Q, const S: usize, const N: usize, const M: usize, const K: usize>(
    system: &Sys,
    state: &State<[f64; N]>,
    h: f64,
    noise: [[f64; S]; M],
    solver: &BlockSolver<'_>,
) -> Result<Solved<N, K>, SolveError>
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    Step::<_, S, N, M>::new(system, state, h, noise).solve(solver)
}

/// Solves a step of a system of second order, first by fixed-point iteration. `memory` holds the
/// impulses of the step before.
///
/// # Errors
/// As [`newton_increment`].
#[inline]
pub fn second_order_increment<
    Sys,
    Q,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
    const L: usize,
>(
    system: &Sys,
    coefficients: &SecondOrderCoefficients<S, N>,
    memory: &mut Option<[f64; L]>,
    state: &State<[f64; N]>,
    h: f64,
    noise: [[f64; S]; M],
    solver: &BlockSolver<'_>,
) -> Result<Solved<N, K>, SolveError>
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>> + SecondOrder<N, M>,
    Q: VectorCoordinates<N>,
{
    let step = Step::<_, S, N, M>::new(system, state, h, noise);
    if solver.is_fast_path() {
        let solve = |before: Option<&[_; 1]>| {
            let before = before.map(|[impulses]| impulses);
            let (solved, impulses) = fixed_point::solve_second_order(&step, coefficients, before)?;
            Some((solved, [impulses]))
        };
        if let Some(solved) = solve_from_memory(memory, h, solve) {
            return Ok(solved);
        }
    }
    solve_by_newton(&step, solver)
}

/// Solves a step of a system with ∂L/∂v affine in v, first by fixed-point iteration. `memory` holds
/// the displacements and impulses of the step before.
///
/// # Errors
/// As [`newton_increment`].
#[inline]
pub fn partitioned_increment<
    Sys,
    Q,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
    const L: usize,
>(
    system: &Sys,
    memory: &mut Option<[f64; L]>,
    state: &State<[f64; N]>,
    h: f64,
    noise: [[f64; S]; M],
    solver: &BlockSolver<'_>,
) -> Result<Solved<N, K>, SolveError>
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>> + Partitioned<N, M>,
    Q: VectorCoordinates<N>,
{
    let step = Step::<_, S, N, M>::new(system, state, h, noise);
    if solver.is_fast_path() {
        let solve = |before: Option<&_>| partitioned::solve_partitioned(&step, before);
        if let Some(solved) = solve_from_memory(memory, h, solve) {
            return Ok(solved);
        }
    }
    solve_by_newton(&step, solver)
}

/// Solves a step whose fixed-point iteration does not contract.
#[cold]
#[inline(never)]
fn solve_by_newton<Sys, Q, const S: usize, const N: usize, const M: usize, const K: usize>(
    step: &Step<'_, Sys, S, N, M>,
    solver: &BlockSolver<'_>,
) -> Result<Solved<N, K>, SolveError>
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    step.solve(solver)
}

/// Returns the parts of the increments at the stages, in proportion to the weights.
#[inline(always)]
#[must_use]
pub fn shares<const S: usize, const M: usize>(dw: &[f64; M]) -> [[f64; S]; M] {
    let b = const { &Tableau::<S>::VALUES.b };
    dw.map(|dw| b.map(|b| b * dw))
}

/// Returns the increments at the stages by process and stage; `dw` lists them process by process.
#[inline(always)]
#[must_use]
pub fn by_stage<const S: usize, const M: usize, const L: usize>(dw: &[f64; L]) -> [[f64; S]; M] {
    const { assert!(L == S * M, "an increment for each process and stage") }
    core::array::from_fn(|process| core::array::from_fn(|i| dw[process * S + i]))
}

/// Returns the unknowns in the limit of no noise and h → 0.
#[must_use]
pub fn start<const S: usize, const N: usize, const K: usize>(velocity: &[f64; N]) -> [f64; K] {
    let mut x = [0.0; K];
    for (at, x) in x.iter_mut().enumerate().take(S * N) {
        *x = velocity[at / S];
    }
    x
}

/// Visits the positions of the stages of a solved step with their weights.
#[inline]
pub fn nodes<const S: usize, const N: usize, const K: usize>(
    start: &[f64; N],
    h: f64,
    unknowns: &[f64; K],
    visit: &mut dyn FnMut(f64, &[f64; N]),
) {
    let tableau = const { &Tableau::<S>::VALUES };
    let displacements: [[f64; N]; S] = core::array::from_fn(|i| {
        core::array::from_fn(|n| h * tableau.b[i] * unknowns[jacobian::velocity::<S>(i, n)])
    });
    for i in 0..S {
        let mut q = at_stage(i, &displacements);
        for n in 0..N {
            q[n] += start[n];
        }
        visit(tableau.b[i], &q);
    }
}

/// Linearises a solved step. Returns the result of `then` for the linearised equations and results.
pub fn linearise<T, Sys, Q, const S: usize, const N: usize, const M: usize, const K: usize>(
    system: &Sys,
    state: &State<[f64; N]>,
    h: f64,
    noise: [[f64; S]; M],
    unknowns: &[f64; K],
    then: impl FnOnce(Linearisation<'_>) -> T,
) -> T
where
    Sys: System<Dims = Dims<N, M, Q>> + ByParameters<N, M>,
    Q: VectorCoordinates<N>,
{
    Step::<_, S, N, M>::new(system, state, h, noise).linearise(unknowns, then)
}
