//! Steps and trajectories of integrators and baselines.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sve_models::configured::Configured;
use sve_models::models::Stirred;
use sve_models::oracle::stirred;
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama, Heun};
use sve_runtime::baseline::{RungeKutta4, TaylorSeries2};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::{DW, H, START, Six, every_type, flat, flat_field, state, system};

#[test]
fn steps_and_derivatives_have_the_bits_of_the_coordinates() {
    fn check<Q: Six>() {
        let integrator = Integrator::new(system::<Q>(), Midpoint);
        let expected = Integrator::new(system::<[f64; 6]>(), Midpoint);
        let (mut own, mut other) = (state::<Q, 6>(&START), START);
        for _ in 0..5 {
            integrator.step(&mut own, H, &DW).unwrap();
            expected.step(&mut other, H, &DW).unwrap();
            assert_eq!(flat(&own), other);
        }
        let (tangent, sensitivity) = integrator.step_with_derivatives(&mut own, H, &DW).unwrap();
        let (map, slopes) = expected.step_with_derivatives(&mut other, H, &DW).unwrap();
        assert_eq!(tangent, map);
        assert_eq!(flat(&own), other);
        let (mut total, mut sum) = (sensitivity.clone(), slopes.clone());
        total.advance(&tangent, &sensitivity);
        sum.advance(&map, &slopes);
        for (name, slope) in sum.iter() {
            let field = total.get(name).unwrap();
            assert_eq!(flat_field(field), *slope);
            assert_eq!(flat_field(&tangent.apply(field)), map.apply(slope));
        }
        // a step that fails leaves the state
        let before = own;
        assert!(integrator.step(&mut own, H, &[f64::NAN; 3]).is_err());
        assert_eq!(own, before);
    }
    every_type!(check);
}

#[test]
fn trajectories_and_snapshots_have_the_bits_of_the_coordinates() {
    fn check<Q: Six>()
    where
        State<Q>: Serialize + DeserializeOwned,
    {
        let integrator = Integrator::new(system::<Q>(), Midpoint);
        let expected = Integrator::new(system::<[f64; 6]>(), Midpoint);
        let noise = || Wiener::new(3);
        let mut path = integrator
            .trajectory(state(&START), H, noise())
            .compensated()
            .refine(3);
        let mut other = expected
            .trajectory(START, H, noise())
            .compensated()
            .refine(3);
        for _ in 0..20 {
            let state = path.next().unwrap().unwrap();
            assert_eq!(flat(&state), other.next().unwrap().unwrap());
        }
        let text = serde_json::to_string(&path.snapshot()).unwrap();
        // the stored form is that of the coordinates
        assert_eq!(text, serde_json::to_string(&other.snapshot()).unwrap());
        let snapshot: Snapshot<State<Q>> = serde_json::from_str(&text).unwrap();
        assert_eq!(snapshot, path.snapshot());
        let mut rest = integrator.resume(snapshot, noise()).unwrap();
        for _ in 0..5 {
            assert_eq!(rest.next(), path.next());
        }
    }
    every_type!(check);
}

/// One step of a method for both types of configurations.
fn same_step<A, B, Q, const N: usize, const M: usize>(
    method: &A,
    expected: &B,
    start: &State<[f64; N]>,
    dw: &[f64; M],
) where
    A: Method<System: System<Dims = Dims<N, M, Q>>>,
    B: Method<System: System<Dims = Dims<N, M>>>,
    Q: VectorCoordinates<N>,
{
    let (mut own, mut other) = (state::<Q, N>(start), *start);
    method.step(&mut own, H, dw).unwrap();
    expected.step(&mut other, H, dw).unwrap();
    assert_ne!(other, *start);
    assert_eq!(flat(&own), other);
}

#[test]
fn baselines_have_the_bits_of_the_coordinates() {
    fn noisy<Q: Six>() {
        let (own, other) = (system::<Q>(), system::<[f64; 6]>());
        same_step(
            &EulerMaruyama::new(&own),
            &EulerMaruyama::new(&other),
            &START,
            &DW,
        );
        same_step(&Heun::new(&own), &Heun::new(&other), &START, &DW);
        let implicit = BackwardEulerMaruyama::new(&own);
        same_step(&implicit, &BackwardEulerMaruyama::new(&other), &START, &DW);
    }
    every_type!(noisy);
    let own: Configured<Stirred, Vector2<f64>> = Configured::new(stirred());
    let start = State::at(0.1, [0.3, -0.2], [1.0, 0.4]);
    same_step(
        &RungeKutta4::new(&own),
        &RungeKutta4::new(stirred()),
        &start,
        &[],
    );
    same_step(
        &TaylorSeries2::new(&own),
        &TaylorSeries2::new(stirred()),
        &start,
        &[],
    );
}
