//! Steps preserve the two-form: to rounding in the affine and the internal form, up to O(h⁵) where
//! they are projected.

use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{CoordinateRole, Dims, LagrangianJet, System};

use sve_models::degenerate::{
    CubicLotkaVolterra, Drift, InternalLotkaVolterra, Joint, Kubo, LotkaVolterra,
    MassWithAffinePair, MassWithPair, Spin, Vortices,
};

/// The vectors tangent to the consistent states at a state: one for each coordinate, and one for
/// the momentum of each massive coordinate.
fn tangent_vectors<S, Q, const N: usize, const M: usize>(
    system: &S,
    state: &State<Q>,
) -> Vec<Vec<f64>>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let jet: LagrangianJet<N> = system.lagrangian_jet(state.t, &state.q.coordinates(), &[0.0; N]);
    let is = |i: usize, role| S::ROLES[i] == role;
    let mut vectors = Vec::new();
    for k in 0..N {
        if is(k, CoordinateRole::Algebraic) {
            continue;
        }
        let mut along_q = vec![0.0; 2 * N];
        along_q[k] = 1.0;
        for i in (0..N).filter(|&i| is(i, CoordinateRole::Massless)) {
            along_q[N + i] = jet.dqv[k][i];
        }
        vectors.push(along_q);
        if is(k, CoordinateRole::Massive) {
            let mut along_p = vec![0.0; 2 * N];
            along_p[N + k] = 1.0;
            vectors.push(along_p);
        }
    }
    vectors
}

/// The canonical two-form, dp ∧ dq.
fn canonical(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() / 2;
    (0..n).map(|i| a[n + i] * b[i] - a[i] * b[n + i]).sum()
}

/// The largest change of the two-form in a step, on all pairs of tangent vectors.
fn defect<S, R, Q, const N: usize, const M: usize>(
    system: S,
    rule: R,
    (q, p): (Q, [f64; N]),
    h: f64,
    dw: [f64; M],
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let integrator = Integrator::new(system, rule);
    let mut state = State::from_configuration(integrator.system(), q).unwrap();
    let mut momentum = Q::components(&state.p);
    for i in 0..N {
        if S::ROLES[i] == CoordinateRole::Massive {
            momentum[i] = p[i];
        }
    }
    state.p = Q::from_components(&momentum);
    let tangent = integrator.tangent(&state, h, &dw).unwrap();
    let vectors = tangent_vectors(integrator.system(), &state);
    let image = |x: &Vec<f64>| -> Vec<f64> {
        let row = |i: usize| tangent[i].iter().zip(x).map(|(a, b)| a * b).sum();
        (0..2 * N).map(row).collect()
    };
    let images: Vec<Vec<f64>> = vectors.iter().map(image).collect();
    let mut worst = 0.0f64;
    for (a, image_a) in vectors.iter().zip(&images) {
        for (b, image_b) in vectors.iter().zip(&images) {
            worst = worst.max((canonical(image_a, image_b) - canonical(a, b)).abs());
        }
    }
    worst
}

/// A start of two coordinates without mass.
const PLANE: ([f64; 2], [f64; 2]) = ([1.5, 0.8], [0.0; 2]);

/// A start of a mass and two coordinates without mass.
const PAIR: ([f64; 3], [f64; 3]) = ([0.5, 0.3, -0.4], [0.7, 0.0, 0.0]);

#[test]
fn reduced_forms_preserve_the_two_form() {
    let four = Vortices {
        strength: [1.0, -0.7, 0.5, 1.3],
    };
    let corners = [[0.0, 1.0], [1.1, 0.2], [-0.9, -0.3], [0.2, -1.2]];
    let joint = Joint { k: 2.0 };
    let start = ([0.8, 0.4], [0.5, 0.0]);
    let jolt = [0.2, -0.3];
    let found = [
        defect(LotkaVolterra, Midpoint, PLANE, 0.1, [0.3]),
        defect(InternalLotkaVolterra, Midpoint, PLANE, 0.1, [0.3]),
        defect(InternalLotkaVolterra, Endpoint, PLANE, 0.1, [0.3]),
        defect(InternalLotkaVolterra, InitialPoint, PLANE, 0.1, [0.3]),
        defect(Kubo, Midpoint, PLANE, 0.1, [0.3]),
        defect(Kubo, Endpoint, PLANE, 0.1, [0.3]),
        defect(Kubo, InitialPoint, PLANE, 0.1, [0.3]),
        defect(four, Midpoint, (corners, [0.0; 8]), 0.1, [0.2, -0.1]),
        defect(four, Endpoint, (corners, [0.0; 8]), 0.05, [0.02, -0.01]),
        defect(four, InitialPoint, (corners, [0.0; 8]), 0.05, [0.02, -0.01]),
        defect(MassWithAffinePair, Midpoint, PAIR, 0.1, [0.2, 0.1]),
        defect(joint, Midpoint, start, 0.1, jolt),
        defect(joint, Endpoint, start, 0.1, jolt),
        defect(joint, InitialPoint, start, 0.1, jolt),
    ];
    println!("{found:?}");
    assert!(found.iter().all(|&defect| defect < 1e-14), "{found:?}");
}

/// The defects for step sizes that are halved.
fn defects<S, Q, const N: usize, const M: usize>(system: S, start: (Q, [f64; N])) -> [f64; 4]
where
    S: Variational<Midpoint> + System<Dims = Dims<N, M, Q>> + Copy,
    Q: VectorCoordinates<N>,
{
    [0.2, 0.1, 0.05, 0.025].map(|h| defect(system, Midpoint, start, h, [0.0; M]))
}

#[test]
fn projected_steps_preserve_the_two_form_to_fifth_order() {
    let mass = MassWithPair { mass: 1.5 };
    let found = [
        ("LV, cubic gauge", defects(CubicLotkaVolterra, PLANE)),
        ("spin", defects(Spin, PLANE)),
        ("drift", defects(Drift, PLANE)),
        ("mass with a pair", defects(mass, PAIR)),
    ];
    for (name, defects) in found {
        let orders = [0, 1, 2].map(|k| (defects[k] / defects[k + 1]).log2());
        println!("{name}: {defects:?}, orders {orders:?}");
        assert!(defects[0] > 1e-8, "{name} has no defect to measure");
        assert!((4.7..5.3).contains(&orders[2]), "{name}: {orders:?}");
    }
}
