//! Steps that fail and are divided into shorter steps on the same path.

use sve_runtime::noise::{DyadicInterval, Halves};
use sve_runtime::prelude::*;

use sve_models::assert_matches;
use sve_models::models::Rotor;

const H: f64 = 0.5;
const STEPS: usize = 2000;

fn system() -> Integrator<Rotor, Midpoint> {
    Integrator::new(Rotor { s: 0.25 * 0.3 }, Midpoint)
}

fn start() -> State<[f64; 1]> {
    State::new([0.0], [2.0])
}

/// Without refinement the path ends at a step that has no solution. With refinement it continues,
/// with the same bits each time.
#[test]
fn a_path_goes_on_and_is_repeatable() {
    let midpoint = system();
    let plain = midpoint.trajectory(start(), H, Wiener::new(1));
    let error = plain.take(STEPS).find_map(Result::err).unwrap();
    assert_matches!(error, StepError::BranchLost { .. });

    let run = || {
        let mut path = midpoint.trajectory(start(), H, Wiener::new(1)).refine(20);
        let states: Vec<State<[f64; 1]>> = path.by_ref().take(STEPS).map(Result::unwrap).collect();
        (states, path.refinements())
    };
    let ((states, refinements), again) = (run(), run());
    assert_eq!((&states, refinements), (&again.0, again.1));
    let steps = refinements.steps;
    assert!(steps > 0 && steps < STEPS as u64 / 2, "{refinements:?}");
    assert!((1..=20).contains(&refinements.deepest));
    for (step, state) in (1..=STEPS).zip(&states) {
        assert_eq!(state.t, step as f64 * H);
    }
}

/// A refined step equals the shorter steps made by hand. The other steps are not divided.
#[test]
fn parts_are_those_of_the_bridge() {
    let midpoint = system();
    let noise = Wiener::new(1);
    let mut path = midpoint.trajectory(start(), H, noise).refine(1);
    let mut state = start();
    let mut refined = 0;
    for step in 0.. {
        let dw = noise.increment(step, 0, H);
        let before = state;
        if midpoint.step(&mut state, H, &[dw]).is_err() {
            refined += 1;
            let mut halves = [[0.0], [0.0]];
            let [left, right] = &mut halves;
            noise.halves_of(DyadicInterval::whole(step), H, &[dw], left, right);
            let mut halves = halves.iter();
            if halves.any(|dw| midpoint.step(&mut state, 0.5 * H, dw).is_err()) {
                // one level of refinement is not enough: the state is that before the step
                assert!(path.next().unwrap().is_err());
                let t = step as f64 * H;
                assert_eq!(path.state(), &State { t, ..before });
                break;
            }
        }
        state.t = (step + 1) as f64 * H;
        assert_eq!(path.next().unwrap().unwrap(), state);
        assert_eq!(path.refinements().steps, refined);
    }
    assert!(refined > 0);
}

/// If no step fails, refinement does not change the states.
#[test]
fn steps_that_succeed_are_left_alone() {
    let midpoint = system();
    let small = State::new([0.0], [0.1]);
    let plain = midpoint.trajectory(small, 0.01, Wiener::new(3)).take(1000);
    let mut path = midpoint.trajectory(small, 0.01, Wiener::new(3)).refine(8);
    for state in plain {
        assert_eq!(path.next().unwrap().unwrap(), state.unwrap());
    }
    assert_eq!(path.refinements(), sve_runtime::Refinements::default());
}
