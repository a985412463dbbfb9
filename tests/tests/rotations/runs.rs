//! Trajectories, snapshots, ensembles, checkpoints and studies of systems with rotations.

use sve_runtime::nalgebra::Quaternion;
use sve_runtime::prelude::*;
use sve_runtime::study::Study;

use crate::starts::{body, pair};
use crate::systems::{DRIVEN, Driven, FreeBody, HeavyTop, I, SYMMETRIC_TOP, TETHERED, TOP};

/// A trajectory is the repeated step, and continued from its stored form it has the same bits.
#[test]
fn a_stored_trajectory_continues_with_the_same_bits() {
    let integrator = Integrator::new(TETHERED, Midpoint);
    let mut path = integrator.trajectory(pair(), 0.05, Wiener::new(5));
    let mut state = pair();
    for step in 0..40 {
        let next = path.next().unwrap().unwrap();
        let dw = [0, 1].map(|process| Wiener::new(5).increment(step, process, 0.05));
        integrator.step(&mut state, 0.05, &dw).unwrap();
        assert_eq!((state.q, state.p), (next.q, next.p), "step {step}");
    }
    let text = serde_json::to_string(&path.snapshot()).unwrap();
    let snapshot = serde_json::from_str(&text).unwrap();
    let resumed = integrator.resume(snapshot, Wiener::new(5)).unwrap();
    for (a, b) in path.zip(resumed).take(40) {
        assert_eq!(a.unwrap(), b.unwrap());
    }
}

/// A body on a charged stick, near another charge.
struct Charged {
    m: f64,
    i: Vector3<f64>,
    stick: Vector3<f64>,
    s: f64,
}

#[variational(stormer_verlet)]
impl Charged {
    fn lagrangian(
        &self,
        q: Vector3<f64>,
        r: Rotation3<f64>,
        v: Vector3<f64>,
        w: Vector3<f64>,
    ) -> f64 {
        let stick: Vector3<f64> = self.stick;
        let charge = q + r * stick;
        0.5 * self.m * v.dot(&v)
            + 0.5 * w.dot(&self.i.component_mul(&w))
            + 1.0 / (charge.norm_squared() + 0.1).sqrt()
    }
    #[gamma]
    fn wind(&self, q: Vector3<f64>, r: Rotation3<f64>) -> [f64; 2] {
        let stick: Vector3<f64> = self.stick;
        [self.s * q.x, self.s * (r * stick).y]
    }
}

/// A trajectory by the rule of Störmer and Verlet carries what the torque at the end of a step has
/// in common with that at the start of the next. The matrix of the equations and that of the stored
/// quaternion differ by rounding errors, and so do trajectory and repeated steps. Continued from
/// its stored form the trajectory has the same bits.
#[test]
fn a_torque_is_carried() {
    let charged = Charged {
        m: 1.5,
        i: I,
        stick: Vector3::new(0.3, 0.2, 0.5),
        s: 0.3,
    };
    let integrator = Integrator::new(charged, StormerVerlet);
    assert!(integrator.plan().carried.arithmetic > 20);
    let mut path = integrator.trajectory(pair(), 0.05, Wiener::new(5));
    let mut state = pair();
    let mut differs = false;
    for step in 0..40 {
        let next = path.next().unwrap().unwrap();
        let dw = [0, 1].map(|process| Wiener::new(5).increment(step, process, 0.05));
        integrator.step(&mut state, 0.05, &dw).unwrap();
        let turned = state.q.1.coords - next.q.1.coords;
        let errors = [(state.p.0 - next.p.0).amax(), (state.p.1 - next.p.1).amax()];
        let error = errors.into_iter().fold(turned.amax(), f64::max);
        assert!(error < 1e-14, "step {step}: {error:e}");
        differs |= error > 0.0;
    }
    assert!(differs, "nothing was carried");
    let resumed = integrator.resume(path.snapshot(), Wiener::new(5)).unwrap();
    for (a, b) in path.zip(resumed).take(40) {
        assert_eq!(a.unwrap(), b.unwrap());
    }
}

/// The guess is accurate to second order in the step size: one of Newton's updates and the last one
/// are enough for a small step.
#[test]
fn a_small_step_of_a_body_takes_one_iteration() {
    let integrator = Integrator::new(FreeBody { i: I }, Midpoint);
    let prepared = integrator.prepare(0.01).unwrap();
    let mut state = body();
    for step in 0..200 {
        let iterations = integrator.newton_iterations(&prepared, &state, 0.01, &[]);
        assert_eq!(iterations, Some(1), "step {step}");
        integrator.step(&mut state, 0.01, &[]).unwrap();
    }
}

/// Stored as `[w, x, y, z]`.
#[test]
fn a_state_is_stored_with_its_quaternion() {
    let q = UnitQuaternion::new_unchecked(Quaternion::new(0.5, -0.5, 0.5, 0.5));
    let state = State::at(
        2.0,
        (Vector3::new(1.0, 2.0, 3.0), q),
        (Vector3::zeros(), Vector3::x()),
    );
    let text = serde_json::to_string(&state).unwrap();
    assert_eq!(
        text,
        r#"{"t":2.0,"q":[1.0,2.0,3.0,0.5,-0.5,0.5,0.5],"p":[0.0,0.0,0.0,1.0,0.0,0.0]}"#
    );
    let back: State<(Vector3<f64>, UnitQuaternion<f64>)> = serde_json::from_str(&text).unwrap();
    assert_eq!(back, state);
}

/// The paths of an ensemble are single trajectories, bit for bit, on any number of threads; so are
/// its final states.
#[test]
fn paths_of_an_ensemble_are_trajectories() {
    let integrator = Integrator::new(TOP, Midpoint);
    let run = |threads: usize| {
        Ensemble::new(&integrator)
            .start(body())
            .observe("height", |_, state| (state.q * Vector3::z()).z)
            .observe("energy", |system: &HeavyTop, state| {
                system.hamiltonian(state)
            })
            .paths(70)
            .seed(9)
            .steps(0.05, 40)
            .keep_final_states(true)
            .threads(threads)
            .run()
            .unwrap()
    };
    let [one, three] = [1, 3].map(run);
    let (a, b): (Vec<_>, Vec<_>) = (one.final_states().collect(), three.final_states().collect());
    assert!(a == b && a.len() == 70);
    for (path, last) in a {
        let noise = Wiener::new(9).path(path);
        let state = integrator.trajectory(body(), 0.05, noise).take(40).last();
        let state = state.unwrap().unwrap();
        assert_eq!(
            last.state::<UnitQuaternion<f64>>(),
            Some(state),
            "path {path}"
        );
    }
}

#[test]
fn a_composition_of_the_midpoint_rule_keeps_momenta_with_noise() {
    let system = SYMMETRIC_TOP;
    let integrator = Integrator::new(system, Composed::new(Midpoint, KahanLi8));
    let start = body();
    let before = system.vertical_momentum(&start);
    let path = integrator.trajectory(start, 0.05, Wiener::new(2)).take(500);
    let end = path.last().unwrap().unwrap();
    assert!((system.vertical_momentum(&end) - before).abs() < 1e-13);
    let tangent = integrator.tangent(&start, 0.05, &[0.1, -0.2]).unwrap();
    assert!(tangent.symplectic_defect() < 1e-13);
}

/// The errors of a study are distances of rotation matrices and momenta.
#[test]
fn a_study_finds_the_order() {
    let system = Driven { nu: 0.1, ..DRIVEN };
    let midpoint = Integrator::new(system, Midpoint);
    let fine = Integrator::new(system, Composed::new(Midpoint, KahanLi8));
    let report = Study::new("driven top")
        .start(body())
        .horizon(1.0)
        .step_counts([16, 32, 64, 128])
        .method("midpoint", &midpoint)
        .fine(&fine, 2)
        .repeats(0)
        .run()
        .unwrap();
    println!("{report}");
    let order = report.orders()[0].order.value;
    assert!((order - 2.0).abs() < 0.02, "{order}");
}

/// A checkpoint of an ensemble of bodies is continued with the same bits.
#[test]
fn an_ensemble_continues_from_its_checkpoint() {
    let integrator = Integrator::new(TETHERED, Midpoint);
    let file = std::env::temp_dir().join(format!("rotations-{}.checkpoint", std::process::id()));
    let ensemble = || {
        Ensemble::new(&integrator)
            .start(pair())
            .observe(
                "x",
                |_, state: &State<(Vector3<f64>, UnitQuaternion<f64>)>| state.q.0.x,
            )
            .paths(200)
            .steps(0.05, 20)
            .keep_final_states(true)
    };
    let whole = ensemble().run().unwrap();
    let every = std::time::Duration::ZERO;
    let stored = ensemble().checkpoint(&file, every).run().unwrap();
    let again = ensemble()
        .checkpoint(&file, every)
        .resume(true)
        .run()
        .unwrap();
    std::fs::remove_file(&file).unwrap();
    let states = |summary: &Summary| -> Vec<_> {
        let all = summary.final_states();
        all.map(|(path, last)| (path, last.q.to_vec(), last.p.to_vec()))
            .collect()
    };
    assert!(states(&whole) == states(&stored) && states(&whole) == states(&again));
    assert_eq!(states(&whole)[0].1.len(), 7);
    assert_eq!(states(&whole)[0].2.len(), 6);
}
