//! Observers see the inputs of the step that was made last.

use sve_runtime::prelude::*;

use crate::inputs::{H, Motor, PATHS, STEPS, fed_back, motor, start};

/// Returns the energies at the start of a path and at its states, with the inputs of each step.
fn energies(
    motor: &Integrator<Motor, Midpoint>,
    path: u64,
    states: impl Iterator<Item = Result<State<[f64; 2]>, StepError>>,
) -> Vec<f64> {
    let energy = |step: u64, before: &State<[f64; 2]>, state: &State<[f64; 2]>| {
        let held = motor.holding(&fed_back(path, step, before));
        held.system().hamiltonian(state).unwrap()
    };
    let mut before = start();
    let mut all = vec![energy(0, &before, &before)];
    for (step, state) in (0..STEPS).zip(states) {
        let state = state.unwrap();
        all.push(energy(step, &before, &state));
        before = state;
    }
    all
}

fn integral(energies: &[f64]) -> f64 {
    energies.windows(2).map(|w| 0.5 * H * (w[0] + w[1])).sum()
}

#[test]
fn all_observers_see_the_inputs_of_the_last_step() {
    let motor = motor();
    let summary = Ensemble::new(&motor)
        .inputs("fed back", fed_back)
        .paths(PATHS)
        .seed(3)
        .steps(H, STEPS)
        .every(5)
        .start(start())
        .weight(|system, state| system.hamiltonian(state))
        .observe("plain", |system, state| system.hamiltonian(state))
        .observe_energy("lanes")
        .terminal("weighted", |_, _| 1.0)
        .integral("integral", |system, state| system.hamiltonian(state))
        .maximum("maximum", |system, state| system.hamiltonian(state))
        .fold(
            "fold",
            |system, state| system.hamiltonian(state).unwrap(),
            |sum, system, state| *sum += system.hamiltonian(state).unwrap(),
            |sum| *sum,
        )
        .run()
        .unwrap();
    assert_eq!(summary.failed(), 0);
    let all: Vec<_> = (0..PATHS)
        .map(|path| {
            let steps = motor.trajectory(start(), H, Wiener::new(3).path(path));
            let steps = steps.inputs(|step, state| fed_back(path, step, state));
            energies(&motor, path, steps)
        })
        .collect();
    let close = |name: &str, of: &dyn Fn(&[f64]) -> f64| {
        for (k, mean) in summary[name].mean().iter().enumerate() {
            let expected = all.iter().map(|path| of(&path[..=5 * k])).sum::<f64>() / PATHS as f64;
            assert!((mean - expected).abs() < 1e-11, "{name}: {mean} {expected}");
        }
    };
    let last = |energies: &[f64]| energies[energies.len() - 1];
    close("plain", &last);
    close("lanes", &last);
    close("weighted", &|energies| (-integral(energies)).exp());
    close("integral", &integral);
    close("maximum", &|energies| {
        energies.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    });
    close("fold", &|energies| energies.iter().sum());
}

/// Paths stop within a step, and paths that go on are packed into other lanes: each energy is that
/// with the inputs of its own path, at a stop with the inputs of the step in which the path
/// stopped.
#[test]
fn paths_that_stop_and_move_keep_their_inputs() {
    // blocks of one thread share their lanes
    const PATHS: u64 = 200;
    let motor = Integrator::new(Motor { g: 2.0, sigma: 0.0 }, Midpoint);
    let is_out = |state: &State<[f64; 2]>| state.q[0] - 0.43;
    let summary = Ensemble::new(&motor)
        .inputs("fed back", fed_back)
        .paths(PATHS)
        .threads(1)
        .steps(H, STEPS)
        .every(5)
        .start(start())
        .observe("H", |system, state| system.hamiltonian(state))
        .stop_at("out", move |_, state| is_out(state))
        .run()
        .unwrap();
    assert_eq!(summary.failed(), 0);
    let mut stopped = 0;
    let all: Vec<_> = (0..PATHS)
        .map(|path| {
            let steps = motor.trajectory(start(), H, NoNoise);
            let steps = steps.inputs(|step, state| fed_back(path, step, state));
            let steps = steps.stop_at(move |_, state| is_out(state));
            let energies = energies(&motor, path, steps);
            stopped += u64::from(energies.len() <= STEPS as usize);
            energies
        })
        .collect();
    assert!((50..150).contains(&stopped), "{stopped}");
    for (k, mean) in summary["H"].mean().iter().enumerate() {
        let at = |path: &Vec<f64>| path[(5 * k).min(path.len() - 1)];
        let expected = all.iter().map(at).sum::<f64>() / PATHS as f64;
        assert!((mean - expected).abs() < 1e-9, "{mean} {expected}");
    }
}

/// Functions of the inputs are not the same in all runs.
#[test]
fn fingerprints_see_the_inputs_of_observers() {
    let motor = motor();
    let run = |factor: f64, shard: u64| {
        Ensemble::new(&motor)
            .inputs("fed back", fed_back)
            .paths(PATHS)
            .steps(H, STEPS)
            .start(start())
            .observe("H", move |system, state| {
                system.hamiltonian(state).map(|energy| factor * energy)
            })
            .shard(shard, 2)
            .run()
            .unwrap()
    };
    run(1.0, 0).merge(run(1.0, 1)).unwrap();
    assert!(run(1.0, 0).merge(run(2.0, 1)).is_err());
}
