//! Ensembles of constrained paths, and derivatives by parameters.

use sve_models::checks::assert_close;
use sve_models::orders::numbers;
use sve_models::stepper::{Stepper, Steppers, with_verlet};
use sve_models::steps::check_sensitivity;
use sve_runtime::prelude::*;

use super::systems::{thermal, two_rods, two_rods_at};

#[test]
fn an_ensemble_has_the_paths_of_single_trajectories() {
    let midpoint = Integrator::new(thermal(0.5, 1.0), Midpoint);
    let start = State::new(Vector3::new(0.6, 0.0, -0.8), Vector3::zeros());
    let ensemble = Ensemble::new(&midpoint)
        .paths(100)
        .seed(4)
        .steps(0.05, 40)
        .start(start)
        .observe("height", |_, state: &State<Vector3<f64>>| state.q.z)
        .keep_final_states(true);
    let summary = ensemble.run().unwrap();
    assert!(summary.failures().is_empty());
    let ends: Vec<_> = summary.final_states().collect();
    assert_eq!(ends.len(), 100);
    for path in [0, 1, 63, 64, 99] {
        let single = midpoint.trajectory(start, 0.05, Wiener::new(4).path(path));
        let end = single.take(40).last().unwrap().unwrap();
        let (number, found) = &ends[path as usize];
        assert_eq!(*number, path);
        // steps in lanes have other rounding errors
        assert_close(&[found.q, found.p].concat(), &numbers(&end), 1e-13, path);
    }
}

/// Derivatives by the parameters of forces, of noise and of a constraint itself.
#[test]
fn sensitivities_are_derivatives() {
    let (h, dw, start) = (0.05, [0.2, -0.1], two_rods_at(0.5));
    let system = |name: &str, by: f64| {
        let mut rods = two_rods();
        match name {
            "m[1]" => rods.m[1] += by,
            "g" => rods.g += by,
            _ => rods.s += by,
        }
        rods
    };
    let names = ["m[1]", "g", "s"];
    check_sensitivity(system, InitialPoint, &names, &start, (h, &dw));
    check_sensitivity(system, Endpoint, &names, &start, (h, &dw));
    check_sensitivity(system, Midpoint, &names, &start, (h, &dw));
    check_sensitivity(system, StormerVerlet, &names, &start, (h, &dw));
}

/// Chains at rest, where every velocity vanishes: no equation has terms of its natural size.
#[test]
fn steps_from_rest_are_made() {
    let midpoint = Integrator::new(thermal(0.5, 0.0), Midpoint);
    let side = State::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros());
    let end = midpoint.after(side, 0.05, &[0.0; 3], 1);
    assert!((end.q.z + 0.5 * 0.05 * 0.05).abs() < 1e-4);
    // in equilibrium they stay where they are
    let hanging = State::new([0.0, -1.0, 0.0, -1.7], [0.0; 4]);
    for rule in with_verlet(&two_rods()) {
        let end = rule.after(hanging, 0.01, &[0.0; 2], 100);
        assert_close(&end.q, &hanging.q, 1e-14, rule.name());
    }
    let chain = super::systems::FiveRods { g: 1.0, s: 0.3 };
    let down: [Vector2<f64>; 5] = core::array::from_fn(|i| Vector2::new(0.0, -1.0 - i as f64));
    let at_rest = State::new(down, [Vector2::zeros(); 5]);
    let rules: Steppers<'_, _, 1> = vec![
        Box::new(Integrator::new(&chain, Midpoint)),
        Box::new(Integrator::new(&chain, StormerVerlet)),
    ];
    for rule in rules {
        let end = rule.after(at_rest, 0.01, &[0.0], 100);
        let places = |q: [Vector2<f64>; 5]| q.map(|q| [q.x, q.y]).concat();
        assert_close(&places(end.q), &places(down), 1e-14, rule.name());
    }
}
