//! A system of sve as the Python module `swing`.
//!
//! Change the struct, the block and the line of `expose!`; the other files work for any system.

mod arguments;
mod ensemble;
mod errors;
mod expose;
mod state;
mod summary;
mod trajectory;

use expose::expose;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use sve_runtime::prelude::*;

/// A pendulum of unit mass and length, whose pivot is shaken at random.
///
/// The angle q is 0 at the bottom, and the momentum p is the angular velocity. g is the
/// acceleration of gravity, sigma the strength of the noise: dp = −g sin q dt + sigma cos q ∘ dW.
#[pyclass(frozen, get_all)]
#[derive(Clone)]
struct Pendulum {
    g: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
    #[gamma]
    fn shaking(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

expose! {
    swing: Pendulum { g: f64 = 9.81, sigma: f64 = 0.5 } by Midpoint;
}
