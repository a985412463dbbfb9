//! Refined paths and steps that are refined where they fail, against trajectories on the same
//! paths.

use sve_models::checks::{assert_close, assert_relative};
use sve_models::models::{Kicked, Rotor};
use sve_runtime::prelude::*;

/// For a large ΔW a step has no solution.
const ROTOR: Rotor = Rotor { s: 0.1 };

const PATHS: u64 = 100;

/// The final momenta of particles on the same paths, in steps of 0.1 / 2^depth.
fn momenta(depth: u32) -> Vec<f64> {
    let method = Integrator::new(Kicked { sigma: 1.0 }, Midpoint);
    let parts = 1_u64 << depth;
    let summary = Ensemble::new(&method)
        .paths(PATHS)
        .noise(Wiener::new(7).refine(depth).unwrap())
        .steps(0.1 / parts as f64, 50 * parts)
        .start(State::new([0.0], [0.0]))
        .keep_final_states(true)
        .run()
        .unwrap();
    summary
        .final_states()
        .map(|(_, state)| state.p[0])
        .collect()
}

#[test]
fn refined_paths_are_the_same_paths() {
    let whole = momenta(0);
    for depth in [1, 3, 6] {
        assert_close(&momenta(depth), &whole, 1e-12, depth);
    }
}

/// On the same path a smaller step is nearer to the limit: the difference of two step sizes is of
/// the first order of h, not of the size of a path.
#[test]
fn differences_of_levels_are_small() {
    let method = Integrator::new(ROTOR, Midpoint);
    let run = |depth| {
        let parts = 1_u64 << depth;
        Ensemble::new(&method)
            .paths(PATHS)
            .noise(Wiener::new(3).refine(depth).unwrap())
            .steps(0.02 / parts as f64, 50 * parts)
            .start(State::new([0.0], [0.5]))
            .keep_final_states(true)
            .run()
            .unwrap()
    };
    let levels = [run(0), run(2), run(4)];
    let distance = |a: &Summary, b: &Summary| {
        let pairs = a.final_states().zip(b.final_states());
        let squares = pairs.map(|((_, a), (_, b))| (a.q[0] - b.q[0]).powi(2));
        (squares.sum::<f64>() / PATHS as f64).sqrt()
    };
    let [coarse, fine] = [0, 1].map(|k| distance(&levels[k], &levels[k + 1]));
    assert!(coarse < 0.02 && fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn steps_that_fail_are_refined_as_in_trajectories() {
    let method = Integrator::new(ROTOR, Midpoint);
    let ensemble = |depth| {
        Ensemble::new(&method)
            .paths(PATHS)
            .seed(1)
            .steps(0.5, 12)
            .start(State::new([0.0], [2.0]))
            .keep_final_states(true)
            .refine(depth)
    };
    let plain = ensemble(0).run().unwrap();
    assert!(plain.failed() > 0 && plain.refined_steps() == 0);
    let refined = ensemble(16).run().unwrap();
    assert_eq!(refined.failed(), 0);
    let mut steps = 0;
    for (path, state) in refined.final_states() {
        let noise = Wiener::new(1).path(path);
        let mut trajectory = method
            .trajectory(State::new([0.0], [2.0]), 0.5, noise)
            .refine(16);
        let expected = trajectory.nth(11).unwrap().unwrap();
        steps += trajectory.refinements().steps;
        // rounding grows fast along a path with such noise
        let found = [state.q[0], state.p[0]];
        assert_relative(&found, &[expected.q[0], expected.p[0]], 1e-4, path);
    }
    assert_eq!(refined.refined_steps(), steps);
    let again = ensemble(16).threads(3).run().unwrap();
    assert_eq!(again, refined);
    let error = ensemble(16).noise(ThreePoint::new(1)).run().unwrap_err();
    let within = EnsembleError::NoiseWithinSteps { setting: "refine" };
    assert_eq!(error.to_string(), within.to_string());
}

/// A stop within refined paths is that of a trajectory on the refined path.
#[test]
fn refined_paths_stop_where_trajectories_stop() {
    let method = Integrator::new(ROTOR, Midpoint);
    let h = 0.05 / 8.0;
    let fine = || Wiener::new(9).path(0);
    let summary = Ensemble::new(&method)
        .paths(20)
        .noise(fine().refine(3).unwrap())
        .steps(h, 800)
        .start(State::new([0.0], [0.5]))
        .stop_at("right", |_, state| state.q[0] - 0.4)
        .keep_final_states(true)
        .run()
        .unwrap();
    assert!(summary.passage("right").unwrap().passed()[1] > 10);
    for (path, state) in summary.final_states() {
        let noise = Wiener::new(9).path(path).refine(3).unwrap();
        let trajectory = method.trajectory(State::new([0.0], [0.5]), h, noise);
        let mut stopped = trajectory.stop_at(|_, state| state.q[0] - 0.4);
        let end = stopped.by_ref().take(800).last().unwrap().unwrap();
        assert!((state.t - end.t).abs() < h, "{path}: {} {}", state.t, end.t);
    }
}

/// The search for a zero refines the parts of a step that have no solution, as the path itself
/// does: else a path that crosses in such a step would fail.
#[test]
fn passages_within_refined_steps_are_found() {
    let method = Integrator::new(ROTOR, Midpoint);
    let ensemble = || {
        Ensemble::new(&method)
            .paths(1000)
            .seed(1)
            .steps(0.5, 12)
            .start(State::new([0.0], [2.0]))
            .refine(16)
    };
    let side = |q: f64| q < 1.0;
    let free = ensemble()
        .fold(
            "crossed",
            |_, s| (side(s.q[0]), false),
            |(last, crossed), _, s| *crossed |= *last != side(s.q[0]),
            |(_, crossed)| f64::from(u8::from(*crossed)),
        )
        .run()
        .unwrap();
    let (failed, refined) = (free.failed(), free.refined_steps());
    assert!(failed == 0 && refined > 150, "{failed} {refined}");
    let crossed = 1000.0 * free["crossed"].mean()[1];
    let stopped = ensemble()
        .stop_at("wall", |_, s| s.q[0] - 1.0)
        .run()
        .unwrap();
    assert_eq!(stopped.failed(), 0);
    let passed = stopped.passage("wall").unwrap().passed()[1];
    assert!(
        passed > 300 && (passed as f64 - crossed).abs() < 0.5,
        "{passed} {crossed}"
    );
}
