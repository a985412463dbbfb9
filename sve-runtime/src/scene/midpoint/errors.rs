//! Errors of steps of the midpoint rule.

use super::super::Row;
use super::super::errors::{input_error, name};
use super::MidpointStep;
use crate::error::StepError;

impl<R: Row> MidpointStep<'_, R> {
    /// Returns the error of a spectrum that is not accepted, with its bounds at a component.
    #[cold]
    pub(super) fn stiff(&self, at: usize, bounds: [f64; 2]) -> StepError {
        let (h, length) = (self.kick.h, R::LENGTH);
        self.input_error().unwrap_or_else(|| StepError::Stiff {
            t: self.start,
            h,
            what: name("q", at, length),
            bounds,
        })
    }

    #[cold]
    pub(super) fn not_contracting(&self, sweeps: u32, change: f64) -> StepError {
        let is_finite = self.places().all(f64::is_finite);
        if !is_finite {
            return self.not_finite();
        }
        self.input_error().unwrap_or(StepError::NotContracting {
            t: self.start,
            h: self.kick.h,
            sweeps,
            change,
        })
    }

    /// Returns the error of an end that is not finite.
    #[cold]
    pub(super) fn not_finite(&self) -> StepError {
        self.input_error().unwrap_or_else(|| {
            let place = self.places().position(|x| !x.is_finite());
            let momentum = || self.work.other.iter().position(|x| !x.is_finite());
            let (array, at) = match place {
                Some(at) => ("q", at),
                None => ("p", momentum().unwrap_or_default()),
            };
            StepError::NonFiniteCoordinate {
                t: self.start,
                h: self.kick.h,
                what: name(array, at, R::LENGTH),
            }
        })
    }

    /// Returns the places at the end.
    fn places(&self) -> impl Iterator<Item = f64> {
        let q = R::numbers(self.q).iter();
        q.zip(self.work.displacements()).map(|(q, d)| q + d)
    }

    pub(super) fn input_error(&self) -> Option<StepError> {
        let [q, p] = [&*self.q, &*self.p].map(R::numbers);
        input_error::<R>([q, p], self.kick.dw, self.start)
    }
}
