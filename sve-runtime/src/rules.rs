//! The discretisation rules: one unit type each, the name by which an [`Integrator`](crate::Integrator) is asked for it.
//!
//! What a rule does is defined in the macro, as a discrete action.

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
    /// The second-order Taylor variational integrator of Schmitt, Shingel and Leok: deterministic systems only, order 2.
    Taylor2
}

/// A rule whose step was derived without looking for its structure: Newton's method in all unknowns. It is what derived steps
/// are compared with, in tests and benchmarks of this project; the attribute gives it where it says `structure = both`.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Whole<R>(pub R);
