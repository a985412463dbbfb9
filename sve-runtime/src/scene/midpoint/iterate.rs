//! The iteration of a step of the midpoint rule.

use core::marker::PhantomData;
use core::mem::swap;

use super::super::errors::index_error;
use super::super::gather::Gather;
use super::super::passes::{Factors, Largest};
use super::super::relax::{NodeVelocities, Relax};
use super::super::work::Work;
use super::super::{Impulses, Row, Scene, reads_motion};
use super::{Iteration, MOST, MidpointStep};
use crate::error::StepError;

/// Updates without a smaller one after which the updates are rounding errors.
const STALLED: f64 = 3.0;

/// Largest update, relative to the largest place or displacement, that can be a rounding error.
const ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Such an update that certainly is one if it is not smaller than those before it.
const SMALLEST: f64 = 4.0 * f64::EPSILON;

/// The result of an iteration.
pub(super) struct Iterated {
    /// False if the updates stopped to become smaller, and are no rounding errors.
    pub(super) is_solved: bool,
    pub(super) sweeps: u32,
    /// The last update.
    pub(super) change: f64,
    /// The largest update of the displacements at the end. A larger one is a jump of the impulse.
    pub(super) last: f64,
}

/// The largest updates of a sweep.
pub(super) struct Changes {
    /// Of the nodes.
    pub(super) nodes: f64,
    /// Of the motions h v/2, in a scene with forces of velocities or H₁.
    pub(super) motions: Option<f64>,
}

impl<R: Row> MidpointStep<'_, R> {
    /// Solves the equations for the nodes in `work`. No displacement there is larger than `size`,
    /// and no place than `places`.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn iterate<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        [mut size, places]: [f64; 2],
        iteration: Iteration,
    ) -> Result<Iterated, StepError>
    where
        S: Scene<Row = R>,
    {
        let Iteration {
            mut updates,
            weight,
        } = iteration;
        let (mut smallest, mut stalled, mut sweeps) = (f64::INFINITY, 0u32, 0u32);
        loop {
            let Changes { nodes, motions } = self.sweep(scene, factors, updates.weights())?;
            let change = match motions {
                Some(motions) if S::HAS_H1 => nodes.max(motions / weight),
                Some(motions) => motions,
                None => nodes,
            };
            sweeps += 1;
            size += 2.0 * change;
            let farthest = places.max(size);
            let last = 4.0 * updates.error(change) + ROUNDING * farthest;
            let end = |is_solved| Iterated {
                is_solved,
                sweeps,
                change,
                last,
            };
            // velocities need the digits of the displacements, which the places lack
            let digits = if reads_motion::<S>() { size } else { farthest };
            if updates.is_solved(change, size, digits) {
                return Ok(end(true));
            }
            if f64::from(sweeps) > 2.0 * MOST {
                return Ok(end(false));
            }
            if change < smallest {
                (smallest, stalled) = (change, 0);
                continue;
            }
            if change <= SMALLEST * farthest {
                return Ok(end(true));
            }
            stalled += 1;
            // the updates of Chebyshev's iteration become smaller on average
            if f64::from(stalled) < STALLED.max(updates.updates(0.1)) {
                continue;
            }
            if !updates.make_plain() {
                return Ok(end(change <= ROUNDING * farthest));
            }
            (smallest, stalled) = (f64::INFINITY, 0);
        }
    }

    /// Makes updates with these weights: of the velocities, and of the nodes with the impulses or,
    /// in a scene with H₁, with the velocities.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn sweep<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        weights: [f64; 2],
    ) -> Result<Changes, StepError>
    where
        S: Scene<Row = R>,
    {
        let Work {
            centres,
            nodes,
            other,
            velocities: [v, _],
            of_h1,
            ..
        } = &mut *self.work;
        let (q, p, h) = (R::numbers(self.q), R::numbers(self.p), self.kick.h);
        let index = |error| index_error(error, self.start);
        let swept = factors.pass(Gather {
            scene,
            segments: self.segments,
            kick: self.kick,
            buffers: &mut *self.buffers,
            sink: Relax {
                nodes: R::rows(nodes),
                other,
                centres,
                velocities: reads_motion::<S>().then_some(NodeVelocities {
                    v,
                    p,
                    h,
                    largest: Largest::default(),
                }),
                momenta: R::rows(&of_h1.momenta),
                weights,
                largest: Largest::default(),
            },
            what: PhantomData::<Impulses>,
        });
        let swept = swept.map_err(index)?;
        let motions = swept
            .velocities
            .map(|of| 0.5 * h.abs() * of.largest.value());
        let mut largest = swept.largest;
        if S::HAS_H1 {
            let kick = self.buffers.with_totals::<S, Impulses>(self.kick);
            let moved = of_h1.follow(scene, kick, self.masses, [q, v, nodes], other);
            largest = moved.map_err(index)?;
        }
        swap(nodes, other);
        Ok(Changes {
            nodes: largest.value(),
            motions,
        })
    }
}
