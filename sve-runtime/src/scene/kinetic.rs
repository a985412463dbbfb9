//! Kinetic energies that are no sums of `½ m v²` of components: the velocity of a momentum is
//! solved for, site by site.
//!
//! The kinetic energy T(v) of a site is a sum of terms, and the momentum is p = ∂T/∂v. With a
//! friction ν of components over the time a before a drift, the velocity of the drift solves
//! p = ∂T/∂v + a ν v.

use super::errors::index_error;
use super::{IndexError, Row, Scene};
use crate::error::StepError;
use crate::solve::SolveError;

/// The form of the kinetic energy of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KineticForm {
    /// `½ m v²` of each component.
    Masses,
    /// The momenta of a site are affine in its velocities.
    Affine,
    /// The momenta of a site are functions of its velocities.
    General,
}

/// The derivatives of the kinetic energy of a site at a velocity.
#[derive(Clone, Copy, Debug)]
pub struct KineticJet<R: Row> {
    /// ∂T/∂v.
    pub dv: R,
    /// ∂²T/∂v².
    pub dvv: R::Matrix,
    /// 0, or NaN outside of the domain of T.
    pub(super) undefined: f64,
}

impl<R: Row> KineticJet<R> {
    /// Tells a number that is positive where T is defined.
    #[inline(always)]
    pub fn needs_positive(&mut self, number: f64) {
        if number <= 0.0 {
            self.undefined = f64::NAN;
        }
    }
}

/// The terms of the kinetic energy, as the loops visit them.
#[derive(Debug)]
pub struct KineticTerms {
    sites: usize,
    /// For each instance its site, its term, and its first column.
    instances: Vec<[usize; 3]>,
    columns: Vec<f64>,
}

impl KineticTerms {
    /// Adds an instance of a term.
    ///
    /// # Errors
    /// The index of the site, if it is out of range.
    pub fn term(
        &mut self,
        term: usize,
        site: i64,
        columns: &[f64],
        text: &'static str,
    ) -> Result<(), IndexError> {
        super::check(site, self.sites, text)?;
        let site = super::position(site);
        self.instances.push([site, term, self.columns.len()]);
        self.columns.extend_from_slice(columns);
        Ok(())
    }
}

/// The kinetic energies of all sites.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    /// The first instance of each site, and the number of all instances.
    starts: Vec<usize>,
    /// For each instance its term and its first column, in the order of the sites.
    instances: Vec<[usize; 2]>,
    columns: Vec<f64>,
    /// The friction of each component; empty without friction.
    frictions: Vec<f64>,
}

impl Sites {
    /// Returns the kinetic energies of `n` sites; nothing if they are those of masses.
    ///
    /// # Errors
    /// An index that is out of range.
    pub(super) fn new<S: Scene>(scene: &S, n: usize) -> Result<Option<Self>, IndexError> {
        if S::KINETIC == KineticForm::Masses {
            return Ok(None);
        }
        let mut terms = KineticTerms {
            sites: n,
            instances: Vec::new(),
            columns: Vec::new(),
        };
        scene.kinetic_terms(n, &mut terms)?;
        let KineticTerms {
            mut instances,
            columns,
            ..
        } = terms;
        instances.sort_by_key(|instance| instance[0]);
        let starts = (0..=n).map(|site| instances.partition_point(|instance| instance[0] < site));
        let mut frictions = vec![S::Row::ZERO; n];
        scene.frictions(n, &mut frictions)?;
        let mut frictions = S::Row::numbers(&frictions).to_vec();
        if frictions.iter().all(|&friction| friction == 0.0) {
            frictions.clear();
        }
        Ok(Some(Self {
            starts: starts.collect(),
            instances: instances.iter().map(|&[_, term, at]| [term, at]).collect(),
            columns,
            frictions,
        }))
    }

    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        self.starts.len() + 2 * self.instances.len() + self.columns.len() + self.frictions.len()
    }

    /// Returns the derivatives of the kinetic energy of a site.
    #[inline(always)]
    fn jet<S: Scene>(&self, scene: &S, site: usize, v: &S::Row) -> KineticJet<S::Row> {
        let mut jet = KineticJet {
            dv: S::Row::ZERO,
            dvv: S::Row::ZERO_MATRIX,
            undefined: 0.0,
        };
        for &[term, column] in &self.instances[self.starts[site]..self.starts[site + 1]] {
            scene.kinetic(term, &self.columns[column..], v, &mut jet);
        }
        jet
    }

    /// Returns the velocity of a momentum of a site, with the numbers `damping` added to the
    /// diagonal of ∂²T/∂v². It is NaN if the momentum or the kinetic energy is not finite.
    fn velocity<S: Scene>(
        &self,
        scene: &S,
        site: usize,
        [p, near]: [S::Row; 2],
        damping: S::Row,
    ) -> Result<S::Row, SolveError> {
        let is_affine = S::KINETIC == KineticForm::Affine;
        match p.velocity(&near, &damping, is_affine, |v| self.jet(scene, site, v)) {
            Err(SolveError::NonFinite) => Ok(S::Row::NAN),
            found => found,
        }
    }

    pub(super) fn has_friction(&self) -> bool {
        !self.frictions.is_empty()
    }

    /// Returns the friction of a component.
    pub(super) fn friction(&self, at: usize) -> f64 {
        self.frictions.get(at).copied().unwrap_or_default()
    }

    /// Writes the velocities of the momenta `p + impulses`, with friction over the time `damped`,
    /// in a step of the time and length `times`. They are connected with those in `v`: zeros, or
    /// those of other impulses.
    ///
    /// # Errors
    /// The error of a site for which no velocity has the momentum.
    pub(super) fn velocities<S: Scene>(
        &self,
        scene: &S,
        [q, p, impulses]: [&[S::Row]; 3],
        times: [f64; 2],
        damped: f64,
        v: &mut [S::Row],
    ) -> Result<(), StepError> {
        for (site, v) in v.iter_mut().enumerate() {
            let (mut p, mut damping) = (p[site], S::Row::ZERO);
            p.add(impulses[site]);
            if !self.frictions.is_empty() {
                let of_site = &self.frictions[site * S::Row::LENGTH..];
                damping.add_scaled(damped, of_site);
            }
            let found = self.velocity(scene, site, [p, *v], damping);
            *v = found.map_err(|error| site_error(error, site, times, q[site], p))?;
        }
        Ok(())
    }

    /// Replaces the momenta of a state by its velocities.
    ///
    /// # Errors
    /// The error of a site for which no velocity has the momentum.
    pub(super) fn to_velocities<S: Scene>(
        &self,
        scene: &S,
        t: f64,
        q: &[S::Row],
        p: &mut [S::Row],
    ) -> Result<(), StepError> {
        for (site, (q, p)) in q.iter().zip(p).enumerate() {
            let v = self.velocity(scene, site, [*p, S::Row::ZERO], S::Row::ZERO);
            *p = v.map_err(|error| site_error(error, site, [t, 0.0], *q, *p))?;
        }
        Ok(())
    }
}

/// Replaces velocities by momenta.
///
/// # Errors
/// An index that is out of range; a site with a velocity for which T is not defined.
pub(super) fn to_momenta<S: Scene>(
    scene: &S,
    t: f64,
    q: &[S::Row],
    v: &mut [S::Row],
) -> Result<(), StepError> {
    let n = v.len();
    let index = |error| index_error(error, t);
    let Some(sites) = Sites::new(scene, n).map_err(index)? else {
        let mut masses = vec![S::Row::ZERO; n];
        scene.masses(n, &mut masses).map_err(index)?;
        let masses = S::Row::numbers(&masses).iter();
        for (v, mass) in S::Row::numbers_mut(v).iter_mut().zip(masses) {
            *v *= mass;
        }
        return Ok(());
    };
    for (site, (q, v)) in q.iter().zip(v).enumerate() {
        let KineticJet { dv, undefined, .. } = sites.jet(scene, site, v);
        let numbers = S::Row::numbers(core::slice::from_ref(&dv));
        if undefined.is_nan() || !numbers.iter().all(|p| p.is_finite()) {
            let error = SolveError::NonFinite;
            return Err(site_error(error, site, [t, 0.0], *q, S::Row::ZERO));
        }
        *v = dv;
    }
    Ok(())
}

#[cold]
fn site_error<R: Row>(error: SolveError, site: usize, [t, h]: [f64; 2], q: R, p: R) -> StepError {
    let error = Box::new(R::step_error(error, [t, h], q, p));
    StepError::Site { site, error }
}
