//! The mean energy of the linear oscillator against its exact recursion.

use sve_models::checks::assert_within;
use sve_models::gaussian::{ENERGY, Scheme, linear};
use sve_models::models::Oscillator;
use sve_models::stepper::Stepper;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Method, Variational};

use crate::runs::oscillator;

const H: f64 = 0.1;
const PATHS: u64 = 20_000;

/// Returns the steps of length `h` as a map of distributions.
pub(crate) fn scheme(method: &impl Method<System = Oscillator>, h: f64) -> Scheme<2> {
    Scheme::driven(linear(method, h).expect("steps"), h)
}

fn check<R: Sync>(rule: R, seed: u64)
where
    Oscillator: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let integrator = oscillator(rule);
    let summary = Ensemble::new(&integrator)
        .paths(PATHS)
        .seed(seed)
        .steps(H, 500)
        .every(50)
        .start(State::new([1.0], [0.0]))
        .observe("energy", Mechanics::hamiltonian)
        .run()
        .unwrap();
    let exact = scheme(&integrator, H);
    let statistics = &summary["energy"];
    assert_eq!(summary.times().len(), 11);
    assert_eq!(statistics.mean()[0], 0.5);
    assert_eq!(statistics.variance()[0], 0.0);
    for record in 1..=10 {
        let (mean, variance) = exact.after([1.0, 0.0], 50 * record).quadratic(&ENERGY);
        let row = format!("{}, record {record}", integrator.name());
        let error = (variance / PATHS as f64).sqrt();
        assert_within(statistics.mean()[record], mean, error, 4.0, &row);
        // the kurtosis of χ² with two degrees of freedom is 9
        let ratio = statistics.variance()[record] / variance;
        assert_within(ratio, 1.0, (8.0 / PATHS as f64).sqrt(), 4.0, &row);
    }
}

#[test]
fn mean_energies_are_exact() {
    check(Endpoint, 1);
    check(Midpoint, 2);
}
