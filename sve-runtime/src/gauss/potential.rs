//! The term of the option `weak2` in the action of a Gauss rule, `− ½ κ h |h| Σ b_i Σ_a K_a` at the
//! stages.
//!
//! The term has the form of one more noise, with the Hamiltonian `½ Σ_a K_a` and the increment
//! `κ h |h| b_i` at stage i. So a step with the term is a step of a system with this noise after
//! its own noises, and its equations, solvers and derivatives are the usual ones.

use super::bounds::{NodeBounds, Radii, StageBounds, Uniqueness};
use super::linearise::{ByParameters, ParameterJet};
use super::tableau::Tableau;
use super::{Masses, Motion, Partitioned, SecondOrder, StageLanes};
use crate::phase::configuration::VectorCoordinates;
use crate::system::CoordinateRole;
use crate::system::{Dims, ForceJet, LagrangianJet, NoiseJet, System};

/// A system with a potential. `E` is the number of its noises including the potential, which is the
/// last noise.
pub trait WithPotential<const N: usize, const E: usize>: System {
    /// Returns the jets of every noise Hamiltonian and of `½ Σ_a K_a`, with first and second
    /// derivatives.
    fn noise_jets(&self, t: f64, q: &[f64; N], p: &[f64; N]) -> [NoiseJet<N>; E];
    /// True if a noise has a force.
    const NOISE_FORCED: bool = false;
    /// Returns the force of every noise, with its first derivatives.
    fn noise_force_jets(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [ForceJet<N>; E] {
        let _ = (t, q, v);
        [ForceJet::NONE; E]
    }
}

/// A system whose last noise is its potential.
#[derive(Clone, Copy, Debug)]
pub struct Corrected<'a, Sys, const E: usize>(pub &'a Sys);

/// Returns the increments at the stages together with the increments of the potential, for `½ κ`.
/// The Hamiltonian is `½ Σ_a K_a`, so its increments have the factor κ.
#[inline(always)]
#[must_use]
pub fn with_potential<const S: usize, const M: usize, const E: usize>(
    noise: [[f64; S]; M],
    h: f64,
    half_factor: f64,
) -> [[f64; S]; E] {
    const { assert!(E == M + 1, "the potential is one more noise") }
    let b = const { &Tableau::<S>::VALUES.b };
    let factor = 2.0 * half_factor * h * h.abs();
    core::array::from_fn(|process| {
        let given = noise.get(process);
        given.copied().unwrap_or_else(|| b.map(|b| factor * b))
    })
}

#[diagnostic::do_not_recommend]
impl<Sys, Q, const N: usize, const M: usize, const E: usize> System for Corrected<'_, Sys, E>
where
    Sys: System<Dims = Dims<N, M, Q>> + WithPotential<N, E>,
    Q: VectorCoordinates<N>,
{
    type Dims = Dims<N, E, Q>;
    type Itself = Self;
    type EulerNumbers = ();
    const AFFINE_MOMENTUM: bool = Sys::AFFINE_MOMENTUM;
    const ROLES: &'static [CoordinateRole] = Sys::ROLES;
    const FORCED: bool = Sys::FORCED;
    const NOISE_FORCED: bool = <Sys as WithPotential<N, E>>::NOISE_FORCED;
    const PARAMETERS: &'static [&'static str] = Sys::PARAMETERS;
    const FORMULAS: u64 = Sys::FORMULAS;

    fn itself(&self) -> &Self {
        self
    }

    fn parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.0.parameters(visit);
    }

    #[inline]
    fn lagrangian_jet(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> LagrangianJet<N> {
        self.0.lagrangian_jet(t, q, v)
    }

    #[inline]
    fn noise_jets(&self, t: f64, q: &[f64; N], p: &[f64; N]) -> [NoiseJet<N>; E] {
        WithPotential::noise_jets(self.0, t, q, p)
    }

    #[inline]
    fn force_jet(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> ForceJet<N> {
        self.0.force_jet(t, q, v)
    }

    #[inline]
    fn noise_force_jets(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [ForceJet<N>; E] {
        WithPotential::noise_force_jets(self.0, t, q, v)
    }
}

impl<Sys, const N: usize, const E: usize> StageBounds<N, E> for Corrected<'_, Sys, E>
where
    Sys: StageBounds<N, E>,
    Self: System,
{
    const UNIQUENESS: Uniqueness = Sys::UNIQUENESS;

    #[inline]
    fn bounds(&self, time: f64, centre: [&[f64; N]; 3], radii: &Radii<N>) -> NodeBounds<N, E> {
        self.0.bounds(time, centre, radii)
    }
}

impl<Sys, const N: usize, const E: usize> SecondOrder<N, E> for Corrected<'_, Sys, E>
where
    Sys: SecondOrder<N, E>,
    Self: System,
{
    const HAS_DIAGONAL_MASS: bool = Sys::HAS_DIAGONAL_MASS;

    #[inline(always)]
    fn impulses<const S: usize>(
        &self,
        stages: &StageLanes<'_, S, N, E>,
        impulses: &mut [[f64; S]; N],
    ) {
        self.0.impulses(stages, impulses);
    }
}

impl<Sys, const N: usize, const E: usize> Partitioned<N, E> for Corrected<'_, Sys, E>
where
    Sys: Partitioned<N, E>,
    Self: System,
{
    #[inline(always)]
    fn impulses<const S: usize>(
        &self,
        stages: &StageLanes<'_, S, N, E>,
        kicks: &[[f64; S]; N],
        impulses: &mut [[f64; S]; N],
        masses: &mut Masses<S, N>,
    ) {
        self.0.impulses(stages, kicks, impulses, masses);
    }

    #[inline(always)]
    fn displacements<const S: usize>(
        &self,
        stages: &StageLanes<'_, S, N, E>,
        kicks: &[[f64; S]; N],
        masses: &Masses<S, N>,
        motion: &mut Motion<S, N>,
    ) {
        self.0.displacements(stages, kicks, masses, motion);
    }
}

impl<Sys, const N: usize, const E: usize> ByParameters<N, E> for Corrected<'_, Sys, E>
where
    Sys: ByParameters<N, E>,
    Self: System,
{
    fn parameter_jets(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        p: &[f64; N],
        visit: &mut dyn FnMut(ParameterJet<N, E>),
    ) {
        self.0.parameter_jets(t, q, v, p, visit);
    }
}
