//! Reasons why the equations of a step were not solved.

/// A row of a singular mass matrix for which elimination finds no pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SingularRow {
    /// Number of the row, which is the number of the component of the momentum.
    pub row: usize,
    /// The largest entry of the row after elimination: 0, or rounding error.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub pivot: f64,
    /// The sum of the magnitudes of the terms of this entry.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub terms: f64,
    /// The velocities that have the momentum.
    pub velocities: MomentumVelocities,
}

/// The velocities that have a momentum at a singular mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum MomentumVelocities {
    /// None, to rounding.
    None {
        /// Distance of a component of the momentum from the only value that it can have with the
        /// other components.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        distance: f64,
    },
    /// Infinitely many.
    Many,
    /// Rest, where the mass matrix vanishes in some direction.
    Rest,
    /// Not known: ∂L/∂v is not affine in v, and the mass matrix is singular at all velocities that
    /// were tried.
    Unknown,
}

/// Reason why an equation was not solved. [`StepError`](crate::StepError) is the form that users
/// see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolveError {
    /// The iteration reached its limit, or stopped decreasing the residual away from a root.
    NotConverged {
        /// Iterations made.
        iterations: u32,
        /// Relative residual reached.
        residual: f64,
        /// Relative residual wanted.
        tolerance: f64,
    },
    /// The matrix of a linear system is singular to rounding.
    Singular {
        /// Iteration of Newton's method, from 1; 0 for a linear block.
        iteration: u32,
    },
    /// The mass matrix ∂²L/∂v² is singular where a velocity is sought, so that no isolated velocity
    /// has the momentum.
    SingularMass {
        /// The row for which elimination finds no pivot.
        row: usize,
        /// The largest entry of this row after elimination.
        pivot: f64,
        /// The sum of the magnitudes of the terms of this entry.
        terms: f64,
        /// The velocities that have the momentum.
        velocities: MomentumVelocities,
    },
    /// The residual or the Jacobian is NaN or infinite.
    NonFinite,
    /// A root was found, but nothing shows that it is connected with the limit of no noise and
    /// h → 0.
    OtherBranch,
    /// No velocity with the given momentum is connected with the reference velocity of the Legendre
    /// transform.
    NoVelocity {
        /// Fraction of the path to the momentum along which velocities were found.
        reached: f64,
        /// Distance of the given momentum from the momentum of the last velocity found: the largest
        /// component of the difference.
        distance: f64,
    },
    /// The solution turns a rotation by more than a step may.
    LargeRotation {
        /// The angle in radians.
        angle: f64,
    },
    /// The solution is outside of the domain of L or of a noise.
    OutsideDomain {
        /// Number of the condition that does not hold.
        condition: usize,
    },
}
