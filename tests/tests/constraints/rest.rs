//! Steps from rest with noises that are linear in the momentum: the noise moves the configuration,
//! and the momentum stays zero. At the solution all terms of the equations of the momentum vanish,
//! so its residuals are rounding errors in every iteration.

use sve_models::models::TurnedSphere;
use sve_models::random::Random;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Momenta of the starts: at rest, and so slow that rounding errors of the constraint are larger.
const SPEEDS: [f64; 5] = [0.0, 1e-300, 1e-20, 1e-17, 1e-14];

/// Starts for each momentum.
const STARTS: u32 = 40;

/// A rotation about the axis of the noise by `angle`.
fn turned(q: Vector3<f64>, angle: f64) -> Vector3<f64> {
    let axis = Vector3::new(1.0, -2.0, 2.0) / 3.0;
    let along = axis * axis.dot(&q);
    along + (q - along) * angle.cos() + axis.cross(&q) * angle.sin()
}

fn vector(random: &mut Random) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0))
}

/// Makes steps from random starts, and compares those of a rule whose angle of rotation is known.
fn check<R>(rule: R, largest: f64, angle: impl Fn(f64) -> Option<f64>)
where
    TurnedSphere: Variational<R> + System<Dims = Dims<3, 1, [f64; 3]>>,
{
    let turned_sphere = Integrator::new(TurnedSphere { s: 1.0 }, rule);
    let mut random = Random::new(17);
    for speed in SPEEDS {
        for _ in 0..STARTS {
            let q = vector(&mut random).normalize();
            let p = vector(&mut random) * speed;
            let start = State::new(q.into(), p.into());
            let mut state = turned_sphere.consistent(start).unwrap();
            let h = 10.0_f64.powf(random.uniform(-5.0, 0.0)) * random.uniform(-1.0, 1.0).signum();
            let dw = random.uniform(-largest, largest);
            for step in 0..5 {
                let before = state;
                let result = turned_sphere.step(&mut state, h, &[dw]);
                assert!(
                    result.is_ok(),
                    "{step}: {result:?} from {before:?}, h = {h}, dw = {dw}"
                );
                let (from, to) = (Vector3::from(before.q), Vector3::from(state.q));
                assert!((to.norm() - 1.0).abs() < 16.0 * f64::EPSILON, "{to:?}");
                // the other rules leave the sphere with the noise, and come back to it with a
                // momentum
                let Some(angle) = angle(dw) else { continue };
                let distance = (to - turned(from, angle)).norm();
                assert!(
                    distance < 2e-14 + 8.0 * h.abs() * speed,
                    "{distance:e}, {h} {dw}"
                );
                // an error of rounding of the configuration is one of its velocity by 1/h
                let p = Vector3::from(state.p).norm();
                assert!(p < 1e-14 / h.abs() + 4.0 * speed, "{p:e}, {h} {dw}");
            }
        }
    }
}

/// The midpoint rule turns by 2 arctan(s ΔW/2) about the axis.
#[test]
fn noise_alone_moves_a_system_at_rest() {
    let cayley = |dw: f64| Some(2.0 * (0.5 * dw).atan());
    check(Midpoint, 0.3, cayley);
    // these steps are followed by continuation
    check(Midpoint, 3.0, cayley);
    check(StormerVerlet, 0.3, |_| None);
    check(InitialPoint, 0.3, |_| None);
    check(Endpoint, 0.3, |_| None);
}
