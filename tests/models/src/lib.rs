//! Code shared by the tests: models, the users' functions as oracles, all models with all rules as
//! objects, checks of a feature of the language, comparisons, loops over rules, difference
//! quotients, orders of convergence, random points, an exact solution, moments of linear systems.

pub mod case;
pub mod checks;
pub mod configured;
pub mod degenerate;
pub mod differences;
#[path = "../../../sve-macros/compiler/src/algebra/double_double.rs"]
pub mod double_double;
pub mod exact;
pub mod functions;
#[path = "../../../examples/src/gaussian.rs"]
pub mod gaussian;
pub mod language;
pub mod models;
pub mod oracle;
pub mod orders;
pub mod potential;
pub mod random;
pub mod reference;
pub mod stepper;
pub mod steps;

/// Returns whether the environment variable `SVE_THOROUGH` asks for many more random cases and
/// longer paths, which take minutes. The tests are the same programs then, and are not built again.
pub fn is_thorough() -> bool {
    std::env::var_os("SVE_THOROUGH").is_some()
}
