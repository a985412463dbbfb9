//! Steps that fail leave the state unchanged.

use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{Logarithmic, Relativistic, double_pendulum, pendulum};

fn fails<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    h: f64,
    dw: [f64; M],
) -> StepError
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let mut state = start;
    let error = integrator.step(&mut state, h, &dw).unwrap_err();
    let bits = |s: &State<[f64; N]>| {
        [s.q, s.p]
            .concat()
            .iter()
            .map(|x| x.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&state), bits(&start));
    assert_eq!(state.t.to_bits(), start.t.to_bits());
    error
}

#[test]
fn bad_input_is_the_right_error() {
    let two = Integrator::new(pendulum(), Gauss::<2>);
    let eight = Integrator::new(pendulum(), Gauss::<8>);
    for bad in [f64::NAN, f64::INFINITY] {
        let start = State::new([bad], [0.0]);
        let is_input = |e: &StepError| matches!(e, StepError::NonFiniteInput { .. });
        let errors = [fails(&two, start, 0.1, []), fails(&eight, start, 0.1, [])];
        assert!(errors.iter().all(is_input), "{errors:?}");
    }
    let start = State::new([1.0], [0.0]);
    assert!(matches!(
        fails(&eight, start, 0.0, []),
        StepError::StepSize { .. }
    ));
    let noisy = Integrator::new(double_pendulum(), Gauss::<4>);
    let start = State::new([1.0, 0.0], [0.0, 0.0]);
    let error = fails(&noisy, start, 0.1, [f64::NAN, 0.0]);
    assert!(
        matches!(error, StepError::NonFiniteInput { .. }),
        "{error:?}"
    );
}

#[test]
fn steps_stay_in_the_domain() {
    let start = State::new([0.5], [-0.2]);
    for h in [0.05, 0.2] {
        let mut ends = [start; 2];
        Integrator::new(Logarithmic, Gauss::<2>)
            .step(&mut ends[0], h, &[])
            .unwrap();
        Integrator::new(Logarithmic, Gauss::<4>)
            .step(&mut ends[1], h, &[])
            .unwrap();
        assert!((ends[0].q[0] - ends[1].q[0]).abs() < 1e-3, "{ends:?}");
    }
    let outside = State::new([-0.5], [0.0]);
    fails(&Integrator::new(Logarithmic, Gauss::<2>), outside, 0.1, []);
    fails(&Integrator::new(Logarithmic, Gauss::<4>), outside, 0.1, []);
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
