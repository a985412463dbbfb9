//! Trajectories with inputs have the options of all trajectories: events, refinement, saved states,
//! checkpoints. The function of the inputs is called once a step.

use std::cell::Cell;

use sve_runtime::__private::{CompensatedSums, WithInputs};
use sve_runtime::Rule;
use sve_runtime::prelude::*;

use crate::inputs::Kicked;

/// A particle that is pushed, over a floor at q = 0.
struct Pushed;

#[variational(midpoint, stormer_verlet, gauss(4))]
impl Pushed {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + u * q
    }
}

/// A particle falls with the input −8 and bounces within the step: both parts of the step have the
/// same input.
#[test]
fn an_event_within_a_step_keeps_its_inputs() {
    let pushed = Integrator::new(Pushed, StormerVerlet);
    let calls = Cell::new(0);
    let path = pushed.trajectory(State::new([1.0], [0.0]), 0.4, NoNoise);
    let path = path.inputs(|step, state| {
        calls.set(calls.get() + 1);
        // another function of a state that has bounced
        if step == 1 && state.p[0] < 0.0 {
            -8.0
        } else {
            -8.0 - step as f64
        }
    });
    let mut path = path.change_at(|_, state| state.q[0], |_, state| state.p[0] = -state.p[0]);
    let first = path.next().unwrap().unwrap();
    assert!((first.q[0] - 0.36).abs() < 1e-14);
    let second = path.next().unwrap().unwrap();
    // the floor is hit at t = ½ with p = −4
    assert!((second.t - 0.8).abs() < 1e-15);
    assert!((second.q[0] - (4.0 * 0.3 - 4.0 * 0.09)).abs() < 1e-10);
    assert!((second.p[0] - (4.0 - 8.0 * 0.3)).abs() < 1e-10);
    assert_eq!(calls.get(), 2);
}

/// A function of an event sees the inputs, also at the start: with the input 1 the energy
/// ½p² − u q stays −1 on a path that begins at rest in q = 1, where p = t.
#[test]
fn functions_of_events_see_inputs() {
    let pushed = Integrator::new(Pushed, Midpoint);
    let path = pushed.trajectory(State::new([1.0], [0.0]), 0.5, NoNoise);
    let mut events = path
        .inputs(|_, _| 1.0)
        .crossings(|system, state| Ok(system.hamiltonian(state)? + 0.3 + state.p[0]));
    let event = events.next().unwrap().unwrap();
    assert!((event.t - 0.7).abs() < 1e-12, "{}", event.t);
}

/// A state within a step and the end of the step come from one call.
#[test]
fn states_within_a_step_hold_its_inputs() {
    let pushed = Integrator::new(Pushed, Midpoint);
    let calls = Cell::new(0);
    let path = pushed.trajectory(State::new([0.0], [0.0]), 1.0, NoNoise);
    let path = path.inputs(|step, _| {
        calls.set(calls.get() + 1);
        2.0 + step as f64
    });
    let saved: Vec<_> = path.at([0.5, 1.0, 1.5]).map(Result::unwrap).collect();
    let q: Vec<f64> = saved.iter().map(|state| state.q[0]).collect();
    for (q, exact) in q.iter().zip([0.25, 1.0, 1.0 + 1.0 + 0.375]) {
        assert!((q - exact).abs() < 1e-14, "{q} {exact}");
    }
    assert_eq!(calls.get(), 2);
}

/// A rotor whose step has no solution for large increments.
struct Rotor;

#[variational(midpoint)]
impl Rotor {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + (1.0 + u) * q.cos()
    }
    #[h1]
    fn jitter(&self, _q: f64, p: f64) -> f64 {
        0.1 * p.powi(4)
    }
}

/// The parts of a refined step hold the inputs of the step: with a constant input the path is that
/// of the system that holds it.
#[test]
fn refined_steps_hold_the_inputs() {
    let rotor = Integrator::new(Rotor, Midpoint);
    let start = State::new([0.0], [2.0]);
    let mut path = rotor
        .trajectory(start, 0.5, Wiener::new(1))
        .inputs(|_, _| 0.3)
        .refine(16);
    let held = rotor.holding(&0.3);
    let expected = held.trajectory(start, 0.5, Wiener::new(1)).refine(16);
    for expected in expected.take(1000) {
        let (state, expected) = (path.next().unwrap().unwrap(), expected.unwrap());
        assert!((state.q[0] - expected.q[0]).abs() < 1e-12 * state.q[0].abs().max(1.0));
    }
    assert!(path.refinements().steps > 0);
}

/// The gradient does not depend on the states that are kept, and the function of the inputs is
/// called once a step, though steps are made again.
#[test]
fn gradients_with_few_checkpoints_see_the_same_inputs() {
    let rotor = Integrator::new(Rotor, Midpoint);
    let start = State::new([0.4], [0.1]);
    let gradient = |checkpoints: Option<usize>| {
        let calls = Cell::new(0_u32);
        let noise = Wiener::new(5);
        let path = rotor.trajectory(start, 0.05, noise);
        let path = path.inputs(|step, state| {
            // the number of the call is an input
            calls.set(calls.get() + 1);
            0.01 * f64::from(calls.get()) + 0.1 * (step as f64).sin() - 0.2 * state.p[0]
        });
        let mut adjoint = path.adjoint(60);
        if let Some(states) = checkpoints {
            adjoint = adjoint.checkpoints(states);
        }
        let gradient = adjoint.gradient(|k, state| {
            (k % 20 == 0).then(|| state.q[0].sin() + state.parameter("u[0]") * state.p[0])
        });
        (gradient.unwrap(), calls.get())
    };
    let (all, calls) = gradient(None);
    assert_eq!((calls, all.inputs().len()), (60, 60));
    assert!(all.inputs().all(|by| by.len() == 1 && by[0] != 0.0));
    for states in [1, 2, 7] {
        let (few, calls) = gradient(Some(states));
        assert_eq!(calls, 60, "{states}");
        assert_eq!(few, all, "{states}");
    }
}

/// A smooth input limits the order: to 1 if it is taken at the starts of steps, to 2 in their
/// middles.
#[test]
fn sampled_inputs_have_the_order_of_their_place() {
    let pushed = Integrator::new(Pushed, Gauss::<4>);
    // v' = cos t from rest: q = 1 − cos t
    let error = |steps: u64, place: f64| {
        let h = 2.0 / steps as f64;
        let path = pushed.trajectory(State::new([0.0], [0.0]), h, NoNoise);
        let mut path = path.inputs(|k, _| ((k as f64 + place) * h).cos());
        let end = path.nth(steps as usize - 1).unwrap().unwrap();
        end.q[0] - (1.0 - f64::cos(2.0))
    };
    for (place, order) in [(0.0, 1.0), (0.5, 2.0)] {
        let slope = (error(100, place) / error(200, place)).log2();
        assert!((slope - order).abs() < 0.02, "{place}: {slope}");
    }
}

/// A table with as many entries as the path has steps is read to its end, and no further. A shorter
/// one ends the path with an error that names the step.
#[test]
fn a_table_ends_with_its_path() {
    let pushed = Integrator::new(Pushed, Midpoint);
    let table = [1.0, 2.0, 3.0];
    let path = || {
        let path = pushed.trajectory(State::new([0.0], [1.0]), 0.1, NoNoise);
        path.inputs(|k, _| table[k as usize])
    };
    assert_eq!(path().take(3).map(Result::unwrap).count(), 3);
    let mut longer = path();
    let error = longer.advance(5).unwrap_err();
    assert!(
        matches!(error, StepError::Inputs { step: 3, .. }),
        "{error}"
    );
    let text = error.to_string();
    assert!(text.contains("the len is 3 but the index is 3"), "{text}");
    assert_eq!(longer.step(), 3);
    assert!(longer.next().is_none());

    let kicked = Integrator::new(Kicked, Midpoint);
    let noise = Recorded::new(0.1, vec![[0.1], [-0.2], [0.3]]).unwrap();
    let path = kicked.trajectory(State::new([0.0], [1.0]), 0.1, noise);
    let path = path.inputs(|k, _| table[k as usize]);
    assert_eq!(path.map(Result::unwrap).count(), 3);
}

/// A loss sees at each state the input of the step before it, and at the present state, before
/// which there is none, that of the step behind it.
#[test]
fn a_loss_may_read_inputs() {
    let pushed = Integrator::new(Pushed, Midpoint);
    let path = || {
        let mut path = pushed
            .trajectory(State::new([0.4], [0.5]), 0.1, NoNoise)
            .inputs(|k, _| 1.0 + k as f64);
        // a gradient may begin behind the start
        assert!(path.next().unwrap().is_ok());
        path
    };
    let read = path().gradient(3, |k, state| {
        (k > 0).then(|| 10.0 * k as f64 * state.parameter("u[0]"))
    });
    let read = read.unwrap();
    assert_eq!(read.loss(), 10.0 * 2.0 + 20.0 * 3.0 + 30.0 * 4.0);
    let by_inputs: Vec<f64> = read.inputs().map(|u| u[0]).collect();
    assert_eq!(by_inputs, [10.0, 20.0, 30.0]);

    let at_start = path().gradient(0, |_, state| {
        Some(state.q[0] * state.q[0] + state.parameter("u[0]"))
    });
    let at_start = at_start.unwrap();
    // the next step, number 1, has the input 2
    let q = 0.4 + 0.1 * (0.5 + 0.05);
    assert!((at_start.loss() - (q * q + 2.0)).abs() < 1e-15);
    assert!((at_start.start().q[0] - 2.0 * q).abs() < 1e-15);
    assert_eq!(at_start.inputs().len(), 0);
}

/// A particle on a spring that is pushed at random.
struct Spring;

#[variational(midpoint, stormer_verlet, gauss(4))]
impl Spring {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q - 0.1 * q.powi(4) + u * q
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.3 * q
    }
}

/// A snapshot continues with the bits of the path, and with the numbers of its steps.
#[test]
fn paths_with_inputs_continue_from_snapshots() {
    fn check<'a, R>(spring: &'a Integrator<Spring, R>)
    where
        R: Copy + Rule<<Spring as WithInputs>::Held<'a>>,
        Integrator<<Spring as WithInputs>::Held<'a>, R>:
            CompensatedSums<System = <Spring as WithInputs>::Held<'a>> + Clone,
    {
        let inputs = |step: u64, state: &State<[f64; 1]>| (step as f64).cos() - 0.2 * state.p[0];
        let (start, noise) = (State::new([0.4], [0.1]), Wiener::new(3));
        let path = || spring.trajectory(start, 0.1, noise).inputs(inputs);
        for mut path in [path(), path().compensated()] {
            path.advance(7).unwrap();
            let snapshot = path.snapshot();
            let mut rest = spring.resume(snapshot, noise, inputs).unwrap();
            assert_eq!(rest.step(), 7);
            for _ in 0..20 {
                assert_eq!(rest.next(), path.next());
            }
            assert_eq!(rest.snapshot(), path.snapshot());
        }
    }
    check(&Integrator::new(Spring, Midpoint));
    check(&Integrator::new(Spring, StormerVerlet));
    check(&Integrator::new(Spring, Gauss::<4>));
}

/// Under a constant input the place is exact but for rounding errors, which compensation removes.
#[test]
fn paths_with_inputs_have_compensated_sums() {
    let pushed = Integrator::new(Pushed, StormerVerlet);
    let path = || {
        let path = pushed.trajectory(State::new([1.0], [0.3]), 1e-3, NoNoise);
        path.inputs(|_, _| 0.7)
    };
    let error = |end: &State<[f64; 1]>| (end.q[0] - (1.0 + 3.0 + 0.7 * 50.0)).abs();
    let plain = error(path().advance(10_000).unwrap());
    let compensated = error(path().compensated().advance(10_000).unwrap());
    assert!(
        compensated < 1e-14 && plain > 1e-13,
        "{compensated:e} {plain:e}"
    );
}
