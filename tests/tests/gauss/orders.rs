//! The order of the rules: the error of one step falls with the power 2S + 1 of its size.

use sve_models::orders::{Order, Tolerance};
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{VariableMass, double_pendulum, pendulum};

/// Random starts, over which the errors of a step are averaged: the leading coefficient of a single
/// one may vanish.
const STARTS: usize = 40;

/// Root mean square of the error of one step of size `h`, measured with 16 steps of order 16.
fn error<S, const STAGES: usize, const N: usize, const M: usize>(system: &S, h: f64) -> f64
where
    S: Variational<Gauss<STAGES>> + Variational<Gauss<8>> + System<Dims = Dims<N, M>>,
{
    let mut random = Random::new(3);
    let (coarse, fine) = (
        Integrator::new(system, Gauss::<STAGES>),
        Integrator::new(system, Gauss::<8>),
    );
    let mut sum = 0.0;
    for _ in 0..STARTS {
        let start = State::new(random.array(-1.0, 1.0), random.array(-0.2, 0.2));
        let (mut state, mut expected) = (start, start);
        coarse.step(&mut state, h, &[0.0; M]).unwrap();
        for _ in 0..16 {
            fine.step(&mut expected, h / 16.0, &[0.0; M]).unwrap();
        }
        for i in 0..N {
            sum += (state.q[i] - expected.q[i]).powi(2) + (state.p[i] - expected.p[i]).powi(2);
        }
    }
    (sum / STARTS as f64).sqrt()
}

/// Checks that the slope between these step sizes is `2 STAGES + 1`, with errors between rounding
/// and 0.1.
fn check<S, const STAGES: usize, const N: usize, const M: usize>(
    system: &S,
    [large, small]: [f64; 2],
) where
    S: Variational<Gauss<STAGES>> + Variational<Gauss<8>> + System<Dims = Dims<N, M>>,
{
    let errors = [large, small].map(|h| error::<S, STAGES, N, M>(system, h));
    // Between these sizes the terms of higher order are still felt; the order of another number of
    // stages differs by 2.
    let tolerance = Tolerance {
        bias: if STAGES < 4 { 0.2 } else { 1.0 },
        error: 0.0,
    };
    assert!(errors[0] < 0.1 && errors[1] > 1e-14, "{errors:?}");
    let order = Order {
        value: (errors[0] / errors[1]).ln() / (large / small).ln(),
        error: 0.0,
    };
    let name = format!("gauss({STAGES})");
    let names = [std::any::type_name::<S>(), &name, "none"];
    order.check(names, (2 * STAGES + 1) as f64, tolerance);
}

#[test]
fn a_pendulum_has_order_twice_the_stages() {
    let system = &pendulum();
    check::<_, 2, 1, 0>(system, [0.1, 0.05]);
    check::<_, 3, 1, 0>(system, [0.4, 0.2]);
    check::<_, 4, 1, 0>(system, [0.5, 0.3]);
    check::<_, 8, 1, 0>(system, [2.2, 1.8]);
}

#[test]
fn a_double_pendulum_has_order_twice_the_stages() {
    let system = &double_pendulum();
    check::<_, 2, 2, 2>(system, [0.1, 0.05]);
    check::<_, 3, 2, 2>(system, [0.2, 0.1]);
    check::<_, 4, 2, 2>(system, [0.15, 0.1]);
    check::<_, 8, 2, 2>(system, [0.7, 0.55]);
}

#[test]
fn a_mass_that_depends_on_the_position_leaves_the_order() {
    let system = &VariableMass;
    check::<_, 2, 1, 0>(system, [0.1, 0.05]);
    check::<_, 3, 1, 0>(system, [0.2, 0.1]);
    check::<_, 4, 1, 0>(system, [0.3, 0.2]);
    check::<_, 8, 1, 0>(system, [1.2, 0.9]);
}
