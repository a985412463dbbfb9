//! Bodies without their attitude: the reduced system and the full one agree.

use sve_runtime::Reduced;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;

use crate::starts::{attitude, body, three};
use crate::systems::NOISY_BODY;

struct ReducedBody;

#[variational(midpoint, reduced)]
impl ReducedBody {
    fn lagrangian(&self, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[h1]
    fn kicks(&self, pi: Vector3<f64>) -> [f64; 2] {
        let along = 0.3 * pi.x - 0.2 * pi.y + 0.5 * pi.z;
        let energy = 0.5 * (0.5 * pi.x * pi.x + 0.2 * pi.y * pi.y - 0.3 * pi.z * pi.z);
        [along, energy]
    }
}

/// Two bodies that exchange momentum, with friction.
struct Both {
    nu: f64,
}

#[variational(midpoint, reduced)]
impl Both {
    fn lagrangian(&self, t: f64, w: [Vector3<f64>; 2]) -> f64 {
        0.5 * (1.0 + 0.1 * t.sin()) * (w[0].norm_squared() + 2.0 * w[1].norm_squared())
            + 0.3 * w[0].dot(&w[1])
    }
    #[force]
    fn friction(&self, w: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        w.map(|w| -self.nu * w)
    }
}

#[test]
fn momentum_and_attitude_are_those_of_the_full_system() {
    let full = Integrator::new(NOISY_BODY, Midpoint);
    let reduced = Integrator::new(ReducedBody, Midpoint);
    let start = body();
    let (mut state, mut turned) = (State::<Reduced>::from_momentum(start.p), start.q);
    let mut alone = state;
    for (step, expected) in full
        .trajectory(start, 0.05, Wiener::new(3))
        .take(500)
        .enumerate()
    {
        let expected = expected.unwrap();
        let dw = [0, 1].map(|process| Wiener::new(3).increment(step as u64, process, 0.05));
        reduced
            .step_with_attitude(&mut state, &mut turned, 0.05, &dw)
            .unwrap();
        reduced.step(&mut alone, 0.05, &dw).unwrap();
        assert_eq!(state.p, alone.p);
        let error = (state.p - expected.p).norm() + (turned.coords - expected.q.coords).norm();
        assert!(error < 1e-12, "step {step}: {error:e}");
        assert!((state.p.norm() / start.p.norm() - 1.0).abs() < 1e-13);
    }
    let noises = reduced.plan().strong_order;
    assert!(matches!(noises, StrongOrder::Half { .. }), "{noises:?}");
}

#[test]
fn a_reduced_trajectory_has_the_momentum_alone() {
    let integrator = Integrator::new(ReducedBody, Midpoint);
    let start = State::<Reduced>::from_momentum(body().p);
    let path = integrator.trajectory(start, 0.05, Wiener::new(4)).take(100);
    let end = path.last().unwrap().unwrap();
    let text = serde_json::to_string(&end).unwrap();
    assert!(text.contains("\"q\":[]"), "{text}");
    let back: State<Reduced> = serde_json::from_str(&text).unwrap();
    assert_eq!(back, end);
    let energy = ReducedBody.hamiltonian(&end).unwrap();
    let w = ReducedBody.velocity(&end).unwrap();
    assert!((energy - ReducedBody.lagrangian(w)).abs() < 1e-14);
    let tangent = integrator.tangent(&end, 0.05, &[0.1, -0.2]).unwrap();
    assert!(tangent.symplectic_defect() < 1e-14);
}

/// A body with friction and a torque that is fixed in it, with its attitude and without.
struct Damped {
    nu: f64,
}

#[variational(midpoint)]
impl Damped {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[force]
    fn torque(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(0.3, -0.1, 0.2) - self.nu * w
    }
}

struct DampedWithoutAttitude {
    nu: f64,
}

#[variational(midpoint, reduced)]
impl DampedWithoutAttitude {
    fn lagrangian(&self, w: Vector3<f64>) -> f64 {
        0.5 * (w.x * w.x + 2.0 * w.y * w.y + 3.0 * w.z * w.z)
    }
    #[force]
    fn torque(&self, w: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(0.3, -0.1, 0.2) - self.nu * w
    }
}

/// The force in the frame of the body does not read the attitude, so that the steps have the same
/// bits from every attitude.
#[test]
fn a_force_in_the_frame_of_the_body_does_not_see_the_attitude() {
    let full = Integrator::new(Damped { nu: 0.2 }, Midpoint);
    let reduced = Integrator::new(DampedWithoutAttitude { nu: 0.2 }, Midpoint);
    let mut whole = body();
    let (mut state, mut turned) = (State::<Reduced>::from_momentum(whole.p), whole.q);
    for step in 0..1000 {
        let mut alone = state;
        reduced.step(&mut alone, 0.01, &[]).unwrap();
        reduced
            .step_with_attitude(&mut state, &mut turned, 0.01, &[])
            .unwrap();
        full.step(&mut whole, 0.01, &[]).unwrap();
        assert_eq!(alone.p, state.p, "step {step}");
        assert_eq!((state.p, turned), (whole.p, whole.q), "step {step}");
    }
}

#[test]
fn several_reduced_bodies_with_time_and_friction() {
    let integrator = Integrator::new(Both { nu: 0.2 }, Midpoint);
    let three = three();
    let start = State::<Reduced<[UnitQuaternion<f64>; 2]>>::from_momentum([three.p[0], three.p[1]]);
    let mut state = start;
    let mut turned = [attitude(0.1, 0.2, 0.3), attitude(0.4, 0.5, 0.6)];
    let (h, before) = (1e-6, turned);
    integrator
        .step_with_attitude(&mut state, &mut turned, h, &[])
        .unwrap();
    let drift = integrator.system().drift(&start).unwrap();
    for b in 0..2 {
        assert!(((state.p[b] - start.p[b]) / h - drift.p[b]).norm() < 1e-5);
        let x = crate::charts::cayley_vector(&(before[b].inverse() * turned[b]));
        assert!((x / h - drift.q[b]).norm() < 1e-5);
    }
}
