//! The numbers that a trajectory carries: the stages of the last step, from which the next one
//! starts.

use sve_models::checks::{assert_close, assert_states_close};
use sve_models::orders::numbers;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{VariableMass, pendulum};

const H: f64 = 0.2;

/// Checks that each step of a trajectory is that from its state alone, to rounding, and that a
/// stored trajectory continues with the same bits. Returns whether some step of the trajectory has
/// other bits than that from its state: then it used the stages of the step before.
fn check<S, R, const N: usize>(integrator: &Integrator<S, R>, start: State<[f64; N]>) -> bool
where
    S: Variational<R> + System<Dims = Dims<N, 0>>,
{
    let path = || integrator.trajectory(start, H, NoNoise);
    let states: Vec<State<[f64; N]>> = path().take(600).collect::<Result<_, _>>().unwrap();
    let mut differs = false;
    for pair in states.windows(2) {
        let mut state = pair[0];
        integrator.step(&mut state, H, &[]).unwrap();
        let (found, expected) = (numbers(&pair[1]), numbers(&state));
        let size = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let rounding = 4.0 * f64::EPSILON * size;
        assert_close(&found, &expected, rounding, "a step of the trajectory");
        differs |= found != expected;
    }

    let mut first = path();
    first.nth(19).unwrap().unwrap();
    let continued = integrator.resume(first.snapshot(), NoNoise).unwrap();
    let continued: Vec<State<[f64; N]>> = continued.take(580).collect::<Result<_, _>>().unwrap();
    assert_eq!(continued, states[20..]);
    differs
}

#[test]
fn trajectories_are_repeated_steps_to_rounding_and_continue_bit_for_bit() {
    let start = State::new([1.7], [0.2]);
    let differs = [
        check(&Integrator::new(pendulum(), Gauss::<4>), start),
        check(&Integrator::new(pendulum(), Gauss::<8>), start),
        check(&Integrator::new(VariableMass, Gauss::<4>), start),
        check(&Integrator::new(VariableMass, Gauss::<8>), start),
    ];
    assert!(differs.contains(&true), "{differs:?}");
}

#[test]
fn a_trajectory_leads_back() {
    let integrator = Integrator::new(pendulum(), Gauss::<8>);
    let start = State::new([1.7], [0.2]);
    let end = |start, h| {
        let mut path = integrator.trajectory(start, h, NoNoise);
        path.nth(99).unwrap().unwrap()
    };
    assert_states_close(&end(end(start, H), -H), &start, 1e-13, "back");
}
