//! Steps that fail leave the state unchanged.

use sve_models::assert_matches;
use sve_models::checks::failure;
use sve_runtime::prelude::*;

use crate::systems::{Logarithmic, Relativistic, double_pendulum, pendulum};

#[test]
fn bad_input_is_the_right_error() {
    let two = Integrator::new(pendulum(), Gauss::<2>);
    let eight = Integrator::new(pendulum(), Gauss::<8>);
    for bad in [f64::NAN, f64::INFINITY] {
        let start = State::new([bad], [0.0]);
        let errors = [
            failure(&two, &start, 0.1, &[]),
            failure(&eight, &start, 0.1, &[]),
        ];
        let is_input = |e: &StepError| matches!(e, StepError::NonFiniteInput { .. });
        assert!(errors.iter().all(is_input), "{errors:?}");
    }
    let error = failure(&eight, &State::new([1.0], [0.0]), 0.0, &[]);
    assert_matches!(error, StepError::StepSize { .. });
    let noisy = Integrator::new(double_pendulum(), Gauss::<4>);
    let start = State::new([1.0, 0.0], [0.0, 0.0]);
    let error = failure(&noisy, &start, 0.1, &[f64::NAN, 0.0]);
    assert_matches!(error, StepError::NonFiniteInput { .. });
}

#[test]
fn steps_stay_in_the_domain() {
    let two = Integrator::new(Logarithmic, Gauss::<2>);
    let four = Integrator::new(Logarithmic, Gauss::<4>);
    for h in [0.05, 0.2] {
        let mut ends = [State::new([0.5], [-0.2]); 2];
        two.step(&mut ends[0], h, &[]).unwrap();
        four.step(&mut ends[1], h, &[]).unwrap();
        assert!((ends[0].q[0] - ends[1].q[0]).abs() < 1e-3, "{ends:?}");
    }
    let outside = State::new([-0.5], [0.0]);
    failure(&two, &outside, 0.1, &[]);
    failure(&four, &outside, 0.1, &[]);
}

#[test]
fn a_relativistic_particle_stays_below_the_speed_of_light() {
    let system = Relativistic {
        m: 1.0,
        c: 1.0,
        k: 1.0,
    };
    let integrator = Integrator::new(&system, Gauss::<4>);
    // a momentum of 100 mc
    let mut state = State::new([0.0], [100.0]);
    integrator.step(&mut state, 0.1, &[]).unwrap();
    let distance = 1.0 - state.q[0] / 0.1;
    assert!((distance - 5e-5).abs() < 1e-6, "{distance:e}");
}
