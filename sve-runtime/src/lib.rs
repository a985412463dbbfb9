#![doc = include_str!("../docs/crate.md")]
// Badges of features, on docs.rs alone: rustdoc needs a nightly compiler for them.
#![cfg_attr(docsrs, feature(doc_cfg))]
// The links of the map. Without its feature an item is not there, and its link leads to the table
// of features.
#![doc = ""]
#![cfg_attr(feature = "ensemble", doc = "[ensemble]: crate::ensemble::Ensemble")]
#![cfg_attr(feature = "ensemble", doc = "[summary]: crate::ensemble::Summary")]
#![cfg_attr(not(feature = "ensemble"), doc = "[ensemble]: crate#features")]
#![cfg_attr(not(feature = "ensemble"), doc = "[summary]: crate#features")]
#![cfg_attr(feature = "study", doc = "[study]: crate::study::Study")]
#![cfg_attr(not(feature = "study"), doc = "[study]: crate#features")]
#![cfg_attr(feature = "plot", doc = "[plot]: crate::plot")]
#![cfg_attr(not(feature = "plot"), doc = "[plot]: crate#features")]

// Examples of single functions begin with the hidden lines of `example.md`, which make an
// integrator `pendulum` of a `system` and its `start`, and end with the lines of `example_end.md`.
// Ensembles and studies have lines of their own.

#[doc(hidden)]
pub mod __private;
mod angle_addition;
pub mod baseline;
mod blocking;
#[cfg(feature = "ensemble")]
mod description;
#[cfg(feature = "ensemble")]
pub mod ensemble;
mod error;
mod file;
mod fingerprint;
#[cfg(feature = "serde")]
mod floats;
mod gauss;
#[cfg(doc)]
pub mod guide;
mod integrator;
mod lanes;
mod lyapunov;
mod mechanics;
mod method;
mod neighbours;
pub mod noise;
mod parameter;
mod phase;
#[cfg(feature = "plot")]
pub mod plot;
mod power;
mod progress;
mod readable;
mod rule;
mod scene;
mod solve;
#[cfg(feature = "study")]
pub mod study;
pub mod system;
mod table;
mod time;
mod trajectory;

pub use blocking::{BlockEstimate, Blocking};
pub use error::StepError;
pub use integrator::{
    ConstraintForce, ConstraintForces, Holding, Integrator, Sensitivity, Tangent,
};
pub use lyapunov::Lyapunov;
pub use mechanics::Mechanics;
pub use mechanics::time_scale::{TimeScale, TimedState, WithTimeScale};
pub use method::OneStepMethod;
/// Vectors, matrices and rotations, in the version that this crate uses.
pub use nalgebra;
pub use neighbours::{NeighbourError, Neighbours, SpaceOrder};
pub use phase::configuration::{Configuration, Reduced};
pub use phase::dual::{Dual, DualRotation, DualState};
pub use phase::state::State;
pub use rule::{
    BlanesMoan4, BlanesMoanRkn6, Composed, Endpoint, Gauss, InitialPoint, KahanLi8, Midpoint, Rule,
    Split, StageNoise, StormerVerlet, Taylor2, Variational, Weak2,
};
pub use scene::{Layout, MidpointSolution, SceneMechanics};
pub use solve::newton::Newton;
pub use solve::{MomentumVelocities, SingularRow};
/// Derives the steps of a system from its Lagrangian.
///
#[doc = include_str!("../docs/variational.md")]
pub use sve_macros::variational;
pub use system::plan::Plan;
pub use table::{SaveError, StateTable, Xyz};
pub use trajectory::{
    AccurateTrajectory, Adjoint, DrivenPaths, DrivenTrajectory, Events, Gradient, Method,
    NeedsInputs, RefinedTrajectory, Refinements, Saved, ScaledPaths, ScaledTrajectory, Snapshot,
    Trajectory,
};

/// The parts of a [`Plan`]: what is solved in a step, by which formulas, with which orders and
/// operations.
pub mod plan {
    pub use crate::system::plan::{
        Block, BlockKind, DegenerateStep, Formulas, Operations, StrongOrder, Substeps,
    };
}

/// The items that a program imports to integrate a system: `use sve_runtime::prelude::*;`.
pub mod prelude {
    #[cfg(feature = "ensemble")]
    pub use crate::ensemble::{
        Bins, Ensemble, EnsembleError, Failure, StartRng, Starts, Statistics, Summary,
    };
    pub use crate::noise::{
        FromRng, NoNoise, Noise, NoiseError, Recorded, Replayable, ThreePoint, Truncated, Wiener,
    };
    pub use crate::{
        BlanesMoan4, BlanesMoanRkn6, Composed, DrivenPaths, Endpoint, Gauss, InitialPoint,
        Integrator, KahanLi8, Mechanics, Method, Midpoint, NeighbourError, Neighbours, Newton,
        OneStepMethod, ScaledPaths, SceneMechanics, Snapshot, Split, StageNoise, State, StepError,
        StormerVerlet, Taylor2, TimedState, Weak2, WithTimeScale, Xyz, variational,
    };
    pub use nalgebra::{
        Matrix2, Matrix3, Matrix4, Rotation2, Rotation3, SMatrix, SVector, UnitQuaternion, Vector1,
        Vector2, Vector3, Vector4, Vector5, Vector6,
    };
}

/// The examples of the readme, as tests.
#[cfg(all(doctest, feature = "ensemble", feature = "plot"))]
#[doc = include_str!("../../README.md")]
struct Readme;
