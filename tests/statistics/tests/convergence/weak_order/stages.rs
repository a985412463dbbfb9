//! Weak orders with stage noise.

use sve_models::orders::Order;
use sve_runtime::Rule;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::moments::{Matrix, distance, matrix, moments_with};
use super::quadrature::{expectations, gauss_hermite, tensor};
use super::systems::Heavy;
use super::{TOLERANCE, apart, halved, line, stiffness};

/// One line for a rule with the noise of two stages, each with half of the variance.
pub(super) fn of_two_stages<S, R, const N: usize, const M: usize, const K: usize>(
    integrator: &Integrator<S, R>,
    (noise, expected): (&str, u32),
    start: State<[f64; N]>,
    exact: &Matrix,
) where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself, Increments = [f64; K]>,
{
    let error = |level| distance(&moments_with(integrator, start, level, [0.5; K]), exact);
    let errors: Vec<f64> = (4..=7).map(error).collect();
    let plan = integrator.plan();
    assert!(plan.weak_order <= expected);
    line(plan.system, plan.rule, noise, expected, &errors);
}

#[test]
fn noisy_stiffness() {
    let start = State::new([1.0], [0.0]);
    for (system, noise, exact) in stiffness(start) {
        let plain = Integrator::new(system.clone(), StageNoise(Gauss::<2>));
        of_two_stages(&plain, (noise, 1), start, &exact);
        // above the order 2 that the plan states
        let corrected = Integrator::new(system, Weak2(StageNoise(Gauss::<2>)));
        of_two_stages(&corrected, (noise, 3), start, &exact);
    }
}

/// Increments of two stages, and their weight in an expectation.
type Node = ([f64; 2], f64);

/// Errors of second moments with the noise of two stages.
fn errors<R>(
    rule: R,
    (heavy, start, nodes): (&Heavy, State<[f64; 1]>, &[Node]),
    exact: &[f64],
    observe: &dyn Fn(&State<[f64; 1]>) -> Vec<f64>,
) -> Vec<f64>
where
    R: Rule<Heavy, Increments = [f64; 2]>,
{
    let integrator = Integrator::new(heavy.clone(), rule);
    let error = |steps: u32| {
        let h = 0.5 / f64::from(steps);
        let found = expectations(&integrator, start, (steps, h), nodes, observe);
        apart(&found, exact)
    };
    [1, 2, 4].map(error).to_vec()
}

/// With stage noise the steps are 1, 2 and 4 to T = ½, since each has two increments.
#[test]
fn stage_noise_with_a_mass_that_depends_on_the_configuration() {
    let heavy = Heavy { sigma: 0.8 };
    let start = State::new([1.2], [0.4]);
    let square = heavy.moments(&start);
    let at = [square[0].sqrt(), square[3].sqrt()];
    let drift = matrix([[0.0, 1.0], [-1.0, 0.0]]);
    let noise = matrix([[0.0, 0.0], [heavy.sigma, 0.0]]);
    let exact = halved(&at, &drift, &noise);
    let observe = |state: &State<[f64; 1]>| heavy.moments(state);
    let mut nodes = tensor::<2>(&gauss_hermite(4));
    for (x, _) in &mut nodes {
        *x = x.map(|x| x * 0.5_f64.sqrt());
    }
    let of = "mass 1 + q²/4";
    let all = (&heavy, start, nodes.as_slice());
    let plain = errors(StageNoise(Gauss::<2>), all, &exact, &observe);
    line("Heavy", "gauss(2, stage_noise)", of, 1, &plain);
    let rule = Weak2(StageNoise(Gauss::<2>));
    let corrected = errors(rule, all, &exact, &observe);
    let order = Order::of(&corrected);
    println!("| Heavy | gauss(2, stage_noise, weak2) | {of} | 2 or above | {order:?} |");
    assert!(order.value > 2.0 - TOLERANCE.bias, "{order:?}");
}
