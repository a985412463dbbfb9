//! Why the equations of a step were not solved.

/// Why an equation was not solved. [`StepError`](crate::StepError) is the form that users see.
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
    /// The residual or the Jacobian is NaN or infinite.
    NonFinite,
    /// A root was found, and nothing shows that it is connected with the limit of no noise and h → 0.
    OtherBranch,
    /// No velocity with the given momentum is connected with the reference velocity of the Legendre transform.
    NoVelocity {
        /// Fraction of the path to the momentum along which velocities were found.
        reached: f64,
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
