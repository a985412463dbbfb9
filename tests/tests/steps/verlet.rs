//! The rule of Störmer and Verlet: closed form, order, what trajectories carry. Symmetry and
//! symplecticity are those of all rules, in `backwards` and `tangent`.

use sve_models::assert_matches;
use sve_models::checks::assert_close;
use sve_models::oracle::{double_pendulum, driven, pendulum};
use sve_models::random::Random;
use sve_models::stepper::Stepper;
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Variational, baseline};

/// A particle in a double well whose kicks depend on its place.
pub(crate) struct DoubleWell {
    pub(crate) s: f64,
}

#[variational(stormer_verlet)]
impl DoubleWell {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.25 * (q * q - 1.0).powi(2)
    }

    #[gamma]
    fn kicks(&self, q: f64) -> f64 {
        self.s * (2.0 * q).sin()
    }
}

#[test]
fn a_separable_step_is_kick_drift_kick() {
    let well = Integrator::new(DoubleWell { s: 0.5 }, StormerVerlet);
    assert_eq!(well.plan().kind(), BlockKind::Explicit);
    assert_eq!(well.plan().deterministic_order, 2);
    let mut random = Random::new(8);
    for _ in 0..1000 {
        let [q, p, dw] = random.array(-1.5, 1.5);
        let mut state = State::new([q], [p]);
        well.step(&mut state, 0.1, &[dw]).unwrap();
        let kick = |q: f64| 0.05 * (q - q * q * q) + 0.5 * (2.0 * q).cos() * dw;
        let middle = p + kick(q);
        let end = q + 0.1 * middle;
        let expected = [end, middle + kick(end)];
        assert_close(&[state.q[0], state.p[0]], &expected, 4e-15, "DoubleWell");
    }
}

#[test]
fn energy_errors_decrease_with_the_square_of_the_step() {
    let integrator = Integrator::new(pendulum(), StormerVerlet);
    let start = State::new([1.2], [0.4]);
    let end = |steps: u32| integrator.after(start, 1.0 / f64::from(steps), &[], steps);
    let [a, b, c] = [64, 128, 256].map(end);
    let order = ((a.q[0] - b.q[0]) / (b.q[0] - c.q[0])).log2();
    assert!((order - 2.0).abs() < 0.02, "{order}");
}

/// Follows a trajectory and repeated steps. Both have the same bits: what the trajectory carries
/// changes none.
fn carries<S, R, const N: usize, const M: usize>(method: &Integrator<S, R>, start: &State<[f64; N]>)
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let (h, mut state) = (0.05, *start);
    let mut path = method.trajectory(*start, h, Wiener::new(3));
    let mut noise = Wiener::new(3);
    for step in 0..50 {
        let mut dw = [0.0; M];
        noise.increments(step, h, &mut dw).unwrap();
        method.step(&mut state, h, &dw).unwrap();
        let along = path.next().unwrap().unwrap();
        assert_eq!((along.q, along.p), (state.q, state.p), "step {step}");
        state.t = along.t;
        if step == 20 {
            let snapshot = path.snapshot();
            path = method.resume(snapshot, Wiener::new(3)).unwrap();
        }
    }
}

#[test]
fn the_force_at_the_end_of_a_step_is_that_at_the_start_of_the_next() {
    let (angles, start) = (pendulum(), State::new([0.8], [0.3]));
    let verlet = Integrator::new(&angles, StormerVerlet);
    // sine and cosine, for the force and the noise
    assert_eq!(verlet.plan().carried.transcendental, 1);
    assert_eq!(verlet.plan().step.transcendental, 2);
    carries(&verlet, &start);
    let composed = Composed::new(StormerVerlet, KahanLi8);
    carries(&Integrator::new(&angles, composed), &start);
    let double = Integrator::new(double_pendulum(), StormerVerlet);
    carries(&double, &State::new([0.8, -0.2], [0.3, 0.1]));
    // the force depends on time: nothing of it is carried
    let driven = Integrator::new(driven(), StormerVerlet);
    carries(&driven, &start);
    let well = Integrator::new(DoubleWell { s: 0.4 }, StormerVerlet);
    assert!(well.plan().carried.transcendental > 0);
    carries(&well, &start);
}

#[test]
fn what_a_trajectory_carries_is_part_of_its_snapshot() {
    let well = Integrator::new(DoubleWell { s: 0.4 }, StormerVerlet);
    let mut path = well.trajectory(State::new([0.8], [0.3]), 0.05, Wiener::new(3));
    let before = path.snapshot();
    path.next().unwrap().unwrap();
    let after = path.snapshot();
    let text = serde_json::to_string(&after).unwrap();
    let read: Snapshot<State<[f64; 1]>> = serde_json::from_str(&text).unwrap();
    assert_eq!(read, after);
    assert_ne!(
        serde_json::to_value(&before).unwrap()["memory"],
        serde_json::to_value(&after).unwrap()["memory"]
    );
    // another method does not take it
    let heun = baseline::Heun::new(DoubleWell { s: 0.4 });
    let resumed = heun.resume(after, Wiener::new(3));
    let error = resumed.map(|_| ()).unwrap_err();
    assert_matches!(error, StepError::OtherSteps { .. });
}

/// A particle that a logarithm keeps from the origin.
struct Repelled;

#[variational(stormer_verlet)]
impl Repelled {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 0.3 * q.ln() - 0.5 * q * q + 0.1 * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.3 * q
    }
}

#[test]
fn a_refined_step_carries_nothing_over() {
    let (method, h) = (Integrator::new(Repelled, StormerVerlet), 0.75);
    let mut path = method
        .trajectory(State::new([1.0], [0.0]), h, Wiener::new(5))
        .refine(20);
    let mut refined = 0;
    // an explicit step comes too near to the singularity in the end
    loop {
        let before = path.refinements().steps;
        let Some(Ok(state)) = path.next() else { break };
        if path.refinements().steps > before {
            refined += 1;
            let noise = Wiener::new(5).from_step(path.step());
            let mut fresh = method.trajectory(state, h, noise).refine(20);
            let [fresh, next] = [fresh.next(), path.next()].map(|state| state.unwrap().unwrap());
            assert_eq!((fresh.q, fresh.p), (next.q, next.p));
        }
    }
    assert!(refined > 0);
}
