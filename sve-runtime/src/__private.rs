//! The interface of generated code, and of the tests and benchmarks of this repository. It is not
//! part of the public interface.

/// The interface of generated increments of Euler's method.
pub mod euler {
    pub use crate::system::euler::*;
}
/// The interface of generated steps of Gauss rules.
pub mod gauss {
    pub use crate::gauss::*;
}
/// The interface of generated steps in lanes.
pub mod lane {
    pub use crate::lanes::elementary::*;
    pub use crate::lanes::newton::{ContractingLanes, NewtonLanes, SingleLanes};
    pub use crate::lanes::solve::{
        Solved, factored, has_digits, inverse, is_regular, solve, solved,
    };
    pub use crate::lanes::{Aligned, LANES, Lane, Mask, marked, needs_scalar_step, rows};
    pub use crate::phase::lanes::{LaneStates, StateLanes};
    pub use crate::phase::tangents::{
        FieldLanes, KeepUnknowns, LaneDirections, TangentLanes, regular_inverse, seeds, unfinished,
    };
    pub use crate::solve::diagonal::solve_in_lane as solve_diagonal;
    pub use crate::system::aliases::TangentLanesOf;
    pub use crate::system::inputs::inputs;
}

/// The interface of generated scenes.
pub mod scene {
    pub use crate::integrator::scenes::Scenes;
    pub use crate::scene::*;
}

pub use crate::angle_addition::sin_cos_of_sum;
pub use crate::error::StepError;
pub use crate::integrator::adapted::{AdaptsSteps, Attempts, BoxedAttempts, Rate};
pub use crate::integrator::steps::Steps;
pub use crate::lanes::dispatch::{Vectors, use_vectors};
pub use crate::lanes::{LANES, Lane, Mask};
pub use crate::mechanics::time_scale::{ScaledTime, TimeScale, WithTimeScale};
pub use crate::method::{Differentiable, Shared};
pub use crate::parameter::{entry, number};
pub use crate::phase::Field;
pub use crate::phase::configuration::{
    Coordinates, FlatConfiguration, Flatten, VectorCoordinates, VectorSpace,
};
pub use crate::phase::configuration::{FixedSize, Reduced, Site, WithRotations};
pub use crate::phase::lanes::StateLanes;
pub use crate::phase::state::{State, in_coordinates, with_entries};
pub use crate::power::power_log;
pub use crate::rule::{
    Coefficients, Composition, ConstraintImpulses, Mode, QuadraticKineticEnergy, Separable, Shear,
    Splitting, StepShear, Symmetric, Unstructured, Walker, shears,
};
pub use crate::solve::SolveError;
pub use crate::solve::banded::Banded;
pub use crate::solve::cofactors::Cofactors;
pub use crate::solve::dense::{
    DeterminantSign, Factors, factored, is_regular, solve, solve_with_sign,
};
pub use crate::solve::diagonal::Diagonal;
pub use crate::solve::newton::{
    BlockProperties, BlockSolver, Evaluation, Newton, rounding as rounded,
};
pub use crate::solve::regularity::{all_positive, contains_path, is_regular_within};
pub use crate::system::aliases::{
    ConfigurationOf, DualStateOf, FlatOf, FlatStateOf, IncrementLanesOf, MomentumOf, StateLanesOf,
    StateOf, VectorOf,
};
pub use crate::system::any::{FixedSizes, Kind};
pub use crate::system::equations::{Memory, StepOf, nodes_between};
pub use crate::system::equations::{Returns, StepEquations};
pub use crate::system::euler::EulerIncrement;
pub use crate::system::inputs::{HeldInputs, Inputs};
pub use crate::system::linearisation::{Covector, Directions, Entries, Linearisation};
pub use crate::system::plan::{
    Block, BlockKind, DegenerateStep, Formulas, Operations, Plan, StrongOrder,
};
pub use crate::system::sizes::{AnyIncrements, Dimensions, Increments};
pub use crate::system::start::{StartOfStep, Tested};
pub use crate::system::{
    AnySystem, ConstraintJet, CoordinateRole, Dims, ForceJet, LagrangianJet, Names, NoiseJet,
    System, WithInputs,
};
pub use crate::trajectory::{
    AdaptedSteps, CompensatedSums, EqualSteps, FixedSteps, RefinedSteps, StepKind,
    StepsWithoutInputs, WholeSteps, WithoutEvents, WithoutNoise,
};
pub use nalgebra::UnitQuaternion;
/// The derivatives of a step.
pub type DMatrix = nalgebra::DMatrix<f64>;
