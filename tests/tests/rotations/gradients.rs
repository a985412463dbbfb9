//! Gradients along paths with rotations, against differences in the canonical coordinates of the
//! start and by the parameters.

use sve_runtime::ensemble::By;
use sve_runtime::prelude::*;
use sve_runtime::{Dual, Gradient};

use crate::charts::{Chart, slopes};
use crate::starts::{body, pair, three};
use crate::systems::{DRIVEN, HeavyTop, I, TETHERED, THREE, TOP};

const H: f64 = 0.05;
const STEPS: u64 = 7;

/// Differences of sixth order of losses of order 1.
const ACCURACY: f64 = 2e-10;

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < ACCURACY, "{found:?} for {expected:?}");
    }
    assert!(expected.iter().any(|x| x.abs() > 1e-3), "{expected:?}");
}

/// Returns the sum of a loss over state 3 and the last one.
fn along<S>(path: impl Iterator<Item = Result<S, StepError>>, loss: impl Fn(&S) -> f64) -> f64 {
    let states: Vec<S> = path.take(STEPS as usize).map(Result::unwrap).collect();
    loss(&states[2]) + loss(&states[STEPS as usize - 1])
}

fn counts(step: u64) -> bool {
    step == 3 || step == STEPS
}

/// The height of a point of the body, the twist of its frame, and its momentum in space.
fn top_loss(state: &State<UnitQuaternion<f64>>) -> f64 {
    let (at, r) = (
        state.q * Vector3::new(0.3, -0.2, 1.0),
        state.q.to_rotation_matrix(),
    );
    at.z + 0.5 * at.x * at.y
        + r[(1, 0)] * state.p.z
        + 0.2 * state.p.norm_squared()
        + (state.q * state.p).y
}

fn top_loss_in_duals(q: sve_runtime::DualRotation, p: [Dual; 3]) -> Dual {
    let at = q * Vector3::new(0.3, -0.2, 1.0);
    let squares: Dual = p.iter().map(|p| p.powi(2)).sum();
    at[2] + 0.5 * at[0] * at[1] + q[(1, 0)] * p[2] + 0.2 * squares + (q * p)[1]
}

fn top_gradient<R>(rule: R, start: State<UnitQuaternion<f64>>) -> Gradient<Vector3<f64>>
where
    HeavyTop: sve_runtime::Variational<R>,
    R: Copy,
{
    let top = Integrator::new(TOP, rule);
    let path = top.trajectory(start, H, Wiener::new(5));
    path.adjoint(STEPS)
        .checkpoints(2)
        .gradient(|k, state| counts(k).then(|| top_loss_in_duals(state.q, state.p)))
        .unwrap()
}

#[test]
fn the_gradient_of_a_heavy_top_is_that_of_differences() {
    let loss = |top: HeavyTop, start: &State<UnitQuaternion<f64>>| {
        let top = Integrator::new(top, Midpoint);
        along(top.trajectory(*start, H, Wiener::new(5)), top_loss)
    };
    let gradient = top_gradient(Midpoint, body());
    assert!((gradient.loss() - loss(TOP, &body())).abs() < 1e-13);
    let start = gradient.start();
    let found: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
    assert_close(&found, &slopes(&body(), |start| loss(TOP, start)));
    let by = |top: fn(f64) -> HeavyTop| {
        let difference = |d: f64| (loss(top(d), &body()) - loss(top(-d), &body())) / (2.0 * d);
        (4.0 * difference(1e-3) - difference(2e-3)) / 3.0
    };
    let weight = |d| HeavyTop {
        weight: TOP.weight + d,
        ..TOP
    };
    let s = |d| HeavyTop {
        s: TOP.s + d,
        ..TOP
    };
    let inertia = |d| HeavyTop {
        i: I + d * Vector3::y(),
        ..TOP
    };
    let found = ["weight", "s", "i.y"].map(|name| gradient.get(name).unwrap());
    assert_close(&found, &[by(weight), by(s), by(inertia)]);
}

/// Substeps of a composition, and the same loss from the tangent maps of the steps.
#[test]
fn the_gradient_is_the_transpose_of_the_tangent_maps() {
    let rule = Composed::new(Midpoint, KahanLi8);
    let top = Integrator::new(TOP, rule);
    let gradient = top_gradient(rule, body());
    let mut state = body();
    let mut map = sve_runtime::Tangent::<3>::identity();
    let mut expected = vec![0.0; 6];
    for step in 0..STEPS {
        let dw = [Wiener::new(5).increment(step, 0, H)];
        let (tangent, _) = top.step_with_derivatives(&mut state, H, &dw).unwrap();
        map = &tangent * &map;
        if counts(step + 1) {
            let by_state = slopes(&state, top_loss);
            for (row, slope) in by_state.iter().enumerate() {
                (0..6).for_each(|column| expected[column] += slope * map[row][column]);
            }
        }
    }
    let start = gradient.start();
    let found: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
    assert_close(&found, &expected);
}

#[test]
fn gradients_of_a_body_beside_a_vector_and_of_several_bodies() {
    let tethered = Integrator::new(TETHERED, Midpoint);
    let arm = Vector3::new(0.1, 0.4, -0.2);
    let loss = |state: &State<(Vector3<f64>, UnitQuaternion<f64>)>| {
        let end = state.q.0 + state.q.1 * arm;
        end.norm_squared() + end.x * state.p.0.y + state.p.1.dot(&arm)
    };
    let gradient = tethered
        .trajectory(pair(), H, Wiener::new(8))
        .gradient(STEPS, |k, state| {
            let (q, turned) = (state.q.0, state.q.1 * arm);
            let end = [0, 1, 2].map(|i| q[i] + turned[i]);
            let squares: Dual = end.iter().map(|x| x.powi(2)).sum();
            let spin: Dual = (0..3).map(|i| arm[i] * state.p[3 + i]).sum();
            counts(k).then(|| squares + end[0] * state.p[1] + spin)
        })
        .unwrap();
    let expected = slopes(&pair(), |start| {
        along(tethered.trajectory(*start, H, Wiener::new(8)), loss)
    });
    let start = gradient.start();
    let parts = [start.q.0, start.q.1, start.p.0, start.p.1];
    let found: Vec<f64> = parts.iter().flat_map(|part| part.iter().copied()).collect();
    assert_close(&found, &expected);

    let bodies = Integrator::new(THREE, Midpoint);
    let loss = |state: &State<[UnitQuaternion<f64>; 3]>| {
        let relative = state.q[0].inverse() * (state.q[2] * Vector3::x());
        relative.y + state.p[1].z * relative.x
    };
    let gradient = bodies
        .trajectory(three(), H, Wiener::new(8))
        .gradient(STEPS, |k, state| {
            let relative = state.q[0].inverse() * (state.q[2] * Vector3::x());
            counts(k).then(|| relative[1] + state.p[5] * relative[0])
        })
        .unwrap();
    let expected = slopes(&three(), |start| {
        along(bodies.trajectory(*start, H, Wiener::new(8)), loss)
    });
    let start = gradient.start();
    let parts = start.q.iter().chain(&start.p);
    let found: Vec<f64> = parts.flat_map(|part| part.iter().copied()).collect();
    assert_close(&found, &expected);
}

/// With friction and a torque, the energy is a loss that depends on every part of the state.
#[test]
fn gradients_with_a_force() {
    let driven = Integrator::new(DRIVEN, Midpoint);
    let loss = |state: &State<UnitQuaternion<f64>>| driven.system().hamiltonian(state).unwrap();
    let gradient = driven
        .trajectory(body(), H, NoNoise)
        .gradient(STEPS, |k, state| {
            let kinetic: Dual = (0..3).map(|i| state.p[i].powi(2) / I[i]).sum();
            let height = state.q[(2, 2)];
            counts(k).then(|| 0.5 * kinetic + state.parameter("weight") * height)
        })
        .unwrap();
    let expected = slopes(&body(), |start| {
        along(driven.trajectory(*start, H, NoNoise), loss)
    });
    let start = gradient.start();
    let found: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
    assert_close(&found, &expected);
}

/// Means of an ensemble: with the same noise the derivative of the mean is that of differences.
#[test]
fn gradients_of_means() {
    let mean = |weight: f64, z: &[f64]| {
        let top = Integrator::new(HeavyTop { weight, ..TOP }, Midpoint);
        let summary = Ensemble::new(&top)
            .paths(20)
            .seed(3)
            .steps(H, STEPS)
            .start(body().moved(z))
            .gradient(
                "height",
                [By::parameter("weight"), By::q(1), By::p(2)],
                |state| (state.q * Vector3::z())[2],
            )
            .run()
            .unwrap();
        let slope = |by: By| {
            *summary
                .derivative("height", by)
                .unwrap()
                .mean()
                .last()
                .unwrap()
        };
        let slopes = [slope("weight".into()), slope(By::q(1)), slope(By::p(2))];
        (*summary["height"].mean().last().unwrap(), slopes)
    };
    let at = |column: usize, d: f64| {
        let mut z = [0.0; 6];
        z[column] = d;
        mean(TOP.weight, &z).0
    };
    let still = [0.0; 6];
    let by_weight = |d: f64| mean(TOP.weight + d, &still).0 - mean(TOP.weight - d, &still).0;
    let difference =
        |change: &dyn Fn(f64) -> f64| (4.0 * change(1e-3) / 2e-3 - change(2e-3) / 4e-3) / 3.0;
    let expected = [
        difference(&by_weight),
        difference(&|d| at(1, d) - at(1, -d)),
        difference(&|d| at(5, d) - at(5, -d)),
    ];
    assert_close(&mean(TOP.weight, &still).1, &expected);
}
