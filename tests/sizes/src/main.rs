//! The largest systems that the guide names, built as in a user's crate: with full debug
//! information and without optimisation, where the compiler needs most stack. Each rule makes a
//! step, and each derivative is evaluated.

mod bodies;
mod chain;
mod pendulum;

use sve_runtime::prelude::*;
use sve_runtime::Variational;
use sve_runtime::system::{Dims, System};

/// Rounding errors of some thousand operations.
const ROUNDING: f64 = 1e-10;

fn main() {
    bodies::check();
    chain::check();
    pendulum::check();
}

/// Checks that a step keeps the symplectic form.
fn check<S, R, const N: usize, const M: usize>(system: S, rule: R, state: State<[f64; N]>)
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let integrator = Integrator::new(system, rule);
    let rule = integrator.plan().rule;
    match integrator.tangent(&state, 0.01, &[0.1; M]) {
        Ok(tangent) => {
            let defect = tangent.symplectic_defect();
            assert!(defect < ROUNDING, "{rule}: {defect:e}");
            println!("{N} coordinates, {M} noises, `{rule}`: {defect:.1e}");
        }
        Err(error) => panic!("{rule}: {error}"),
    }
}
