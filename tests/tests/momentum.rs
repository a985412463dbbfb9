//! Noether's theorem of the discrete step: where a shift or a rotation leaves L and the noises alone, its momentum stays, to
//! rounding, whatever the step size.
//!
//! Bound: a step rounds each p once in its last addition, and its equations hold to a few units of rounding (Newton's
//! tolerance is two), so the momentum changes by about 4ε times the size of its terms. These are as good as independent from step
//! to step: after n steps 4ε√n times that size, taken four times for safety. What a wrong term does is of the size of h².

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};
use sve_tests::models::{Central, Chain, Mixed};
use sve_tests::oracle::{central, chain, mixed};

const STEPS: u32 = 5000;

/// Follows `momentum`, which returns the terms of the sum that is conserved. The largest drift in units of the bound.
fn drift<S, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<S, R>,
    start: State<N>,
    momentum: impl Fn(&State<N>) -> [f64; K],
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let expected: f64 = momentum(&start).iter().sum();
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    let path = integrator.trajectory(start, 0.05, Wiener::new(8));
    for (n, state) in (1..=STEPS).zip(path) {
        let terms = momentum(&state.unwrap());
        size = terms.iter().fold(size, |m, x| m.max(x.abs()));
        let bound = 16.0 * f64::EPSILON * f64::from(n).sqrt() * size;
        worst = worst.max((terms.iter().sum::<f64>() - expected).abs() / bound);
    }
    println!(
        "{}: {worst} of the bound",
        sve_tests::oracle::name(integrator)
    );
    worst
}

fn angular(state: &State<2>) -> [f64; 2] {
    [state.q[0] * state.p[1], -state.q[1] * state.p[0]]
}

#[test]
fn angular_momentum_in_a_central_potential() {
    let start = State::new([1.0, 0.2], [-0.3, 0.8]);
    assert!(
        drift(
            &Integrator::<Central, _>::new(central(), InitialPoint),
            start,
            angular
        ) < 1.0
    );
    assert!(drift(&Integrator::new(central(), Endpoint), start, angular) < 1.0);
    assert!(drift(&Integrator::new(central(), Midpoint), start, angular) < 1.0);
}

#[test]
fn total_momentum_of_a_free_chain() {
    let start = State::new(
        [0.1, -0.2, 0.3, 0.0, 0.2, -0.1],
        [0.3, 0.1, -0.5, 0.7, 0.2, -0.4],
    );
    let total = |state: &State<6>| state.p;
    assert!(
        drift(
            &Integrator::<Chain, _>::new(chain(), InitialPoint),
            start,
            total
        ) < 1.0
    );
    assert!(drift(&Integrator::new(chain(), Endpoint), start, total) < 1.0);
    assert!(drift(&Integrator::new(chain(), Midpoint), start, total) < 1.0);
}

/// What is not conserved moves far beyond the bound: the test can tell.
#[test]
fn without_the_symmetry() {
    let start = State::new([0.2, -0.1], [0.1, 0.3]);
    let quiet = Mixed {
        s: [0.0; 3],
        ..mixed()
    };
    assert!(drift(&Integrator::new(quiet, Midpoint), start, angular) > 1e6);
}
