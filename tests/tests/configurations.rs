//! A state of any type of configurations is stepped, recorded and stored with the bits of the state in coordinates.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sve_models::configured::Configured;
use sve_models::models::{Charges, Stirred};
use sve_models::oracle::{charges, stirred};
use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama, Heun};
use sve_runtime::baseline::{RungeKutta4, TaylorSeries2};
use sve_runtime::nalgebra::DMatrix;
use sve_runtime::prelude::*;
use sve_runtime::study::Study;
use sve_runtime::{Configuration, Coordinates, Dims, Field, PlainMethod, StateOf, System};

const H: f64 = 0.05;
const DW: [f64; 3] = [0.1, -0.2, 0.05];

/// Two charges with configurations of the type `Q`.
fn system<Q>() -> Configured<Charges, Q> {
    Configured::new(charges().0)
}

/// Where the charges start, in coordinates.
const START: State<[f64; 6]> = State::at(
    0.25,
    [0.7, 0.1, -0.2, -0.6, 0.2, 0.3],
    [0.1, 0.5, 0.2, -0.2, -0.4, -0.1],
);

fn state<Q: Coordinates<N>, const N: usize>(flat: &State<[f64; N]>) -> State<Q> {
    State::at(
        flat.t,
        Q::from_coordinates(&flat.q),
        Q::from_components(&flat.p),
    )
}

fn flat<Q: Coordinates<N>, const N: usize>(state: &State<Q>) -> State<[f64; N]> {
    State::at(state.t, state.q.coordinates(), Q::components(&state.p))
}

fn flat_field<V, const N: usize>(field: &Field<V>) -> Field<[f64; N]>
where
    V: Coordinates<N, Momentum = V>,
{
    Field {
        q: field.q.coordinates(),
        p: field.p.coordinates(),
    }
}

/// Instantiates a function for every type of configurations with six coordinates.
macro_rules! every_type {
    ($function:ident) => {
        $function::<[f64; 6]>();
        $function::<SVector<f64, 6>>();
        $function::<[[f64; 3]; 2]>();
        $function::<[Vector3<f64>; 2]>();
        $function::<[[[f64; 1]; 3]; 2]>();
    };
}

/// What a configuration of six coordinates promises here.
trait Six: Coordinates<6, Momentum: Coordinates<6, Momentum = Self::Momentum>> {}

impl<Q: Coordinates<6, Momentum: Coordinates<6, Momentum = Self::Momentum>>> Six for Q {}

#[test]
fn sizes_storage_and_increments() {
    fn check<Q: Six>() {
        let mut q: Q = Q::from_coordinates(&START.q);
        assert_eq!([q.degrees_of_freedom(), q.stored_values()], [6, 6]);
        assert_eq!([Q::DEGREES_OF_FREEDOM, Q::STORED_VALUES], [6, 6]);
        let mut values = [f64::NAN; 6];
        q.store(&mut values);
        assert_eq!(values, START.q);
        let increment = [1.0, -0.5, 0.25, 1e-3, 7.0, 0.0];
        q.retract(&increment);
        let moved: [f64; 6] = std::array::from_fn(|i| START.q[i] + increment[i]);
        assert_eq!(q.coordinates(), moved);
        q.restore(&START.q);
        assert_eq!(q, Q::from_coordinates(&START.q));
        assert_eq!(Q::origin().coordinates(), [0.0; 6]);
    }
    every_type!(check);
    let rows = [[1.0, 2.0], [3.0, 4.0]];
    assert_eq!(Coordinates::<4>::coordinates(&rows), [1.0, 2.0, 3.0, 4.0]);
    let vectors = [Vector2::new(1.0, 2.0), Vector2::new(3.0, 4.0)];
    assert_eq!(
        Coordinates::<4>::coordinates(&vectors),
        [1.0, 2.0, 3.0, 4.0]
    );
}

#[test]
#[should_panic(expected = "an increment of another length")]
fn an_increment_of_another_length_is_refused() {
    Vector3::zeros().retract(&[1.0, 2.0]);
}

#[test]
#[should_panic(expected = "an increment longer than the degrees of freedom")]
fn an_increment_that_is_too_long_for_the_bodies_is_refused() {
    [[0.0; 2]; 2].retract(&[0.0; 5]);
}

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

#[test]
fn states_are_stored_as_a_row_of_numbers() {
    let vectors = State::at(
        0.5,
        [Vector2::new(1.0, f64::NAN), Vector2::new(0.1, 2.0)],
        [Vector2::zeros(), Vector2::new(f64::NEG_INFINITY, 3.0)],
    );
    let text = serde_json::to_string(&vectors).unwrap();
    assert_eq!(
        text,
        r#"{"t":0.5,"q":[1.0,"NaN",0.1,2.0],"p":[0.0,0.0,"-inf",3.0]}"#
    );
    let back: State<[Vector2<f64>; 2]> = serde_json::from_str(&text).unwrap();
    assert_eq!((back.q[1], back.p), (vectors.q[1], vectors.p));
    let rows: State<[f64; 4]> = serde_json::from_str(&text).unwrap();
    assert_eq!(rows.p, [0.0, 0.0, f64::NEG_INFINITY, 3.0]);
    assert!(serde_json::from_str::<State<[Vector3<f64>; 2]>>(&text).is_err());
    assert!(serde_json::from_str::<State<Vector3<f64>>>(&text).is_err());
}

#[test]
fn ensembles_have_the_bits_of_the_coordinates() {
    fn summary<Q: Six>(method: &Integrator<Configured<Charges, Q>, Midpoint>) -> Vec<Vec<f64>> {
        let ensemble = Ensemble::new(method)
            .paths(70)
            .seed(2)
            .steps(H, 12)
            .start_with(|_, rng| {
                let mut start = START;
                start.q[0] += 0.1 * rng.normal();
                state::<Q, 6>(&start)
            })
            .observe("energy", Mechanics::hamiltonian)
            .observe("last", |_, state: &State<Q>| flat(state).p[5])
            .keep_final_states(true);
        let summary = ensemble.run().unwrap();
        let mut numbers = Vec::new();
        for statistics in summary.statistics() {
            numbers.push([statistics.mean(), &statistics.variance()].concat());
        }
        for (path, end) in summary.final_states() {
            numbers.push([end.q, end.p].concat());
            let state: State<Q> = end.state().unwrap();
            assert_eq!(state, end);
            assert_eq!(end.state::<Vector2<f64>>(), None);
            if path % 23 == 0 {
                let last = ensemble.replay(path).unwrap().last();
                assert_eq!(last.unwrap().unwrap(), state);
            }
        }
        numbers
    }
    let expected = summary(&Integrator::new(system::<[f64; 6]>(), Midpoint));
    assert_eq!(expected.len(), 72);
    let nested = Integrator::new(system::<[[f64; 3]; 2]>(), Midpoint);
    assert_eq!(summary(&nested), expected);
    let vectors = Integrator::new(system::<[Vector3<f64>; 2]>(), Midpoint);
    assert_eq!(summary(&vectors), expected);
}

#[test]
fn mechanics_returns_the_types_of_the_configuration() {
    fn check<Q: Six>() {
        let (own, other) = (system::<Q>(), system::<[f64; 6]>());
        let State { t, q, p } = state::<Q, 6>(&START);
        let v = own.velocity_at(t, q, p).unwrap();
        assert_eq!(
            Q::components(&v),
            other.velocity_at(t, START.q, START.p).unwrap()
        );
        let momentum = own.momentum_at(t, q, v);
        let expected = other.momentum_at(t, START.q, Q::components(&v));
        assert_eq!(Q::components(&momentum), expected);
        let at = State::at(t, q, p);
        assert_eq!(own.hamiltonian(&at), other.hamiltonian(&START));
        assert_eq!(
            flat_field(&own.drift(&at).unwrap()),
            other.drift(&START).unwrap()
        );
        let acceleration = own.acceleration(&at).unwrap();
        assert_eq!(
            flat_field(&acceleration),
            other.acceleration(&START).unwrap()
        );
        assert_eq!(flat_field(&own.noise(&at, &DW)), other.noise(&START, &DW));
        assert_eq!(
            flat_field(&own.ito_correction(&at)),
            other.ito_correction(&START)
        );
    }
    every_type!(check);
    let vectors: Configured<Stirred, Vector2<f64>> = Configured::new(stirred());
    let q = Vector2::new(0.3, -0.2);
    let v = Vector2::new(1.0, 2.0);
    let p: Vector2<f64> = vectors.momentum(q, v);
    assert!((vectors.velocity(q, p).unwrap() - v).norm() < 1e-15);
}

/// One step of a method for both types of configurations.
fn same_step<A, B, Q, const N: usize, const M: usize>(
    method: &A,
    expected: &B,
    start: &State<[f64; N]>,
    dw: &[f64; M],
) where
    A: PlainMethod<System: System<Dims = Dims<N, M, Q>>>,
    B: PlainMethod<System: System<Dims = Dims<N, M>>>,
    Q: Coordinates<N>,
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

#[test]
fn studies_have_the_bits_of_the_coordinates() {
    fn errors<Q: Six>() -> Vec<f64> {
        let integrator = Integrator::new(system::<Q>(), Midpoint);
        let heun = Heun::new(system::<Q>());
        let report = Study::new("charges")
            .start(state::<Q, 6>(&START))
            .horizon(0.4)
            .steps([4, 8])
            .paths(3)
            .method("midpoint", &integrator)
            .method("Heun", &heun)
            .fine(&integrator, 4)
            .observe("energy", Mechanics::hamiltonian)
            .repeats(0)
            .run()
            .unwrap();
        let rows = report.rows().iter();
        rows.map(|row| row.error.unwrap().value).collect()
    }
    let expected = errors::<[f64; 6]>();
    assert_eq!(expected.len(), 4);
    assert!(expected.iter().all(|&error| error > 0.0));
    assert_eq!(errors::<[Vector3<f64>; 2]>(), expected);
}

#[test]
fn the_blocks_of_a_tangent_are_its_entries() {
    let integrator = Integrator::new(system::<[Vector3<f64>; 2]>(), Midpoint);
    let tangent = integrator.tangent(&state(&START), H, &DW).unwrap();
    let whole = tangent.to_dmatrix();
    let [qq, qp] = [tangent.qq(), tangent.qp()];
    let [pq, pp] = [tangent.pq(), tangent.pp()];
    for i in 0..6 {
        for j in 0..6 {
            assert_eq!(qq[(i, j)], tangent[i][j]);
            assert_eq!(qp[(i, j)], tangent[i][6 + j]);
            assert_eq!(pq[(i, j)], tangent[6 + i][j]);
            assert_eq!(pp[(i, j)], tangent[6 + i][6 + j]);
        }
    }
    for i in 0..12 {
        for j in 0..12 {
            assert_eq!(whole[(i, j)], tangent[i][j]);
        }
    }
    // symplectic: MᵀΩM = Ω, in nalgebra's words
    let mut omega = DMatrix::zeros(12, 12);
    for i in 0..6 {
        omega[(i, 6 + i)] = 1.0;
        omega[(6 + i, i)] = -1.0;
    }
    let form = whole.transpose() * &omega * &whole - omega;
    assert!((form.amax() - tangent.symplectic_defect()).abs() < 1e-15);
    assert!(form.amax() < 1e-14);
}

/// A Lagrangian of nested arrays has a nested state, whose symmetries take it.
#[test]
fn the_type_of_the_signature_is_the_type_of_the_state() {
    fn is_type_of<
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
        const N: usize,
        const M: usize,
    >(
        _: &S,
        state: &StateOf<S>,
    ) -> usize {
        state.q.degrees_of_freedom()
    }
    let nested: State<[[f64; 3]; 2]> = state(&START);
    assert_eq!(is_type_of(&charges().0, &nested), 6);
    let momentum = charges().0.rotation_momentum(&nested);
    let by_hand: f64 = (nested.q.iter().zip(&nested.p))
        .map(|(q, p)| q[0] * p[1] - q[1] * p[0])
        .sum();
    assert!((momentum - by_hand).abs() < 1e-15);
    let integrator = Integrator::new(charges().0, Midpoint);
    let mut own = nested;
    integrator.step(&mut own, H, &DW).unwrap();
    let mut other = START;
    let expected = Integrator::new(charges(), Midpoint);
    expected.step(&mut other, H, &DW).unwrap();
    assert_eq!(flat(&own), other);
}
