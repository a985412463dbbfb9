//! A model with slices as arguments: the user's functions, and the generated derivatives that do
//! not depend on a rule.

use core::fmt::Debug;

use sve_runtime::__private::VectorCoordinates;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, ForceJet, LagrangianJet, NoiseJet, System};

use crate::oracle::Model;
use crate::random::Random;

/// A vector whose length is known at run time.
pub type Vector = Vec<f64>;

/// A matrix by rows.
pub type Matrix = Vec<Vec<f64>>;

/// A state whose number of coordinates is known at run time.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Time.
    pub t: f64,
    /// Configuration.
    pub q: Vector,
    /// Momentum.
    pub p: Vector,
}

impl Point {
    /// Returns the state (q, p) at t = 0.
    pub fn new(q: &[f64], p: &[f64]) -> Self {
        Self {
            t: 0.0,
            q: q.to_vec(),
            p: p.to_vec(),
        }
    }

    pub(crate) fn of<const N: usize>(state: &State<[f64; N]>) -> Self {
        Self {
            t: state.t,
            q: state.q.to_vec(),
            p: state.p.to_vec(),
        }
    }

    pub(crate) fn state<const N: usize>(&self) -> State<[f64; N]> {
        State::at(self.t, array(&self.q), array(&self.p))
    }

    /// Returns the entries of q, then the entries of p.
    pub fn entries(&self) -> impl Iterator<Item = &f64> {
        self.q.iter().chain(&self.p)
    }

    /// Returns the largest magnitude of an entry, at least 1.
    pub fn size(&self) -> f64 {
        self.entries().fold(1.0, |m: f64, x| m.max(x.abs()))
    }

    /// Returns the bits of time, configuration and momentum.
    pub fn bits(&self) -> Vec<u64> {
        let all = core::iter::once(&self.t).chain(self.entries());
        all.map(|x| x.to_bits()).collect()
    }
}

/// Returns a vector as an array whose length the type knows.
pub(crate) fn array<const N: usize>(vector: &[f64]) -> [f64; N] {
    vector.try_into().expect("the number of components")
}

fn rows<const N: usize>(matrix: &[[f64; N]; N]) -> Matrix {
    matrix.iter().map(|row| row.to_vec()).collect()
}

/// The derivatives of L in `LagrangianJet`, as vectors.
pub struct Lagrangian {
    /// L.
    pub value: f64,
    /// ∂L/∂q.
    pub dq: Vector,
    /// ∂L/∂v.
    pub dv: Vector,
    /// ∂²L/∂q².
    pub dqq: Matrix,
    /// ∂²L/∂q∂v.
    pub dqv: Matrix,
    /// ∂²L/∂v².
    pub dvv: Matrix,
    /// ∂²L/∂q∂t.
    pub dqt: Vector,
    /// ∂²L/∂v∂t.
    pub dvt: Vector,
}

/// Returns the generated derivatives of L.
pub(crate) fn lagrangian<S, Q, const N: usize, const M: usize>(
    system: &S,
    t: f64,
    q: &[f64],
    v: &[f64],
) -> Lagrangian
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let LagrangianJet {
        value,
        dq,
        dv,
        dqq,
        dqv,
        dvv,
        dqt,
        dvt,
    } = system.lagrangian_jet(t, &array(q), &array(v));
    Lagrangian {
        value,
        dq: dq.to_vec(),
        dv: dv.to_vec(),
        dqq: rows(&dqq),
        dqv: rows(&dqv),
        dvv: rows(&dvv),
        dqt: dqt.to_vec(),
        dvt: dvt.to_vec(),
    }
}

/// The derivatives of a noise Hamiltonian in `NoiseJet`, as vectors.
pub struct NoiseDerivatives {
    /// ∂G/∂q.
    pub dq: Vector,
    /// ∂G/∂p.
    pub dp: Vector,
    /// ∂²G/∂q².
    pub dqq: Matrix,
    /// ∂²G/∂q∂p.
    pub dqp: Matrix,
    /// ∂²G/∂p².
    pub dpp: Matrix,
}

/// The force with its derivatives in `ForceJet`, as vectors.
pub struct Force {
    /// F.
    pub value: Vector,
    /// ∂F/∂q.
    pub dq: Matrix,
    /// ∂F/∂v.
    pub dv: Matrix,
    /// ∂F/∂t.
    pub dt: Vector,
}

impl Force {
    fn of<const N: usize>(ForceJet { value, dq, dv, dt }: &ForceJet<N>) -> Self {
        Self {
            value: value.to_vec(),
            dq: rows(dq),
            dv: rows(dv),
            dt: dt.to_vec(),
        }
    }
}

/// A model: its user's functions, and the functions that were derived from them without a rule.
pub trait Functions: Debug {
    /// Returns L as the user wrote it.
    fn l(&self, t: f64, q: &[f64], v: &[f64]) -> f64;
    /// Returns the noise Hamiltonians, −γ and H₁, in source order.
    fn g(&self, t: f64, q: &[f64], p: &[f64]) -> Vector;
    /// Returns the force; zero for a system without a force.
    fn f(&self, t: f64, q: &[f64], v: &[f64]) -> Vector;
    /// Returns the force of each noise; zero for Hamiltonians.
    fn w(&self, t: f64, q: &[f64], v: &[f64]) -> Vec<Vector>;
    /// Returns whether the block has a force or a noise that is a force.
    fn is_forced(&self) -> bool;
    /// Returns a random point in whose neighbourhood everything is regular.
    fn point(&self, random: &mut Random) -> Point;
    /// Returns the velocity of a momentum.
    fn velocity(&self, t: f64, q: &[f64], p: &[f64]) -> Vector;
    /// Returns the generated derivatives of L.
    fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> Lagrangian;
    /// Returns the generated derivatives of the noise Hamiltonians.
    fn noises(&self, t: f64, q: &[f64], p: &[f64]) -> Vec<NoiseDerivatives>;
    /// Returns the generated force and its derivatives.
    fn force(&self, t: f64, q: &[f64], v: &[f64]) -> Force;
    /// Returns the generated force of each noise and its derivatives.
    fn noise_forces(&self, t: f64, q: &[f64], v: &[f64]) -> Vec<Force>;
}

/// A model with the numbers of its coordinates and noises.
pub(crate) struct TypedModel<'a, S, const N: usize, const M: usize>(pub(crate) &'a S);

impl<S, const N: usize, const M: usize> Debug for TypedModel<'_, S, N, M>
where
    S: Model<N, M>,
{
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.fmt(formatter)
    }
}

impl<S, const N: usize, const M: usize> Functions for TypedModel<'_, S, N, M>
where
    S: Model<N, M>,
{
    fn l(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        self.0.l(t, array(q), array(v))
    }

    fn g(&self, t: f64, q: &[f64], p: &[f64]) -> Vector {
        self.0.g(t, array(q), array(p)).to_vec()
    }

    fn f(&self, t: f64, q: &[f64], v: &[f64]) -> Vector {
        self.0.f(t, array(q), array(v)).to_vec()
    }

    fn w(&self, t: f64, q: &[f64], v: &[f64]) -> Vec<Vector> {
        let forces = self.0.w(t, array(q), array(v));
        forces.iter().map(|force| force.to_vec()).collect()
    }

    fn is_forced(&self) -> bool {
        S::FORCED || S::NOISE_FORCED
    }

    fn point(&self, random: &mut Random) -> Point {
        Point::of(&S::point(random))
    }

    fn velocity(&self, t: f64, q: &[f64], p: &[f64]) -> Vector {
        let velocity = self.0.velocity(&State::at(t, array(q), array(p)));
        velocity.expect("a regular point").to_vec()
    }

    fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> Lagrangian {
        lagrangian::<S, _, N, M>(self.0, t, q, v)
    }

    fn noises(&self, t: f64, q: &[f64], p: &[f64]) -> Vec<NoiseDerivatives> {
        let jets = self.0.noise_jets(t, &array(q), &array(p));
        let all = jets.iter().map(|jet| {
            let NoiseJet {
                dq,
                dp,
                dqq,
                dqp,
                dpp,
            } = jet;
            NoiseDerivatives {
                dq: dq.to_vec(),
                dp: dp.to_vec(),
                dqq: rows(dqq),
                dqp: rows(dqp),
                dpp: rows(dpp),
            }
        });
        all.collect()
    }

    fn force(&self, t: f64, q: &[f64], v: &[f64]) -> Force {
        Force::of(&self.0.force_jet(t, &array(q), &array(v)))
    }

    fn noise_forces(&self, t: f64, q: &[f64], v: &[f64]) -> Vec<Force> {
        let forces = self.0.noise_force_jets(t, &array(q), &array(v));
        forces.iter().map(Force::of).collect()
    }
}
