//! Mechanics and tangent maps return vectors of the type of the configuration.

use sve_models::configured::Configured;
use sve_models::models::Stirred;
use sve_models::oracle::{charges, stirred};
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::nalgebra::DMatrix;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, StateOf, System};

use crate::{DW, H, START, Six, every_type, flat, flat_field, state, system};

#[test]
fn mechanics_returns_the_types_of_the_configuration() {
    fn check<Q: Six>() {
        let (own, other) = (system::<Q>(), system::<[f64; 6]>());
        let State { t, q, p } = state::<Q, 6>(&START);
        let v = own.velocity(&State::at(t, q, p)).unwrap();
        assert_eq!(
            Q::components(&v),
            other.velocity(&State::at(t, START.q, START.p)).unwrap()
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
    assert!((vectors.velocity(&State::new(q, p)).unwrap() - v).norm() < 1e-15);
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
        Q: VectorCoordinates<N>,
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
