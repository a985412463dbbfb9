//! Scenes through integrators, compositions and trajectories.

use std::cell::Cell;

use sve_runtime::__private::AnySystem;
use sve_runtime::__private::scene::{Scene, Scenes};
use sve_runtime::Rule;
use sve_runtime::noise::NoiseError;
use sve_runtime::prelude::*;

use super::gathered::numbers;
use super::scenes::{Argon, Chain, Ring};

const CHAIN: Chain = Chain {
    beta: 0.7,
    mass: 1.5,
};

fn ring(n: usize) -> Ring {
    let away = |seed| numbers(n, seed).iter().map(|x| 2.0 + x).collect();
    Ring {
        k: away(1),
        mass: away(2),
        sigma: 0.1,
        s: away(3),
        next: (0..n as i64).map(|i| (i + 1) % n as i64).collect(),
    }
}

fn start(n: usize) -> State<Vec<f64>> {
    State::at(0.3, numbers(n, 4), numbers(n, 5))
}

/// Checks that a trajectory in blocks, one state by state, and single steps have the same bits.
fn check<S, R>(scene: &S, rule: R, n: usize, h: f64)
where
    S: AnySystem<Configuration = Vec<f64>, Kind = Scenes, Target = S> + Scene<Row = [f64; 1]>,
    R: Rule<S, Increments = [f64]> + Copy,
    for<'a> &'a S: AnySystem<Configuration = Vec<f64>, Kind = Scenes, Target = S, Stepped = S>,
{
    const STEPS: u64 = 150;
    let integrator = Integrator::new(scene, rule);
    let noise = Wiener::new(7);
    let mut in_blocks = integrator.trajectory(start(n), h, noise);
    let in_blocks = in_blocks.advance(STEPS).unwrap();
    let state_by_state = integrator.trajectory(start(n), h, noise);
    let state_by_state = state_by_state.take(STEPS as usize).last().unwrap();
    assert_eq!(*in_blocks, state_by_state.unwrap());

    let mut state = start(n);
    let mut dw = vec![0.0; scene.processes(n).unwrap()];
    for step in 0..STEPS {
        Noise::increments(&mut { noise }, step, h, &mut dw).unwrap();
        integrator.step(&mut state, h, &dw).unwrap();
        state.t = h.mul_add((step + 1) as f64, 0.3);
    }
    assert_eq!(*in_blocks, state);
}

#[test]
fn trajectories_in_blocks_have_the_bits_of_single_steps() {
    for n in [0, 1, 2, 30, 1300] {
        check(&CHAIN, StormerVerlet, n, 0.01);
        check(&CHAIN, InitialPoint, n, 0.01);
        check(&CHAIN, Composed::new(StormerVerlet, KahanLi8), n, 0.01);
        check(&CHAIN, Split::new(BlanesMoanRkn6), n, 0.01);
        check(&ring(n), StormerVerlet, n, 0.01);
        check(&ring(n), Endpoint, n, -0.01);
        check(&ring(n), Composed::new(StormerVerlet, KahanLi8), n, 0.01);
    }
}

#[test]
fn compositions_have_their_order() {
    let error = |steps: u32| {
        let h = 1.0 / f64::from(steps);
        let integrator = Integrator::new(CHAIN, Composed::new(StormerVerlet, KahanLi8));
        let mut path = integrator.trajectory(start(20), h, NoNoise);
        let energy = CHAIN.hamiltonian(path.state()).unwrap();
        CHAIN
            .hamiltonian(path.advance(steps.into()).unwrap())
            .unwrap()
            - energy
    };
    let [coarse, fine] = [4, 8].map(error);
    let order = (coarse / fine).abs().log2();
    assert!(order > 6.5, "{order} from {coarse:e} and {fine:e}");
}

#[test]
fn energies_and_velocities() {
    let state = State::new(vec![0.0, 1.0], vec![3.0, 1.5]);
    assert_eq!(CHAIN.velocity(&state).unwrap(), [2.0, 1.0]);
    let potential = 0.5 + 0.25 * 0.7;
    let kinetic = 0.5 * 1.5 * (4.0 + 1.0);
    assert!((CHAIN.hamiltonian(&state).unwrap() - (kinetic + potential)).abs() < 1e-15);
    assert_eq!(CHAIN.temperature(&state).unwrap(), kinetic);
    let short = State::new(vec![0.0, 1.0], vec![3.0]);
    assert!(matches!(
        CHAIN.velocity(&short),
        Err(StepError::Length { .. })
    ));
}

#[test]
fn a_failing_step_ends_a_trajectory_before_it() {
    fn check<S>(scene: &S)
    where
        S: AnySystem<Configuration = Vec<f64>, Kind = Scenes, Target = S> + Scene<Row = [f64; 1]>,
        StormerVerlet: Rule<S, Increments = [f64]>,
        for<'a> &'a S: AnySystem<Configuration = Vec<f64>, Kind = Scenes, Target = S, Stepped = S>,
    {
        let integrator = Integrator::new(scene, StormerVerlet);
        let path = || integrator.trajectory(start(40), 0.05, Wiener::new(5));
        let mut in_blocks = path();
        let error = in_blocks.advance(100_000).unwrap_err();
        let made = in_blocks.step();
        assert!(made > 0 && in_blocks.next().is_none());
        let mut again = path();
        for _ in 0..made {
            again.next().unwrap().unwrap();
        }
        assert_eq!(in_blocks.state(), again.state());
        assert_eq!(again.next().unwrap().unwrap_err(), error);
        assert!(path().nth(100_000).is_none());
        let text = error.to_string();
        assert!(text.contains("that is not finite"), "{text}");
    }
    // the bonds are too stiff for this step, and so are the springs
    check(&Chain {
        beta: 500.0,
        mass: 1.0,
    });
    check(&Ring {
        k: vec![1e5; 40],
        ..ring(40)
    });
}

#[test]
fn inputs_that_do_not_fit() {
    let ring = Integrator::new(ring(3), StormerVerlet);
    let good = start(3);
    let text = |change: &dyn Fn(&mut State<Vec<f64>>), dw: &[f64]| {
        let mut state = good.clone();
        change(&mut state);
        let before = format!("{state:?}");
        let error = ring.step(&mut state, 0.1, dw).unwrap_err();
        assert_eq!(format!("{state:?}"), before);
        error.to_string()
    };
    let dw = [0.0; 4];
    assert_eq!(
        text(&|state| state.p.truncate(2), &dw),
        "p has 2 entries at t = 0.3, and 3 are needed"
    );
    assert_eq!(
        text(&|_| {}, &dw[1..]),
        "dw has 3 entries at t = 0.3, and 4 are needed"
    );
    let nan = |what: &str| format!("{what} is NaN at t = 0.3: a step needs finite numbers");
    assert!(text(&|state| state.q[2] = f64::NAN, &dw).starts_with(&nan("q[2]")));
    assert!(text(&|state| state.p[0] = f64::NAN, &dw).starts_with(&nan("p[0]")));
    assert!(text(&|_| {}, &[0.0, f64::NAN, 0.0, 0.0]).starts_with(&nan("dw[1]")));
    assert!(text(&|state| state.t = f64::INFINITY, &dw).starts_with("t is inf"));
    assert!(text(&|state| state.t = 1e300, &dw).contains("does not change the time"));
    assert!(ring.step(&mut good.clone(), 0.0, &dw).is_err());
    // fields for three sites only
    assert_eq!(
        text(&|state| *state = start(5), &dw),
        "`self.next[i]` in `lagrangian` (i = 3) has the index 3 at t = 0.3, and the length is 3: let the loop run over \
         indices that exist, put an `if` around this term, or look at the fields that give the index"
    );
}

#[test]
fn other_lengths_and_other_fields_make_other_tables() {
    let mut integrator = Integrator::new(ring(40), Endpoint);
    let fresh = |ring: Ring, n| {
        let mut state = start(n);
        let made = Integrator::new(ring, Endpoint).step(&mut state, 0.1, &vec![0.1; n + 1]);
        made.map(|()| state)
    };
    let step = |integrator: &Integrator<Ring, Endpoint>, n| {
        let mut state = start(n);
        let made = integrator.step(&mut state, 0.1, &vec![0.1; n + 1]);
        made.map(|()| state)
    };
    for n in [40, 41, 40] {
        assert_eq!(step(&integrator, n), fresh(ring(40), n));
    }
    integrator.system_mut().next.reverse();
    integrator.system_mut().mass[3] = 9.0;
    let mut changed = ring(40);
    changed.next.reverse();
    changed.mass[3] = 9.0;
    assert_eq!(step(&integrator, 40), fresh(changed, 40));
    let layout = integrator.layout(&start(40), 0.1).unwrap();
    assert_eq!(layout.sites, 40);
}

/// The time goes on over an end of the tables of increments.
/// A list is made anew between two blocks of a trajectory, and the noise goes on.
#[test]
fn a_trajectory_goes_on_with_another_list() {
    const STEPS: [u64; 2] = [7, 8];
    let (n, h, noise) = (30, 0.01, Wiener::new(7));
    let mut integrator = Integrator::new(ring(n), StormerVerlet);
    let mut path = integrator.trajectory(start(n), h, noise);
    path.advance(STEPS[0]).unwrap();
    let snapshot = path.snapshot();
    integrator.system_mut().next.rotate_left(3);
    let mut path = integrator.resume(snapshot, noise).unwrap();
    let in_blocks = path.advance(STEPS[1]).unwrap();

    let mut integrator = Integrator::new(ring(n), StormerVerlet);
    let mut dw = vec![0.0; integrator.system().processes(n).unwrap()];
    let mut state = start(n);
    for step in 0..STEPS[0] + STEPS[1] {
        if step == STEPS[0] {
            integrator.system_mut().next.rotate_left(3);
        }
        Noise::increments(&mut { noise }, step, h, &mut dw).unwrap();
        integrator.step(&mut state, h, &dw).unwrap();
        state.t = h.mul_add((step + 1) as f64, 0.3);
    }
    assert_eq!(*in_blocks, state);
}

#[test]
fn a_recorded_path_ends() {
    let recorded = Recorded::record(Wiener::new(2), 0.1, 31, 20).unwrap();
    let ring = Integrator::new(ring(30), Endpoint);
    let mut path = ring.trajectory(start(30), 0.1, &recorded);
    let error = path.advance(25).unwrap_err();
    let StepError::Noise { source, .. } = error else {
        panic!("{error}");
    };
    assert!(matches!(source, NoiseError::Exhausted { .. }));
    assert_eq!(path.step(), 20);
    let expected = ring.trajectory(start(30), 0.1, Wiener::new(2)).nth(19);
    assert_eq!(path.state(), &expected.unwrap().unwrap());
}

#[test]
fn bodies_are_vectors() {
    let n = 27;
    let mut argon = Argon {
        start: vec![0],
        list: Vec::new(),
        cut2: 100.0,
        mass: 1.0,
    };
    for i in 0..n {
        argon.list.extend(i + 1..n);
        argon.start.push(argon.list.len());
    }
    let site = |i: usize| Vector3::new(i % 3, i / 3 % 3, i / 9).map(|x| 1.12 * x as f64);
    let state = State::new((0..n).map(site).collect(), vec![Vector3::zeros(); n]);
    let energy = argon.hamiltonian(&state).unwrap();
    let integrator = Integrator::new(&argon, StormerVerlet);
    let mut path = integrator.trajectory(state, 0.001, NoNoise);
    let worst = Cell::new(0.0_f64);
    for _ in 0..20 {
        let state = path.advance(50).unwrap();
        let error = argon.hamiltonian(state).unwrap() - energy;
        worst.set(worst.get().max(error.abs()));
        let total: Vector3<f64> = state.p.iter().sum();
        assert!(total.norm() < 1e-12);
    }
    assert!(worst.get() < 1e-3, "{}", worst.get());
}
