//! The discretisation rules: a unit type for each, which names the rule of an [`Integrator`](crate::Integrator).
//!
//! The macro defines a rule by its discrete action (`docs/mathematics.md`, section 2).

macro_rules! rules {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name;
    )*};
}

rules! {
    /// `S_d = h L(t₀, q₀, v) + …`: node at the start of the step. Deterministic order 1.
    InitialPoint
    /// `S_d = h L(t₁, q₁, v) + …`: node at the end of the step. Deterministic order 1.
    Endpoint
    /// `S_d = h L(t₀ + h/2, (q₀+q₁)/2, v) + …`: node in the middle. Deterministic order 2, self-adjoint.
    Midpoint
    /// `S_d = h (L(t₀, q₀, v) + L(t₁, q₁, v))/2 + …`: the rule of Störmer and Verlet, nodes at both ends, self-adjoint. Deterministic order 2. Explicit where L has
    /// constant masses and is separable, and noise is in q alone.
    StormerVerlet
    /// The second-order Taylor variational integrator of Schmitt, Shingel and Leok: deterministic systems only, order 2.
    Taylor2
}

/// The Gauss–Galerkin rule with `S` stages, from 2 to 8: `S_d = Σ h b_i L(t₀ + c_i h, Q_i, V_i) + …` with nodes and weights of Gauss quadrature, self-adjoint.
/// Deterministic order `2 S`. In the attribute it is `gauss(4)`, as the rule of an integrator `Gauss::<4>`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gauss<const S: usize>;

/// A rule whose step is derived without analysing its structure: Newton's method in all unknowns. Tests and benchmarks
/// compare derived steps with it; the attribute derives it with `structure = both`.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unstructured<R>(pub R);
