//! Ensembles of constrained paths, and derivatives by parameters.

use sve_models::differences::derivatives;
use sve_models::models::{Thermal, TwoRods};
use sve_runtime::prelude::*;

use super::systems::two_rods;

#[test]
fn an_ensemble_has_the_paths_of_single_trajectories() {
    let midpoint = Integrator::new(
        Thermal {
            g: 1.0,
            nu: 0.5,
            temperature: 1.0,
        },
        Midpoint,
    );
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
        let pairs = found.q.iter().zip(&end.q).chain(found.p.iter().zip(&end.p));
        for (a, b) in pairs {
            assert!((a - b).abs() < 1e-13, "{found:?} {end:?}");
        }
    }
}

/// Derivatives by the parameters of forces, of noise and of a constraint itself.
#[test]
fn sensitivities_are_derivatives() {
    fn check<R: Copy>(rule: R)
    where
        TwoRods: sve_runtime::Variational<R>,
    {
        let (h, dw) = (0.05, [0.2, -0.1]);
        let start = State::new([0.9, -0.4, 0.6, -1.0], [0.2, 0.5, 0.4, 0.1]);
        let integrator = Integrator::new(two_rods(), rule);
        let start = integrator.consistent(start).unwrap();
        let sensitivity = integrator.sensitivity(&start, h, &dw).unwrap();
        for (name, change) in [
            (
                "m[1]",
                (|rods: &mut TwoRods, d: f64| rods.m[1] += d) as fn(&mut TwoRods, f64),
            ),
            ("g", |rods, d| rods.g += d),
            ("s", |rods, d| rods.s += d),
        ] {
            let moved = |d: f64| -> Vec<f64> {
                let mut rods = two_rods();
                change(&mut rods, d);
                let mut state = start;
                Integrator::new(rods, rule)
                    .step(&mut state, h, &dw)
                    .unwrap();
                [state.q, state.p].concat()
            };
            let expected = derivatives(moved);
            let found = sensitivity.get(name).unwrap();
            let found = [found.q, found.p].concat();
            for (a, b) in found.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-9, "{name}: {found:?} {expected:?}");
            }
        }
    }
    check(InitialPoint);
    check(Endpoint);
    check(Midpoint);
    check(StormerVerlet);
}

/// Checks that a state in equilibrium stays where it is.
fn stays<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    dw: [f64; M],
) where
    S: sve_runtime::Variational<R> + sve_runtime::System<Dims = sve_runtime::Dims<N, M, Q>>,
    Q: sve_runtime::VectorCoordinates<N>,
{
    let mut state = start;
    for _ in 0..100 {
        integrator.step(&mut state, 0.01, &dw).unwrap();
    }
    let (q, start) = (state.q.coordinates(), start.q.coordinates());
    assert!((0..N).all(|i| (q[i] - start[i]).abs() < 1e-14), "{q:?}");
}

/// Chains at rest, where every velocity vanishes: no equation has terms of its natural size.
#[test]
fn steps_from_rest_are_made() {
    let thermal = Thermal {
        g: 1.0,
        nu: 0.5,
        temperature: 0.0,
    };
    let midpoint = Integrator::new(&thermal, Midpoint);
    let mut state = State::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros());
    midpoint.step(&mut state, 0.05, &[0.0; 3]).unwrap();
    assert!((state.q.z + 0.5 * 0.05 * 0.05).abs() < 1e-4);
    let rods = two_rods();
    let hanging = State::new([0.0, -1.0, 0.0, -1.7], [0.0; 4]);
    let chain = super::systems::FiveRods { g: 1.0, s: 0.3 };
    let down: [Vector2<f64>; 5] = core::array::from_fn(|i| Vector2::new(0.0, -1.0 - i as f64));
    let at_rest = State::new(down, [Vector2::zeros(); 5]);
    stays(&Integrator::new(&rods, Midpoint), hanging, [0.0; 2]);
    stays(&Integrator::new(&rods, StormerVerlet), hanging, [0.0; 2]);
    stays(&Integrator::new(&rods, InitialPoint), hanging, [0.0; 2]);
    stays(&Integrator::new(&rods, Endpoint), hanging, [0.0; 2]);
    stays(&Integrator::new(&chain, Midpoint), at_rest, [0.0]);
    stays(&Integrator::new(&chain, StormerVerlet), at_rest, [0.0]);
}
