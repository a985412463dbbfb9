//! Midpoint steps of scenes that fail, and solutions that are far from the first guess.

use sve_runtime::prelude::*;

use crate::bounds::Springs;
use crate::common::spread;
use crate::midpoint::pendula;

/// The reason of a failed step is named, and the state is unchanged, in the midst of a block of
/// steps too.
#[test]
fn failed_steps_leave_the_state() {
    let n = 100_000;
    let mut start = State::new(spread(n, 1), spread(n, 2));
    start.q[70_123] = f64::NAN;
    let mut state = start.clone();
    let integrator = Integrator::new(pendula(n, 0.7, 0.5), Midpoint);
    let error = integrator.step(&mut state, 0.1, &[]).expect_err("an error");
    assert!(error.to_string().starts_with("q[70123] is NaN"), "{error}");
    assert_eq!(state.p, start.p);
    assert!(
        state
            .q
            .iter()
            .zip(&start.q)
            .all(|(x, y)| x.to_bits() == y.to_bits())
    );

    // an inverted oscillator, whose displacements grow until the numbers end
    let integrator = Integrator::new(Springs { k: 0.0, own: -1.0 }, Midpoint);
    let start = State::new(vec![1.0; 3], vec![1.0; 3]);
    let mut path = integrator.trajectory(start.clone(), 1.0, NoNoise);
    let error = path.advance(2000).map(|_| ()).expect_err("an overflow");
    let (made, reached) = (path.step(), path.state().clone());
    assert!(made > 600, "{made}");
    let mut state = start;
    for _ in 0..made {
        integrator.step(&mut state, 1.0, &[]).expect("a step");
    }
    assert_eq!(reached, state);
    let again = integrator.step(&mut state, 1.0, &[]).expect_err("the same");
    assert_eq!(again, error);
    assert_eq!(state, reached);
    assert!(
        matches!(error, StepError::NonFiniteCoordinate { .. }),
        "{error}"
    );
    for (system, n) in [
        (Springs { k: 1.0, own: 1.0 }, 0),
        (Springs { k: 1.0, own: 1.0 }, 1),
    ] {
        let mut state = State::new(vec![0.5; n], vec![1.0; n]);
        Integrator::new(system, Midpoint)
            .step(&mut state, 0.1, &[])
            .expect("a step");
    }
}

/// Sites of unit mass that fall on an elastic floor.
struct Floor {
    gravity: f64,
    stiffness: f64,
}

#[variational(midpoint)]
impl Floor {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i] - self.gravity * q[i];
            if q[i] < 0.0 {
                l -= 0.5 * self.stiffness * q[i] * q[i];
            }
        }
        l
    }
}

/// Sites of unit mass that are drawn to 0 by a constant force, which jumps there.
struct Kink;

#[variational(midpoint)]
impl Kink {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i];
            if q[i] > 0.0 {
                l -= q[i];
            } else {
                l += q[i];
            }
        }
        l
    }
}

/// The first boxes are points, or do not reach the floor: the solution is found all the same, or
/// there is none.
#[test]
fn solutions_far_from_the_first_boxes_are_found() {
    let mut state = State::new(vec![1.0], vec![0.0]);
    let integrator = Integrator::new(pendula(1, 0.0, 1.0), Midpoint);
    integrator.step(&mut state, 0.5, &[]).expect("a step");
    let mut d = 0.0;
    for _ in 0..100 {
        d = -0.125 * f64::sin(1.0 + 0.5 * d);
    }
    assert!((state.q[0] - 1.0 - d).abs() < 2e-16, "{} {d}", state.q[0]);
    assert!((state.p[0] - 4.0 * d).abs() < 1e-15, "{} {d}", state.p[0]);

    let floor = Floor {
        gravity: 10.0,
        stiffness: 4.0,
    };
    let mut state = State::new(vec![1.0; 3], vec![0.0; 3]);
    Integrator::new(floor, Midpoint)
        .step(&mut state, 1.0, &[])
        .expect("a step");
    for (q, p) in state.q.iter().zip(&state.p) {
        assert!(
            (q + 2.5).abs() < 1e-14 && (p + 7.0).abs() < 1e-14,
            "{q} {p}"
        );
    }

    let start = State::new(vec![0.1], vec![0.0]);
    let mut state = start.clone();
    let error = Integrator::new(Kink, Midpoint).step(&mut state, 1.0, &[]);
    assert!(
        matches!(error, Err(StepError::NotContracting { .. })),
        "{error:?}"
    );
    assert_eq!(state, start);
}

/// A step that failed leaves nothing behind for later steps.
#[test]
fn steps_after_a_failed_one_are_those_without_it() {
    struct Pushed;
    #[variational(midpoint)]
    impl Pushed {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            (0..q.len())
                .map(|i| 0.5 * v[i] * v[i] - 0.25 * q[i].powi(4))
                .sum()
        }
        #[gamma]
        fn push(&self, q: &[f64]) -> f64 {
            q.iter().sum()
        }
    }
    let start = State::new(spread(40, 1), spread(40, 2));
    let integrator = Integrator::new(Pushed, Midpoint);
    let mut state = start.clone();
    for dw in [f64::INFINITY, f64::NAN, 1e308] {
        integrator
            .step(&mut state, 0.1, &[dw])
            .expect_err("an error");
        assert_eq!(state, start);
    }
    integrator.step(&mut state, 0.1, &[0.2]).expect("a step");
    let mut expected = start;
    Integrator::new(Pushed, Midpoint)
        .step(&mut expected, 0.1, &[0.2])
        .expect("a step");
    assert_eq!(state, expected);
}
