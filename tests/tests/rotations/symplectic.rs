//! Steps are symplectic on the cotangent bundle, with noise; tangent maps and sensitivities are
//! those of differences.

use sve_runtime::__private::Coordinates;
use sve_runtime::Variational;
use sve_runtime::nalgebra::{DMatrix, Matrix3};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::charts::{Chart, differences, symplectic_defect};
use crate::starts::{body, pair, three};
use crate::systems::{
    DRIVEN, FreeBody, HeavyTop, I, NOISY_BODY, SYMMETRIC_TOP, TETHERED, THREE, TOP,
};

/// Compares the tangent map of a step with differences. Returns the symplectic defects of both.
fn check<S, R, Q, const N: usize, const M: usize>(
    system: S,
    rule: R,
    start: State<Q>,
    dw: [f64; M],
) -> [f64; 2]
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    R: Copy,
    Q: Coordinates<N>,
    State<Q>: Chart,
{
    let integrator = Integrator::new(system, rule);
    let h = 0.1;
    let tangent = integrator.tangent(&start, h, &dw).unwrap();
    let numeric = differences(&start, |state| {
        let mut state = *state;
        integrator.step(&mut state, h, &dw).unwrap();
        state
    });
    let error = (tangent.to_dmatrix() - &numeric).amax();
    assert!(error < 2e-10, "tangent map {error:e}");
    let exact = tangent.symplectic_defect();
    println!("differences {error:e}, defect {exact:e}");
    [exact, symplectic_defect(&numeric)]
}

fn assert_symplectic(defects: [f64; 2]) {
    let [exact, numeric] = defects;
    assert!(exact < 1e-14, "{exact:e}");
    // differences of sixth order
    assert!(numeric < 1e-9, "{numeric:e}");
}

#[test]
fn steps_of_one_body_are_symplectic() {
    assert_symplectic(check(FreeBody { i: I }, Midpoint, body(), []));
    assert_symplectic(check(NOISY_BODY, Midpoint, body(), [0.3, -0.4]));
    assert_symplectic(check(TOP, Midpoint, body(), [0.4]));
    assert_symplectic(check(SYMMETRIC_TOP, Midpoint, body(), [0.4, -0.3]));
    assert_symplectic(check(NOISY_BODY, StormerVerlet, body(), [0.3, -0.4]));
    assert_symplectic(check(TOP, StormerVerlet, body(), [0.4]));
    assert_symplectic(check(SYMMETRIC_TOP, StormerVerlet, body(), [0.4, -0.3]));
}

#[test]
fn steps_beside_a_vector_are_symplectic() {
    assert_symplectic(check(TETHERED, Midpoint, pair(), [0.4, -0.3]));
    assert_symplectic(check(TETHERED, StormerVerlet, pair(), [0.4, -0.3]));
}

#[test]
fn steps_of_three_bodies_are_symplectic() {
    assert_symplectic(check(THREE, Midpoint, three(), [0.4]));
    assert_symplectic(check(THREE, StormerVerlet, three(), [0.4]));
}

#[test]
fn friction_is_not_symplectic_and_its_tangent_map_is_that_of_differences() {
    for [exact, numeric] in [
        check(DRIVEN, Midpoint, body(), []),
        check(DRIVEN, StormerVerlet, body(), []),
    ] {
        assert!(exact > 1e-3 && (exact - numeric).abs() < 1e-9);
    }
}

/// The midpoint rule in the chart around R₀, frozen during the step: S = h L(R₀ cay(½(x₀ + x₁)),
/// A(½(x₀ + x₁)) (x₁ − x₀)/h), of which the derivative by the centre of the chart is missing.
fn frozen_chart(
    top: &HeavyTop,
    (r, pi): (UnitQuaternion<f64>, Vector3<f64>),
    h: f64,
) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let matrix = *r.to_rotation_matrix().matrix();
    let action = |x0: Vector3<f64>, x1: Vector3<f64>| {
        let (x, v) = (0.5 * (x0 + x1), (x1 - x0) / h);
        let scale = 1.0 / (1.0 + 0.25 * x.norm_squared());
        let hat = x.cross_matrix();
        let turned = matrix * (Matrix3::identity() + scale * (hat + 0.5 * hat * hat));
        let w = scale * (v - 0.5 * x.cross(&v));
        h * top.lagrangian(Rotation3::from_matrix_unchecked(turned), w)
    };
    let slope = |f: &dyn Fn(Vector3<f64>) -> f64, at: Vector3<f64>| {
        Vector3::from_fn(|k, _| {
            let mut unit = Vector3::zeros();
            unit[k] = 1e-2;
            let weights = [0.75, -0.15, 1.0 / 60.0];
            let terms = weights.iter().zip(1..).map(|(weight, n)| {
                weight * (f(at + f64::from(n) * unit) - f(at - f64::from(n) * unit)) / 1e-2
            });
            terms.sum()
        })
    };
    let residual = |x: Vector3<f64>| pi + slope(&|x0| action(x0, x), Vector3::zeros());
    let mut x = h * pi.component_div(&I);
    for _ in 0..40 {
        // the mass matrix over h is close to the Jacobian: ∂(−∂S/∂x₀)/∂x₁
        x += h * residual(x).component_div(&I);
    }
    let y = slope(&|x1| action(Vector3::zeros(), x1), x);
    let pi = y - 0.5 * x.cross(&y) + 0.25 * x * x.dot(&y);
    let half = sve_runtime::nalgebra::Quaternion::from_parts(1.0, 0.5 * x);
    (r * UnitQuaternion::from_quaternion(half), pi)
}

/// The test of symplecticity finds what is wrong: a step that does not differentiate the chart.
#[test]
fn a_chart_that_does_not_move_is_not_symplectic() {
    let top = HeavyTop { s: 0.0, ..TOP };
    let (start, h) = (body(), 0.1);
    let at = (start.q, start.p);
    let wrong = differences(&at, |at| frozen_chart(&top, *at, h));
    let defect = symplectic_defect(&wrong);
    println!("frozen chart {defect:e}");
    assert!(defect > 1e-6, "{defect:e}");
    // it approximates the same motion
    let mut state = start;
    Integrator::new(top, Midpoint)
        .step(&mut state, h, &[0.0])
        .unwrap();
    let (_, pi) = frozen_chart(&top, at, h);
    assert!((pi - state.p).norm() < 1e-2 && (pi - state.p).norm() > 1e-7);
}

#[test]
fn the_derivative_by_a_parameter_is_that_of_differences() {
    let top = |weight: f64| Integrator::new(HeavyTop { weight, ..TOP }, Midpoint);
    let (start, h, dw) = (body(), 0.1, [0.4]);
    let at = |weight: f64| {
        let mut state = start;
        top(weight).step(&mut state, h, &dw).unwrap();
        state
    };
    let end = at(2.0);
    let sensitivity = top(2.0).sensitivity(&start, h, &dw).unwrap();
    let found = sensitivity.get("weight").unwrap();
    let (ahead, behind) = (end.coordinates(&at(2.001)), end.coordinates(&at(1.999)));
    let expected: Vec<f64> = (0..6).map(|i| (ahead[i] - behind[i]) / 2e-3).collect();
    let found: Vec<f64> = found.q.iter().chain(found.p.iter()).copied().collect();
    let error = DMatrix::from_vec(6, 1, found) - DMatrix::from_vec(6, 1, expected);
    assert!(error.amax() < 1e-8, "{}", error.amax());
}
