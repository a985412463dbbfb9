//! Tangent maps and sensitivities against differences of steps, symplecticity with noise, momenta,
//! and steps back.

use sve_models::oracle::{rubbed, sail};
use sve_models::random::Random;
use sve_models::steps::{check_return, check_sensitivity, check_tangent};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{
    Central, Everything, Kubo, Relativistic, VariableMass, double_pendulum, everything, pendulum,
};

const H: f64 = 0.15;

fn random_state<const N: usize>(random: &mut Random) -> State<[f64; N]> {
    State::at(
        random.uniform(0.2, 1.0),
        random.array(-0.6, 0.6),
        random.array(-0.6, 0.6),
    )
}

/// Compares the tangent map with central differences, checks that it is symplectic, and that the
/// step back returns.
fn check<S, R, const N: usize, const M: usize>(system: &S, rule: R, is_forced: bool)
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let integrator = Integrator::new(system, rule);
    let mut random = Random::new(17);
    for _ in 0..25 {
        let start = random_state::<N>(&mut random);
        let dw: [f64; M] = random.array(-0.2, 0.2);
        let defect = (!is_forced).then_some(1e-13);
        check_tangent(&integrator, &start, H, &dw, defect);
        let back = dw.map(|w| -w);
        check_return(&integrator, &start, H, [&dw, &back], 4e-15);
    }
}

#[test]
fn tangent_maps_are_derivatives_and_symplectic_and_steps_return() {
    check::<_, _, 1, 0>(&pendulum(), Gauss::<2>, false);
    check::<_, _, 1, 0>(&pendulum(), Gauss::<8>, false);
    check::<_, _, 2, 2>(&double_pendulum(), Gauss::<3>, false);
    check::<_, _, 2, 2>(&double_pendulum(), Gauss::<8>, false);
    let kubo = Kubo { a: 1.3, sigma: 0.6 };
    check::<_, _, 1, 1>(&kubo, Gauss::<2>, false);
    check::<_, _, 1, 1>(&kubo, Gauss::<8>, false);
    check::<_, _, 1, 0>(&VariableMass, Gauss::<4>, false);
    let relativistic = Relativistic {
        m: 1.1,
        c: 1.5,
        k: 0.7,
    };
    check::<_, _, 1, 0>(&relativistic, Gauss::<3>, false);
    check::<_, _, 1, 0>(&relativistic, Gauss::<4>, false);
    check::<_, _, 2, 2>(&everything(), Gauss::<2>, true);
    check::<_, _, 2, 2>(&everything(), Gauss::<4>, true);
    check::<_, _, 2, 3>(&sail(), Gauss::<2>, true);
    check::<_, _, 2, 3>(&sail(), Gauss::<3>, true);
    check::<_, _, 2, 3>(&sail(), Gauss::<4>, true);
    check::<_, _, 1, 2>(&rubbed(), Gauss::<4>, true);
}

#[test]
fn sensitivities_with_noise_forces_are_derivatives() {
    let names = ["c", "s[0]", "s[1]", "s[2]"];
    let mut random = Random::new(6);
    for _ in 0..10 {
        let start = random_state::<2>(&mut random);
        let dw = random.array(-0.2, 0.2);
        let system = |name: &str, by: f64| {
            let mut sail = sail();
            match name {
                "c" => sail.c += by,
                _ => sail.s[usize::from(name.as_bytes()[2] - b'0')] += by,
            }
            sail
        };
        check_sensitivity(system, Gauss::<3>, &names, &start, (H, &dw));
    }
}

#[test]
fn sensitivities_are_derivatives_by_the_parameters() {
    let names = ["m", "b", "k", "nu", "sigma[0]", "sigma[1]"];
    let parameters = [1.3, 0.4, 0.8, 0.3, 0.5, 0.4];
    let mut random = Random::new(4);
    for _ in 0..20 {
        let start = random_state::<2>(&mut random);
        let dw = random.array(-0.2, 0.2);
        let system = |name: &str, by: f64| {
            let mut parameters = parameters;
            parameters[names.iter().position(|n| *n == name).unwrap()] += by;
            Everything::with_parameters(parameters)
        };
        check_sensitivity(system, Gauss::<4>, &names, &start, (H, &dw));
    }
}

#[test]
fn momentum_maps_are_conserved_with_noise() {
    let central = Central { m: 0.9, s: 0.5 };
    let start = State::new([0.8, -0.1], [0.2, 0.9]);
    let expected = central.rotation_momentum(&start);
    let [three, four]: [Vec<State<[f64; 2]>>; 2] = [
        path(&Integrator::new(&central, Gauss::<3>), start),
        path(&Integrator::new(&central, Gauss::<4>), start),
    ];
    // the noise heats the body, and rounding errors are those of |q| |p|
    let mut largest: f64 = 1.0;
    for state in three.iter().chain(&four) {
        let momentum = central.rotation_momentum(state);
        let norm = |x: [f64; 2]| x[0].hypot(x[1]);
        largest = largest.max(norm(state.q) * norm(state.p));
        let error = (momentum - expected).abs();
        assert!(error < 1e-14 * largest, "{momentum} for {expected}");
    }
}

fn path<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
) -> Vec<State<[f64; N]>>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let path = integrator.trajectory(start, 0.1, Wiener::new(8));
    path.take(200).collect::<Result<_, _>>().unwrap()
}
