//! Steps of the midpoint rule with noises H₁.

use super::super::chebyshev::Chebyshev;
use super::super::errors::index_error;
use super::super::passes::{Factors, Largest};
use super::super::shifts::Contraction;
use super::super::work::Work;
use super::super::{Contributions, Row, Scene, Slopes};
use super::{Iteration, MOST, MidpointStep};
use crate::error::StepError;

/// The ratio of errors for which a step size is told. Bounds grow at least with √h.
const WANTED: f64 = 0.5;

impl<R: Row> MidpointStep<'_, R> {
    /// Makes a sweep from displacements without impulses, of which none is larger than `size`, and
    /// puts the boxes around its result. Returns the largest displacement.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn first_sweep<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        size: f64,
    ) -> Result<f64, StepError>
    where
        S: Scene<Row = R>,
    {
        let h = self.kick.h;
        let work = &mut *self.work;
        work.of_h1.set_momenta(&work.velocities[0], self.masses);
        let changes = self.sweep(scene, factors, [1.0, 0.0])?;
        let Work {
            around,
            velocities: [v, _],
            of_h1,
            ..
        } = &mut *self.work;
        of_h1.set_boxes(v, 2.0 * changes.motions.unwrap_or_default());
        let displacements = v.iter().zip(&of_h1.displacements);
        around.extend(displacements.map(|(v, shift)| h * v + shift));
        let mut largest = Largest::default();
        for d in &*around {
            largest.add(*d);
        }
        Ok(size.max(largest.value()))
    }

    /// Returns the iteration, from the boxes that are written and the bound of |f/4| Σ |∂I/∂q| in
    /// them.
    ///
    /// # Errors
    /// The bound of the ratio of errors is not below 1, or the iteration would take many sweeps.
    pub(super) fn contraction<S>(
        &mut self,
        scene: &S,
        factors: &Factors,
        of_impulses: f64,
    ) -> Result<Iteration, StepError>
    where
        S: Scene<Row = R> + Contributions<Slopes>,
    {
        let work = &mut *self.work;
        let kick = match &work.of_bounds {
            Some(buffers) => buffers.with_totals::<S, Slopes>(self.kick),
            None => self.kick,
        };
        let boxes = [&work.boxes, &work.velocities[1]];
        let boxes = boxes.map(|boxes| <S as Contributions<Slopes>>::Numbers::rows(boxes));
        let found = work
            .of_h1
            .contraction(scene, kick, factors, self.masses, boxes, of_impulses);
        let found = found.map_err(|error| index_error(error, self.start))?;
        let Contraction { ratio, weight } = found.map_err(|at| self.stiff(at, [f64::NAN; 2]))?;
        if ratio < 1.0 {
            let updates = Chebyshev::new([1.0 - ratio, 1.0 + ratio], false);
            if updates.updates(f64::EPSILON) <= MOST {
                return Ok(Iteration { updates, weight });
            }
        }
        let h = self.kick.h;
        Err(self.input_error().unwrap_or(StepError::Contraction {
            t: self.start,
            h,
            ratio,
            wanted: h.abs() * (WANTED / ratio).powi(2),
        }))
    }
}
