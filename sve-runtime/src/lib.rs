//! Stochastic variational integrators, derived from a Lagrangian at compile time.

pub mod baseline;
mod error;
mod integrator;
mod linear;
mod mechanics;
mod method;
mod newton;
pub mod noise;
mod plan;
mod rules;
mod state;
mod system;
mod trajectory;
mod turn;

pub use error::StepError;
pub use integrator::Integrator;
pub use mechanics::{Field, Mechanics};
pub use method::Method;
pub use newton::Newton;
pub use plan::{Block, BlockKind, Operations, Plan, StrongOrder};
pub use rules::{Endpoint, InitialPoint, Midpoint, Taylor2};
pub use state::State;
pub use sve_macros::variational;
pub use system::{
    Dimensions, Dims, IncrementsOf, LagrangianJet, NoiseJet, StateOf, System, Variational, VectorOf,
};
pub use trajectory::Trajectory;

/// What a program that integrates a system imports: `use sve_runtime::prelude::*;`.
pub mod prelude {
    pub use crate::noise::{FromRng, NoNoise, Noise, NoiseError, Recorded, Truncated, Wiener};
    pub use crate::{
        Endpoint, InitialPoint, Integrator, Mechanics, Method, Midpoint, Newton, State, StepError,
        Taylor2, variational,
    };
}

/// What generated code calls. Not part of the public interface.
#[doc(hidden)]
pub mod __private {
    pub use crate::linear::solve;
    pub use crate::newton::{Evaluation, Newton, SolveError};
    pub use crate::plan::{Block, BlockKind, Operations, Plan, StrongOrder};
    pub use crate::state::State;
    pub use crate::system::{Dims, LagrangianJet, NoiseJet, System, Variational};
    pub use crate::turn::turn;
}
