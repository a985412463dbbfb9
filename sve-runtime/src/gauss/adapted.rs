//! Steps whose size is adapted: attempts that are solved to an accuracy, with the decay of their
//! Legendre series.
//!
//! Input: a state, a step size and an accuracy. Output: the increments with the decay of the
//! series, from which the size of the next step follows; `None` if the fixed-point iteration of the
//! stages does not contract or a number is not finite. The iteration begins at the series of the
//! last step that was accepted, at the stages of the step that is tried. It ends early, so the
//! step is not symplectic.

use super::convergence::Course;
use super::fixed_point::{SecondOrder, SecondOrderIteration};
use super::jacobian::velocity;
use super::legendre::{Ahead, Coefficients, Series, integral};
use super::partitioned::{Partitioned, PartitionedIteration};
use super::scaled::Scaled;
use super::stages::{Rows, at_stages, larger};
use super::step::Step;
use super::tableau::Tableau;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::mechanics::time_scale::is_time_scale;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::system::Dims;
use crate::system::start::StartOfStep;

/// A system whose steps by the Gauss rule with `S` stages are solved by fixed-point iteration.
#[diagnostic::on_unimplemented(
    message = "`.tolerance(tol)` has no iteration for the steps of `{Self}` by `Gauss::<{S}>`",
    label = "its steps have no adapted sizes",
    note = "it takes `Gauss::<4>` to `Gauss::<8>`, in the attribute `gauss(4)` to `gauss(8)`, and a Lagrangian whose ∂L/∂v is affine in v"
)]
pub trait AdaptedSteps<const S: usize, const N: usize>: StartOfStep {
    /// Values that depend on parameters alone.
    type Coefficients: Copy + Send + Sync + 'static;
    /// Computes the values that depend on parameters alone.
    fn coefficients(&self) -> Self::Coefficients;
    /// Tries a step of size `h`. `level` is the relative size of changes of the stages that are
    /// negligible; `before` is the series of the step before.
    fn attempt(
        &self,
        coefficients: &Self::Coefficients,
        state: &State<[f64; N]>,
        h: f64,
        level: f64,
        before: Option<&StageSeries<S, N>>,
    ) -> Option<Attempt<S, N>>;
}

/// The Legendre series of displacements and impulses of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageSeries<const S: usize, const N: usize> {
    /// The size of the step.
    pub(crate) h: f64,
    /// The coefficients of displacements and impulses, a row of degrees for each coordinate.
    pub(crate) rows: [[[f64; S]; N]; 2],
}

impl<const S: usize, const N: usize> StageSeries<S, N> {
    /// Returns displacements and impulses from the start of the step to a fraction of it. Their
    /// errors are of order `h^{S+1}`.
    pub(crate) fn until(&self, fraction: f64) -> [[f64; N]; 2] {
        self.rows
            .map(|rows| rows.map(|row| integral(&row, fraction)))
    }
}

/// A step that was tried.
#[derive(Clone, Copy, Debug)]
pub struct Attempt<const S: usize, const N: usize> {
    /// `q₁ − q₀` and `p₁ − p₀`.
    pub(crate) increments: [[f64; N]; 2],
    /// The displacements at the stages.
    displacements: Rows<S, N>,
    /// The series of the step.
    pub(crate) series: StageSeries<S, N>,
    /// The logarithm to base 2 of the ratio of successive terms of the series.
    pub(crate) decay: f64,
}

impl<const S: usize, const N: usize> Attempt<S, N> {
    /// Returns the attempt from a position with these increments, if they are finite.
    fn of(
        q: &[f64; N],
        increments: [[f64; N]; 2],
        displacements: Rows<S, N>,
        series: StageSeries<S, N>,
        decay: f64,
    ) -> Option<Self> {
        let numbers = increments.as_flattened();
        let is_finite = numbers.iter().all(|number| number.is_finite());
        let decay = if ends_in_rounding(q, &series.rows[0]) {
            f64::NEG_INFINITY
        } else {
            decay
        };
        is_finite.then_some(Self {
            increments,
            displacements,
            series,
            decay,
        })
    }

    /// Returns the Legendre series of the time that passes within the step from `q`, with the given
    /// rate at a position; `None` if a rate is not positive and finite.
    pub(crate) fn times(&self, q: &[f64; N], rate: impl Fn(&[f64; N]) -> f64) -> Option<[f64; S]> {
        let tableau = const { &Tableau::<S>::VALUES };
        let moves = dispatch(AtStages {
            displacements: &self.displacements,
        });
        let mut times = [0.0; S];
        for i in 0..S {
            let rate = rate(&core::array::from_fn(|n| q[n] + moves[n][i]));
            if !is_time_scale(rate) {
                return None;
            }
            times[i] = self.series.h * tableau.b[i] * rate;
        }
        let stages = &[[times]];
        Some(dispatch(Coefficients { stages }).rows[0][0])
    }
}

/// Computes the positions of the stages relative to the start.
struct AtStages<'a, const S: usize, const N: usize> {
    displacements: &'a Rows<S, N>,
}

impl<const S: usize, const N: usize> Kernel for AtStages<'_, S, N> {
    type Output = Rows<S, N>;

    #[inline(always)]
    fn run(self) -> Rows<S, N> {
        at_stages(const { &Tableau::<S>::VALUES }, self.displacements)
    }
}

/// Returns whether the terms of the two highest degrees displace no coordinate by more than its
/// rounding error. The forces there are rounding errors too, as near an unstable equilibrium, and
/// their series does not decay, however short the step is.
fn ends_in_rounding<const S: usize, const N: usize>(
    q: &[f64; N],
    displacements: &Rows<S, N>,
) -> bool {
    let factor = (2 * S - 1) as f64;
    let mut coordinates = q.iter().zip(displacements);
    coordinates.all(|(q, row)| {
        let term = factor * larger(row[S - 1].abs(), row[S - 2].abs());
        term <= f64::EPSILON * q.abs()
    })
}

/// Tries a step of a system of second order. The impulses alone determine the decay, since the
/// series of the displacements follow from them.
#[inline]
pub fn second_order_attempt<
    Sys,
    Q,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
>(
    system: &Sys,
    inverse_mass: &[[f64; N]; N],
    state: &State<[f64; N]>,
    h: f64,
    level: f64,
    before: Option<&StageSeries<S, N>>,
) -> Option<Attempt<S, N>>
where
    Sys: SecondOrder<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let step = Step::<_, S, N, M>::new(system, state, h, [[0.0; S]; M]);
    let scaled = Scaled::product(h);
    let impulses = before.map(|StageSeries { h: h0, rows }| {
        dispatch(Ahead {
            rows: &[rows[1]],
            ratio: h / h0,
        })
    });
    let solved = dispatch(SecondOrderIteration::<_, S, N, M, K> {
        step: &step,
        inverse_mass,
        scaled: &scaled,
        guess: impulses.as_ref().map(|[f]| (&scaled.second_order, f)),
        course: Course::down_to(level),
    });
    let ((dq, dp, x), impulses) = solved?;
    let mut displacements = [[0.0; S]; N];
    for n in 0..N {
        for i in 0..S {
            displacements[n][i] = step.weights[i] * x[velocity::<S>(i, n)];
        }
    }
    let series = dispatch(Coefficients {
        stages: &[impulses],
    });
    let decay = series.decay();
    let moves = dispatch(Coefficients {
        stages: &[displacements],
    });
    let rows = [moves.rows[0], series.rows[0]];
    let series = StageSeries { h, rows };
    Attempt::of(&state.q, [dq, dp], displacements, series, decay)
}

/// Tries a step of a system with ∂L/∂v affine in v.
#[inline]
pub fn partitioned_attempt<Sys, Q, const S: usize, const N: usize, const M: usize, const K: usize>(
    system: &Sys,
    state: &State<[f64; N]>,
    h: f64,
    level: f64,
    before: Option<&StageSeries<S, N>>,
) -> Option<Attempt<S, N>>
where
    Sys: Partitioned<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let step = Step::<_, S, N, M>::new(system, state, h, [[0.0; S]; M]);
    let stages = before.map(|StageSeries { h: h0, rows }| {
        let ratio = h / h0;
        dispatch(Ahead { rows, ratio })
    });
    let solved = dispatch(PartitionedIteration::<_, S, N, M, K> {
        step: &step,
        guess: stages.as_ref().map(|stages| (&step.tableau.ratio, stages)),
        course: Course::down_to(level),
    });
    let ((dq, dp, _), stages) = solved?;
    let series: Series<S, N, 2> = dispatch(Coefficients { stages: &stages });
    let (decay, rows) = (series.decay(), series.rows);
    let series = StageSeries { h, rows };
    Attempt::of(&state.q, [dq, dp], stages[0], series, decay)
}
