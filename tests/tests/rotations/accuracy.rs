//! How far steps of bodies are from their motions, up to turns of 172 degrees a step.

use sve_runtime::prelude::*;

use crate::starts::attitude;
use crate::systems::{FreeBody, HeavyTop};

/// Returns the rotation vector from one attitude to another in the frame of the body.
fn turn(from: UnitQuaternion<f64>, to: UnitQuaternion<f64>) -> Vector3<f64> {
    (from.inverse() * to).scaled_axis()
}

/// A free body turns about a principal axis as its motion does, at each step size. The axis of the
/// middle moment is not stable.
#[test]
fn turns_about_principal_axes_are_exact() {
    let i = Vector3::new(1.0, 2.0, 3.0);
    let integrator = Integrator::new(FreeBody { i }, Midpoint);
    for axis in [0, 2] {
        for angle in [1e-9, 0.1, 1.0, 2.0, 3.1, 3.9, -3.9] {
            let mut p = Vector3::zeros();
            p[axis] = i[axis] * 2.0;
            let start = State::new(attitude(0.4, -0.7, 1.1), p);
            let mut state = start;
            let h: f64 = 0.5 * angle;
            let mut turned = UnitQuaternion::identity();
            let once = UnitQuaternion::from_scaled_axis(angle * Vector3::ith(axis, 1.0));
            for _ in 0..100 {
                integrator.step(&mut state, h, &[]).unwrap();
                turned *= once;
            }
            let error = turn(start.q * turned, state.q).norm();
            assert!(error < 1e-13, "axis {axis}, angle {angle}: {error:e}");
            assert!((state.p - p).norm() < 1e-13, "{}", state.p);
        }
    }
}

/// The errors of a free body at t = 4 are 0.260 h² in the attitude and 0.312 h² in the body
/// momentum. In Cayley's chart they are 3.54 h² and 5.32 h².
#[test]
fn errors_of_a_free_body_have_these_constants() {
    let i = Vector3::new(1.0, 2.0, 3.0);
    let w = Vector3::new(0.6, 0.9, 0.7);
    let start = State::new(UnitQuaternion::identity(), i.component_mul(&w));
    let (mut exact, mut found) = (start, start);
    let composed = Integrator::new(FreeBody { i }, Composed::new(Midpoint, KahanLi8));
    for _ in 0..200 {
        composed.step(&mut exact, 4.0 / 200.0, &[]).unwrap();
    }
    let h: f64 = 4.0 / 160.0;
    let midpoint = Integrator::new(FreeBody { i }, Midpoint);
    for _ in 0..160 {
        midpoint.step(&mut found, h, &[]).unwrap();
    }
    let of_attitude = turn(exact.q, found.q).norm() / (h * h);
    let of_momentum = (found.p - exact.p).norm() / (h * h);
    assert!((of_attitude - 0.260).abs() < 1e-3, "{of_attitude}");
    assert!((of_momentum - 0.312).abs() < 1e-3, "{of_momentum}");
}

/// Störmer and Verlet's rule has order 2 for a heavy top, and a smaller error than the midpoint
/// rule for a slow one.
#[test]
fn the_rule_of_stormer_and_verlet_has_order_two() {
    let top = HeavyTop {
        i: Vector3::new(0.8, 1.1, 0.6),
        weight: 1.0,
        s: 0.0,
    };
    let start = State::new(attitude(0.4, -0.7, 1.1), Vector3::new(0.4, 0.6, 0.3));
    let composed = Integrator::new(top, Composed::new(StormerVerlet, KahanLi8));
    let mut exact = start;
    for _ in 0..200 {
        composed.step(&mut exact, 0.02, &[0.0]).unwrap();
    }
    let error = |step: &dyn Fn(&mut State<UnitQuaternion<f64>>, f64), steps: u32| {
        let mut state = start;
        for _ in 0..steps {
            step(&mut state, 4.0 / f64::from(steps));
        }
        turn(exact.q, state.q).norm()
    };
    let verlet = Integrator::new(top, StormerVerlet);
    let midpoint = Integrator::new(top, Midpoint);
    let verlet = |steps| error(&|state, h| verlet.step(state, h, &[0.0]).unwrap(), steps);
    let midpoint = |steps| error(&|state, h| midpoint.step(state, h, &[0.0]).unwrap(), steps);
    let order = (verlet(80) / verlet(160)).log2();
    assert!((order - 2.0).abs() < 0.02, "{order}");
    let gain = midpoint(160) / verlet(160);
    println!("{gain}");
    assert!(gain > 1.2, "{gain}");
}

/// From a body that turns by up to 172 degrees a step, the step is connected with short steps.
#[test]
fn large_turns_are_connected_with_small_ones() {
    let i = Vector3::new(1.0, 2.0, 3.0);
    let integrator = Integrator::new(FreeBody { i }, Midpoint);
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    for k in 0..200 {
        let z = (2.0 * f64::from(k) + 1.0) / 200.0 - 1.0;
        let (sin, cos) = (golden * f64::from(k)).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let w = Vector3::new(across * cos, across * sin, z);
        let start = State::new(UnitQuaternion::identity(), i.component_mul(&w));
        let parts: u32 = 150;
        let mut before = Vector3::zeros();
        for part in 1..=parts {
            let mut state = start;
            let h = 3.0 * f64::from(part) / f64::from(parts);
            integrator.step(&mut state, h, &[]).unwrap();
            // the quaternion is continuous, so that the vector is that of the step beyond 180
            // degrees
            let [x, y, z, w] = state.q.coords.into();
            let imaginary = Vector3::new(x, y, z);
            let angle = 2.0 * imaginary.norm().atan2(w);
            let x = imaginary.normalize() * angle;
            let moved = (x - before).norm();
            assert!(moved < 0.12, "direction {k}, h = {h}: {moved}");
            before = x;
        }
    }
}
