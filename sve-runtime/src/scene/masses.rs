//! Masses and friction of all components of all sites.

use super::errors::{index_error, name};
use super::{IndexError, KineticForm, Row, Scene};
use crate::error::StepError;

/// Inverse masses of all components of all sites.
#[derive(Clone, Debug)]
pub(super) enum InverseMasses {
    /// All have this one.
    Uniform(f64),
    /// One for each component.
    Each(Vec<f64>),
}

impl InverseMasses {
    /// Returns the inverse of each mass of a scene of `n` sites; nothing for another kinetic
    /// energy.
    ///
    /// # Errors
    /// An index that is out of range; a mass without an inverse.
    pub(super) fn new<S: Scene>(scene: &S, n: usize, t: f64) -> Result<Self, StepError> {
        if S::KINETIC != KineticForm::Masses {
            return Ok(Self::Each(Vec::new()));
        }
        let mut masses = vec![S::Row::ZERO; n];
        let added = scene.masses(n, &mut masses);
        added.map_err(|error| index_error(error, t))?;
        let masses = S::Row::numbers(&masses);
        if let Some(at) = (masses.iter()).position(|&mass| mass == 0.0 || !mass.is_finite()) {
            return Err(StepError::Mass {
                t,
                what: name("v", at, S::Row::LENGTH),
                mass: masses[at],
            });
        }
        Ok(match masses {
            [first, others @ ..] if others.iter().all(|mass| mass == first) => {
                Self::Uniform(1.0 / first)
            }
            _ => Self::Each(masses.iter().map(|mass| 1.0 / mass).collect()),
        })
    }

    /// Returns the friction of each component divided by its mass; nothing without friction or
    /// masses.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn rates<S: Scene>(&self, scene: &S, n: usize) -> Result<Vec<f64>, IndexError> {
        let mut frictions = vec![S::Row::ZERO; n];
        scene.frictions(n, &mut frictions)?;
        let frictions = S::Row::numbers(&frictions);
        let has_masses = S::KINETIC == KineticForm::Masses;
        if !has_masses || frictions.iter().all(|&friction| friction == 0.0) {
            return Ok(Vec::new());
        }
        let rates = frictions.iter().enumerate();
        Ok(rates.map(|(at, friction)| friction * self.of(at)).collect())
    }

    /// Returns the magnitude of the largest mass.
    pub(super) fn largest(&self) -> f64 {
        match self {
            Self::Uniform(inverse) => inverse.abs().recip(),
            Self::Each(all) => all
                .iter()
                .map(|inverse| inverse.abs().recip())
                .fold(0.0, f64::max),
        }
    }

    /// Returns the inverse mass of a component.
    pub(super) fn of(&self, component: usize) -> f64 {
        match self {
            Self::Uniform(inverse) => *inverse,
            Self::Each(inverse) => inverse[component],
        }
    }
}
