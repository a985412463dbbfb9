//! Steps that lose the constraints are errors with numbers, and leave the state.

use sve_models::checks::failure;
use sve_models::models::OnSphere;
use sve_models::orders::distance2;
use sve_models::stepper::{Stepper, with_verlet};
use sve_runtime::prelude::*;

/// A four-bar linkage: a parallelogram of cranks of length 1 and a coupler of length 2.
pub(super) struct FourBars;

#[variational(midpoint, stormer_verlet)]
impl FourBars {
    fn lagrangian(&self, q: [Vector2<f64>; 2], v: [Vector2<f64>; 2]) -> f64 {
        0.5 * (v[0].norm_squared() + v[1].norm_squared()) - q[0].y
    }

    #[constraint]
    fn cranks(&self, q: [Vector2<f64>; 2]) -> [f64; 2] {
        let second = q[1] - Vector2::new(2.0, 0.0);
        [
            0.5 * (q[0].norm_squared() - 1.0),
            0.5 * (second.norm_squared() - 1.0),
        ]
    }

    #[constraint]
    fn coupler(&self, q: [Vector2<f64>; 2]) -> f64 {
        0.5 * ((q[1] - q[0]).norm_squared() - 4.0)
    }
}

#[test]
fn a_folded_linkage_is_an_error() {
    let folded = State::new(
        [Vector2::new(1.0, 0.0), Vector2::new(3.0, 0.0)],
        [Vector2::new(0.0, 1.0), Vector2::new(0.0, 1.0)],
    );
    let midpoint = Integrator::new(FourBars, Midpoint);
    let verlet = Integrator::new(FourBars, StormerVerlet);
    let errors = [
        failure(&midpoint, &folded, 0.01, &[]),
        failure(&verlet, &folded, 0.01, &[]),
        midpoint.consistent(folded).unwrap_err(),
    ];
    for error in errors {
        let StepError::ConstraintRank {
            k,
            constraint,
            pivot,
            t,
            ..
        } = &error
        else {
            panic!("{error}");
        };
        assert_eq!((*k, &**constraint, *t), (2, "coupler", 0.0));
        assert!(pivot.abs() < 1e-14, "{error}");
    }
    // and it moves elsewhere
    let angle = 1.0_f64;
    let arm = Vector2::new(angle.cos(), angle.sin());
    let across = Vector2::new(-angle.sin(), angle.cos());
    let open = State::new([arm, arm + Vector2::new(2.0, 0.0)], [across; 2]);
    midpoint.after(open, 0.01, &[], 50);
}

#[test]
fn a_step_beyond_the_curvature_is_an_error() {
    let start = State::new([0.0, 0.0, -1.0], [3.0, 0.0, 0.0]);
    let integrator = Integrator::new(OnSphere { g: 1.0, s: 0.5 }, StormerVerlet);
    // h |v| is longer than the radius: SHAKE finds no point on the sphere along the normal
    let error = failure(&integrator, &start, 0.5, &[0.0, 0.0]);
    let StepError::ConstraintLost {
        step,
        distance,
        constraint,
        violation,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!(&**constraint, "sphere");
    assert!((distance - 1.5).abs() < 1e-12, "{error}");
    // it ends where h |v| = 1
    assert!((step - 2.0 / 3.0).abs() < 0.02, "{error}");
    // ½ 1.5² beside the magnitudes of φ and of ∂φ/∂q times q
    assert!((violation - 1.125 / 5.375).abs() < 1e-12, "{error}");
    // a smaller step succeeds
    integrator.after(start, 0.25, &[0.0, 0.0], 1);
}

/// With increments of five standard deviations, from points all around the equator, each step is
/// that of the continuation in the increments: no other root is taken.
#[test]
fn large_increments_lead_to_no_other_root() {
    let (system, h) = (OnSphere { g: 1.0, s: 1.0 }, 0.01);
    for rule in with_verlet(&system) {
        for k in 0..400 {
            let angle = 0.1 * f64::from(k);
            let start = State::new([angle.cos(), angle.sin(), 0.0], [0.0, 0.0, 1.0]);
            let dw = [0.5 * (0.7 * angle).cos(), 0.5 * (1.3 * angle).sin()];
            let end = rule.after(start, h, &dw, 1);
            let moved = distance2(&end.q, &start.q).sqrt();
            // |p| is at most 1 + √2 · 0.5 or so
            assert!(moved < 2.5 * h, "{}, step {k}: {moved}", rule.name());
        }
    }
}
