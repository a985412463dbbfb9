//! Observers see the inputs of the step that was made last.

use sve_models::assert_matches;
use sve_runtime::ensemble::Cause;
use sve_runtime::prelude::*;

use crate::inputs::{H, Motor, PATHS, STEPS, fed_back, motor, start};

/// The energies before and after a step, with its inputs.
type Ends = [f64; 2];

/// Returns the energies of the steps of a path; the first ones are those at its start.
fn energies(
    motor: &Integrator<Motor, Midpoint>,
    path: u64,
    states: impl Iterator<Item = Result<State<[f64; 2]>, StepError>>,
) -> Vec<Ends> {
    let energy = |step: u64, before: &State<[f64; 2]>, state: &State<[f64; 2]>| {
        let held = motor.holding(&fed_back(path, step, before));
        held.system().hamiltonian(state).unwrap()
    };
    let mut before = start();
    let mut all = vec![[energy(0, &before, &before); 2]];
    for (step, state) in (0..STEPS).zip(states) {
        let state = state.unwrap();
        all.push([&before, &state].map(|at| energy(step, &before, at)));
        before = state;
    }
    all
}

fn integral(energies: &[Ends]) -> f64 {
    let steps = energies[1..].iter();
    steps
        .map(|[before, after]| 0.5 * H * (before + after))
        .sum()
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
    let close = |name: &str, of: &dyn Fn(&[Ends]) -> f64| {
        for (k, mean) in summary[name].mean().iter().enumerate() {
            let expected = all.iter().map(|path| of(&path[..=5 * k])).sum::<f64>() / PATHS as f64;
            assert!((mean - expected).abs() < 1e-11, "{name}: {mean} {expected}");
        }
    };
    let last = |energies: &[Ends]| energies[energies.len() - 1][1];
    close("plain", &last);
    close("lanes", &last);
    close("weighted", &|energies| (-integral(energies)).exp());
    close("integral", &integral);
    close("maximum", &|energies| {
        let after = energies.iter().map(|[_, after]| *after);
        after.fold(f64::NEG_INFINITY, f64::max)
    });
    close("fold", &|energies| {
        energies.iter().map(|[_, after]| after).sum()
    });
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
        let at = |path: &Vec<Ends>| path[(5 * k).min(path.len() - 1)][1];
        let expected = all.iter().map(at).sum::<f64>() / PATHS as f64;
        assert!((mean - expected).abs() < 1e-9, "{mean} {expected}");
    }
}

/// The function of a passage sees the inputs of a step at both of its ends, as that of an event.
#[test]
fn passages_of_energies_are_events_of_the_paths() {
    // moves faster than it jumps with the inputs
    fn level(energy: f64, state: &State<[f64; 2]>) -> f64 {
        energy + 2.05 + 20.0 * (state.q[0] - 0.43)
    }
    let motor = Integrator::new(Motor { g: 2.0, sigma: 0.0 }, Midpoint);
    let summary = Ensemble::new(&motor)
        .inputs("fed back", fed_back)
        .paths(PATHS)
        .steps(H, STEPS)
        .start(start())
        .keep_final_states(true)
        .stop_at("level", |system, state| {
            system.hamiltonian(state).map(|energy| level(energy, state))
        })
        .run()
        .unwrap();
    assert_eq!(summary.failed(), 0);
    let mut stopped = 0;
    for (path, end) in summary.final_states() {
        let steps = motor.trajectory(start(), H, NoNoise);
        let steps = steps.inputs(|step, state| fed_back(path, step, state));
        let steps = steps
            .stop_at(|system, state| system.hamiltonian(state).map(|energy| level(energy, state)));
        let alone = steps.take(STEPS as usize).last().unwrap().unwrap();
        assert!(
            (alone.t - end.t).abs() < 1e-6,
            "{path}: {} {}",
            alone.t,
            end.t
        );
        stopped += u64::from(end.t < 0.5 + H * (STEPS as f64 - 0.5));
    }
    assert!(stopped > 10, "{stopped}");
}

/// The inputs of the first step are judged before an observer sees them.
#[test]
fn bad_inputs_of_the_first_step_are_the_cause_of_the_failure() {
    let motor = motor();
    let summary = Ensemble::new(&motor)
        .inputs("bad", |path, step, state| match (path, step) {
            (5, 0) => [f64::NAN, 0.0],
            (40, 0) => panic!("no table"),
            _ => fed_back(path, step, state),
        })
        .paths(PATHS)
        .steps(H, STEPS)
        .start(start())
        .weight(|system, state| system.hamiltonian(state))
        .observe_energy("H")
        .run()
        .unwrap();
    let of = |path| {
        summary
            .failures()
            .iter()
            .find(|failure| failure.path == path)
    };
    assert_eq!(summary.failed(), 2);
    assert_matches!(
        &of(5).unwrap().cause,
        Cause::Step(StepError::NonFiniteInput { what, .. }) if what == "u[0]"
    );
    assert_matches!(
        &of(40).unwrap().cause,
        Cause::Step(StepError::Inputs { step: 0, message, .. }) if message == "no table"
    );
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
