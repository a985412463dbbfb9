//! Stochastic variational integrators, derived from a Lagrangian at compile time.
//!
//! You write the Lagrangian `L(t, q, v)` of a mechanical system and its noise terms as plain functions of an `impl` block.
//! [`#[variational(…)]`](macro@variational) differentiates them and derives the step of each rule that you name: a symplectic
//! map, as straight-line code that does not allocate.
//!
//! ```text
//! dq =  v dt           + Σ ∂H₁/∂p ∘ dW
//! dp = (∂L/∂q + F) dt  + Σ ∂γ/∂q ∘ dW − Σ ∂H₁/∂q ∘ dW        p = ∂L/∂v        (Stratonovich)
//! ```
//!
//! ```
//! use sve_runtime::prelude::*;
//!
//! /// A pendulum whose pivot is shaken.
//! struct Pendulum { g: f64, sigma: f64 }
//!
//! #[variational(midpoint, endpoint)]
//! impl Pendulum {
//!     fn lagrangian(&self, q: f64, v: f64) -> f64 {
//!         0.5 * v * v + self.g * q.cos()
//!     }
//!
//!     #[gamma]
//!     fn shake(&self, q: f64) -> f64 {
//!         self.sigma * q.sin()
//!     }
//! }
//!
//! # fn main() -> Result<(), StepError> {
//! let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
//! println!("{}", pendulum.plan());                       // the equations of the step, and their cost
//! let mut state = State::new([1.0], [0.0]);              // q, p at t = 0
//! pendulum.step(&mut state, 0.01, &[0.02])?;             // one step with a given Wiener increment
//! for state in pendulum.trajectory(state, 0.01, Wiener::new(42)).take(100) {
//!     let state = state?;
//!     println!("{} {} {}", state.t, state.q[0], pendulum.system().hamiltonian(&state)?);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The [guide](crate::guide) answers questions, a page each: [your first system](crate::guide::first_system),
//! [which noise term](crate::guide::noise_terms), [choosing a rule and h](crate::guide::rules), [when a step fails](crate::guide::failures), ….
//!
//! # Map
//!
//! | to | use |
//! | --- | --- |
//! | describe a system | [`#[variational(…)]`](macro@variational) |
//! | choose a rule | [`InitialPoint`], [`Endpoint`], [`Midpoint`], [`StormerVerlet`], [`Gauss`], [`Taylor2`], with the options [`StageNoise`] and [`Weak2`] |
//! | compose steps of rules to a rule of a higher order | [`Composed`], [`Split`] |
//! | begin with a velocity, or a configuration | [`State::from_velocity`], [`State::from_configuration`] |
//! | change a parameter between steps | [`Integrator::system_mut`] |
//! | make steps | [`Integrator`] with `step` and `trajectory`, [`State`]; [`Method`] is common to integrators and baselines |
//! | know what the `q` of a state may be | [`Configuration`]; vectors, matrices and rotations are those of [`nalgebra`] |
//! | save every n-th state, states at given times, or all up to a time | [`Trajectory::every`], [`Trajectory::at`], [`Trajectory::until`] |
//! | write states, as CSV, for `NumPy`, as Parquet | [`Saved::to_csv`], [`StateTable`] |
//! | find sections and events along a trajectory | [`Trajectory::crossings`], [`Trajectory::stop_at`], [`Trajectory::change_at`] |
//! | average along a path, with the error of the average | [`Blocking`]; [`Mechanics::temperature`]; of many paths `Ensemble::average` |
//! | store a trajectory and continue it | [`Trajectory::snapshot`], [`Method::resume`]; [`from_step`](noise::Replayable::from_step) enters a noise at a step |
//! | see the equations and the cost of a step | [`Integrator::plan`], [`Plan`] |
//! | differentiate a step with respect to its start and the parameters | [`Integrator::tangent`], [`Integrator::sensitivity`] |
//! | differentiate a function of a path by its start and the parameters | [`Trajectory::gradient`], with [`Dual`] numbers; means of many paths with `Ensemble::gradient` |
//! | drive it with noise | [`noise`]: [`Wiener`](noise::Wiener), [`ThreePoint`](noise::ThreePoint), [`Recorded`](noise::Recorded), [`Truncated`](noise::Truncated), [`FromRng`](noise::FromRng), [`NoNoise`](noise::NoNoise) |
//! | put a start onto the constraints, see their forces | [`Integrator::consistent`], [`Integrator::constraint_forces`] |
//! | evaluate energy, momentum, velocity, drift | [`Mechanics`] |
//! | compare with other methods | [`baseline`] |
//! | measure what an error costs, method by method | `study::Study`, with the feature `study` |
//! | write code for any system and rule | [`System`], [`Rule`], [`Variational`], [`Dims`] |
//! | change Newton's method | [`Newton`], [`Integrator::with_newton`] |
//!
//! [`prelude`] has what a program that integrates a system imports. With features:
//!
//! | to | use | feature |
//! | --- | --- | --- |
//! | run many paths on all cores, and take statistics | [`Ensemble`][ensemble], [`Summary`][summary] | `ensemble` |
//! | see which statistics are unreliable, and why paths failed | [`Summary::warnings`][summary], [`Summary::failures`][summary], [`Ensemble::replay`][ensemble] | `ensemble` |
//! | average over time along many paths; solve a parabolic equation by paths | [`Ensemble::average`][ensemble], [`Ensemble::weight`][ensemble] | `ensemble` |
//! | show how far a run is | [`Ensemble::progress`][ensemble] | `progress` for a bar |
//! | stop a run and continue it; run parts of it on several machines | [`Ensemble::checkpoint`][ensemble], [`Ensemble::shard`][ensemble] | `checkpoint`; none |
//! | run on a cluster with MPI | the package `sve-mpi` | `distributed` |
//! | write statistics as CSV, for `NumPy`, as Parquet | [`Summary::to_csv`][summary], [`Summary::to_npy`][summary], [`Summary::to_parquet`][summary] | none, `npy`, `parquet` |
//! | serialise states, snapshots, errors, summaries | traits of serde | `serde` |
//! | measure what an error costs, method by method | [`Study`][study], [`Report`][study] | `study` |
//! | show ensembles and studies as pages, draw figures | [`Summary::write_html`][summary], [`Report::write_html`][study], [`plot`][plot] | `plot` |
//!
//! # Errors
//!
//! Functions that can fail return [`StepError`], or [`NoiseError`](noise::NoiseError) for a noise source: a message with the numbers
//! in question and what to change. A step that fails leaves the state unchanged. A NaN or infinite input, a step size that is zero, a
//! singular mass matrix, an iteration that does not converge, an overflow and a time that does not advance are errors; no step returns NaN.
//!
//! # Features
//!
//! None is on by default, and none changes a number. On docs.rs an item that needs a feature is marked with it.
//!
//! | feature | gives |
//! | --- | --- |
//! | `ensemble` | `Ensemble`: many paths, on all cores; statistics as CSV |
//! | `progress` | a bar that shows how far an ensemble is |
//! | `checkpoint` | ensembles that are stopped and continued |
//! | `distributed` | ensembles whose blocks another program distributes over processes, as the package `sve-mpi` does |
//! | `npy`, `parquet` | statistics of ensembles, and states of trajectories and paths, in these formats |
//! | `serde` | states, snapshots of trajectories, errors and summaries can be serialised |
//! | `study` | `study::Study`: errors, orders and times of several methods on one problem; with `ensemble` |
//! | `plot` | `plot`: figures as SVG and PNG; pages of the results of ensembles and studies |

// Badges of features, on docs.rs alone: rustdoc needs a nightly compiler for them.
#![cfg_attr(docsrs, feature(doc_cfg))]
// The links of the map. Without its feature an item is not there, and its link leads to the table of features.
#![doc = ""]
#![cfg_attr(feature = "ensemble", doc = "[ensemble]: crate::ensemble::Ensemble")]
#![cfg_attr(feature = "ensemble", doc = "[summary]: crate::ensemble::Summary")]
#![cfg_attr(not(feature = "ensemble"), doc = "[ensemble]: crate#features")]
#![cfg_attr(not(feature = "ensemble"), doc = "[summary]: crate#features")]
#![cfg_attr(feature = "study", doc = "[study]: crate::study::Study")]
#![cfg_attr(not(feature = "study"), doc = "[study]: crate#features")]
#![cfg_attr(feature = "plot", doc = "[plot]: crate::plot")]
#![cfg_attr(not(feature = "plot"), doc = "[plot]: crate#features")]

// Examples of single functions begin with the hidden lines of `example.md`, which make an integrator `pendulum` of a `system` and its `start`, and end with
// those of `example_end.md`. Ensembles and studies have lines of their own.

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
pub mod noise;
mod parameter;
mod phase;
#[cfg(feature = "plot")]
pub mod plot;
mod power;
mod readable;
mod rule;
mod solve;
#[cfg(feature = "study")]
pub mod study;
mod system;
mod table;
mod time;
mod trajectory;

pub use blocking::{BlockEstimate, Blocking};
pub use error::StepError;
pub use integrator::{ConstraintForce, ConstraintForces};
pub use integrator::{Integrator, Sensitivity, Tangent};
#[cfg_attr(not(feature = "ensemble"), doc(hidden))]
pub use lanes::{LANES, Lane, Mask};
pub use lyapunov::Lyapunov;
pub use mechanics::Mechanics;
pub use method::{Differentiable, OneStepMethod};
/// Vectors, matrices and rotations, in the version that this crate uses.
pub use nalgebra;
pub use phase::Field;
pub use phase::configuration::{
    Configuration, Coordinates, FixedSize, FlatConfiguration, Flatten, Reduced, VectorCoordinates,
    VectorSpace, WithRotations,
};
pub use phase::dual::{Dual, DualRotation, DualState};
#[cfg_attr(not(feature = "ensemble"), doc(hidden))]
pub use phase::lanes::StateLanes;
pub use phase::state::State;
pub use rule::{
    BlanesMoan4, BlanesMoanRkn6, Coefficients, Composed, Composition, ConstraintImpulses, Endpoint,
    Gauss, InitialPoint, KahanLi8, Midpoint, QuadraticKineticEnergy, Rule, Separable, Split,
    Splitting, StageNoise, StormerVerlet, Symmetric, Taylor2, Variational, Weak2,
};
pub use solve::newton::{BlockSolver, Newton};
pub use solve::{MomentumVelocities, SingularRow};
/// Derives the steps of a system from its Lagrangian. The simplest block has L alone:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Pendulum { g: f64 }
///
/// #[variational(midpoint)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         0.5 * v * v + self.g * q.cos()
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
/// let mut state = State::new([1.0], [0.0]);
/// pendulum.step(&mut state, 0.01, &[])?;
/// # Ok(())
/// # }
/// ```
///
/// With noise: a function γ(q), by which dp = … + ∂γ/∂q ∘ dW.
///
/// ```
/// use sve_runtime::prelude::*;
///
/// struct Pendulum { g: f64, sigma: f64 }
///
/// #[variational(midpoint)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         0.5 * v * v + self.g * q.cos()
///     }
///     #[gamma]
///     fn push(&self, q: f64) -> f64 {
///         self.sigma * q
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.1 }, Midpoint);
/// let mut state = State::new([1.0], [0.0]);
/// pendulum.step(&mut state, 0.01, &[0.02])?;              // with the increment of the Wiener process
/// # Ok(())
/// # }
/// ```
///
/// A system with time-dependent L, a helper, a constant, a parameter array and two noises:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// Two beads on parallel rails, coupled by a spring whose stiffness is modulated.
/// struct Beads { m: [f64; 2], k: f64, sigma: f64 }
///
/// #[variational(midpoint, endpoint)]
/// impl Beads {
///     const DEPTH: f64 = 0.1;
///
///     fn stiffness(&self, t: f64) -> f64 {
///         self.k * (1.0 + Self::DEPTH * t.sin())
///     }
///
///     fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
///         let mut kinetic = 0.0;
///         for i in 0..2 {
///             kinetic += 0.5 * self.m[i] * v[i].powi(2);
///         }
///         kinetic - 0.5 * self.stiffness(t) * (q[1] - q[0]).powi(2)
///     }
///
///     #[gamma]
///     fn pushes(&self, q: [f64; 2]) -> [f64; 2] {
///         [self.sigma * q[0], self.sigma * q[1]]
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let beads = Integrator::new(Beads { m: [1.0, 2.0], k: 4.0, sigma: 0.1 }, Endpoint);
/// assert_eq!((beads.plan().degrees_of_freedom, beads.plan().noises), (2, 2));
/// let mut state = State::new([0.0, 1.0], [0.0, 0.0]);
/// beads.step(&mut state, 0.01, &[0.02, -0.01])?;
/// // the functions of the block remain functions
/// assert_eq!(beads.system().stiffness(0.0), 4.0);
/// # Ok(())
/// # }
/// ```
///
/// With a force and a symmetry, which gives a conserved momentum:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// Two beads on parallel rails, coupled by a damped spring.
/// struct Coupled { m: [f64; 2], k: f64, nu: f64 }
///
/// #[variational(midpoint)]
/// impl Coupled {
///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
///         let [m1, m2] = self.m;
///         0.5 * m1 * v[0] * v[0] + 0.5 * m2 * v[1] * v[1] - 0.5 * self.k * (q[1] - q[0]).powi(2)
///     }
///
///     #[force]
///     fn damping(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
///         let pull = self.nu * (v[1] - v[0]);
///         [pull, -pull]
///     }
///
///     #[symmetry]
///     fn shift(&self, _q: [f64; 2]) -> [f64; 2] {
///         [1.0, 1.0]
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let coupled = Integrator::new(Coupled { m: [1.0, 2.0], k: 4.0, nu: 0.5 }, Midpoint);
/// let mut state = State::new([0.0, 1.0], [0.25, 0.5]);
/// let before = coupled.system().hamiltonian(&state)?;
/// for _ in 0..100 {
///     coupled.step(&mut state, 0.05, &[])?;
/// }
/// // the damping takes energy, but no total momentum
/// assert!(coupled.system().hamiltonian(&state)? < before);
/// assert!((coupled.system().shift_momentum(&state) - 0.75).abs() < 1e-14);
/// # Ok(())
/// # }
/// ```
///
/// With the runtime under another name, here within a module of one's own crate:
///
/// ```
/// mod physics {
///     pub use ::sve_runtime as sve;
/// }
/// use physics::sve::prelude::*;
///
/// struct Oscillator;
///
/// #[variational(taylor2, crate = physics::sve)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         0.5 * v * v - 0.5 * q * q
///     }
/// }
/// # let _ = Integrator::new(Oscillator, Taylor2).plan();
/// ```
///
/// A function that is not smooth is a compile-time error:
///
/// ```compile_fail
/// # use sve_runtime::prelude::*;
/// # struct Wall;
/// #[variational(midpoint)]
/// impl Wall {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         0.5 * v * v - q.abs() // error: `abs` has no derivative at 0: write …
///     }
/// }
/// # fn main() {}
/// ```
pub use sve_macros::variational;
pub use system::CoordinateRole;
pub use system::equations::{Memory, StepEquations, StepOf};
pub use system::euler::EulerIncrement;
pub use system::plan::{
    Block, BlockKind, DegenerateStep, Formulas, Operations, Plan, StrongOrder, Substeps,
};
pub use system::{
    ConfigurationOf, ConstraintJet, Dimensions, Dims, DualStateOf, FlatOf, FlatStateOf, ForceJet,
    Increments, IncrementsOf, LagrangianJet, MomentumOf, NoiseJet, StateOf, System, VectorOf,
};
#[cfg_attr(not(feature = "ensemble"), doc(hidden))]
pub use system::{IncrementLanesOf, StateLanesOf};
pub use table::{SaveError, StateTable};
pub use trajectory::Method;
pub use trajectory::{
    Adjoint, Events, Gradient, RefinedTrajectory, Refinements, Saved, Snapshot, Trajectory,
};

/// The items that a program imports to integrate a system: `use sve_runtime::prelude::*;`.
pub mod prelude {
    #[cfg(feature = "ensemble")]
    pub use crate::ensemble::{Ensemble, EnsembleError, Failure, StartRng, Statistics, Summary};
    pub use crate::noise::{
        FromRng, NoNoise, Noise, NoiseError, Recorded, Replayable, ThreePoint, Truncated, Wiener,
    };
    pub use crate::{
        BlanesMoan4, BlanesMoanRkn6, Composed, Endpoint, Gauss, InitialPoint, Integrator, KahanLi8,
        Mechanics, Method, Midpoint, Newton, OneStepMethod, Snapshot, Split, StageNoise, State,
        StepError, StormerVerlet, Taylor2, Weak2, variational,
    };
    pub use nalgebra::{
        Matrix2, Matrix3, Matrix4, Rotation2, Rotation3, SMatrix, SVector, UnitQuaternion, Vector1,
        Vector2, Vector3, Vector4, Vector5, Vector6,
    };
}

/// The interface of generated code. Not part of the public interface.
#[doc(hidden)]
pub mod __private {
    pub use crate::angle_addition::sin_cos_of_sum;
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
        pub use crate::phase::lanes::StateLanes;
        pub use crate::phase::tangents::{
            KeepUnknowns, LaneDirections, TangentLanes, regular_inverse, seeds, unfinished,
        };
        pub use crate::solve::diagonal::solve_in_lane as solve_diagonal;
        pub use crate::system::TangentLanesOf;
    }
    pub use crate::error::StepError;
    pub use crate::phase::configuration::{FixedSize, Reduced, WithRotations};
    pub use crate::system::CoordinateRole;
    pub use crate::system::equations::{Returns, StepEquations};
    /// The interface of generated increments of Euler's method.
    pub mod euler {
        pub use crate::system::euler::*;
    }
    pub use crate::lanes::Mask;
    pub use crate::parameter::{entry, number};
    pub use crate::phase::state::{State, in_coordinates, with_entries};
    pub use crate::power::power_log;
    pub use crate::rule::{QuadraticKineticEnergy, Separable, Unstructured};
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
    pub use crate::system::linearisation::{Covector, Directions, Entries, Linearisation};
    pub use crate::system::plan::{
        Block, BlockKind, DegenerateStep, Formulas, Operations, Plan, StrongOrder,
    };
    pub use crate::system::start::{StartOfStep, Tested};
    pub use crate::system::{ConstraintJet, Dims, ForceJet, LagrangianJet, NoiseJet, System};
    pub use nalgebra::UnitQuaternion;
    /// The derivatives of a step.
    pub type DMatrix = nalgebra::DMatrix<f64>;
}

/// The examples of the readme, as tests.
#[cfg(all(doctest, feature = "ensemble"))]
#[doc = include_str!("../../README.md")]
struct Readme;
