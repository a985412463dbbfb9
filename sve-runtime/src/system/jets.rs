//! Values of L, of the noise Hamiltonians and of the forces at a point, with their derivatives, as
//! generated code returns them.

/// `L(t, q, v)` with its first and second derivatives; `dqv[i][j] = ∂²L/∂qᵢ∂vⱼ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagrangianJet<const N: usize> {
    /// `L`.
    pub value: f64,
    /// `∂L/∂q`.
    pub dq: [f64; N],
    /// `∂L/∂v`, the momentum.
    pub dv: [f64; N],
    /// `∂²L/∂q∂q`.
    pub dqq: [[f64; N]; N],
    /// `∂²L/∂q∂v`, rows by `q`.
    pub dqv: [[f64; N]; N],
    /// `∂²L/∂v∂v`, the mass matrix.
    pub dvv: [[f64; N]; N],
    /// `∂²L/∂q∂t`.
    pub dqt: [f64; N],
    /// `∂²L/∂v∂t`.
    pub dvt: [f64; N],
}

/// A noise Hamiltonian `G(t, q, p)` with its first and second derivatives;
/// `dqp[i][j] = ∂²G/∂qᵢ∂pⱼ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseJet<const N: usize> {
    /// `∂G/∂q`.
    pub dq: [f64; N],
    /// `∂G/∂p`.
    pub dp: [f64; N],
    /// `∂²G/∂q∂q`.
    pub dqq: [[f64; N]; N],
    /// `∂²G/∂q∂p`, rows by `q`.
    pub dqp: [[f64; N]; N],
    /// `∂²G/∂p∂p`.
    pub dpp: [[f64; N]; N],
}

/// A holonomic constraint `φ(t, q) = 0` with its first derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintJet<const N: usize> {
    /// `φ`, zero where the constraint holds.
    pub value: f64,
    /// The sum of the magnitudes of the terms of `φ`, to which rounding errors of `φ` are relative.
    pub magnitude: f64,
    /// `∂φ/∂t`.
    pub dt: f64,
    /// `∂φ/∂q`.
    pub dq: [f64; N],
}

/// A force `F(t, q, v)` with its first derivatives; `dv[i][j] = ∂Fᵢ/∂vⱼ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceJet<const N: usize> {
    /// `F`.
    pub value: [f64; N],
    /// `∂F/∂q`, rows by component of F.
    pub dq: [[f64; N]; N],
    /// `∂F/∂v`, rows by component of F.
    pub dv: [[f64; N]; N],
    /// `∂F/∂t`.
    pub dt: [f64; N],
}

impl<const N: usize> ForceJet<N> {
    /// No force.
    pub const NONE: Self = Self {
        value: [0.0; N],
        dq: [[0.0; N]; N],
        dv: [[0.0; N]; N],
        dt: [0.0; N],
    };
}

/// The form in which the velocity of a coordinate occurs in the Lagrangian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoordinateRole {
    /// The momentum determines the velocity.
    Massive,
    /// The velocity occurs linearly: the momentum is a function of the configuration, p = α(q).
    Massless,
    /// The velocity does not occur: the coordinate follows from the others by 0 = ∂L/∂q.
    Algebraic,
}
