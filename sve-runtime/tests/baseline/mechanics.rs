//! Legendre transform, energy, drift, acceleration and Itô correction.

use sve_runtime::__private::Field;
use sve_runtime::system::{Dims, LagrangianJet, NoiseJet, System};
use sve_runtime::{Mechanics, State, StepError};

use crate::models::{Damped, Kubo, Oscillator, Pendulum, Polar, Relativistic};
use crate::random::Random;

/// A central difference of vectors: error of order `1e-4² = 1e-8`, rounding `1e-12`.
const D: f64 = 1e-4;
const NEAR: f64 = 1e-6;

fn difference<const N: usize>(f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let (plus, minus) = (f(D), f(-D));
    core::array::from_fn(|i| (plus[i] - minus[i]) / (2.0 * D))
}

fn moved<const N: usize>(x: &[f64; N], i: usize, by: f64) -> [f64; N] {
    let mut x = *x;
    x[i] += by;
    x
}

#[track_caller]
fn assert_near<const N: usize>(a: [f64; N], b: [f64; N], tolerance: f64) {
    for i in 0..N {
        assert!(
            (a[i] - b[i]).abs() <= tolerance * (1.0 + a[i].abs()),
            "{a:?} is not {b:?}"
        );
    }
}

/// States (q, v) in the domain of every model: `|v| < 1`, `r > 0`.
fn samples<const N: usize>() -> Vec<(f64, [f64; N], [f64; N])> {
    let mut random = Random::new(7);
    (0..20)
        .map(|_| {
            let t = random.between(0.0, 2.0);
            let q = core::array::from_fn(|_| random.between(0.5, 2.0));
            (t, q, core::array::from_fn(|_| random.between(-0.6, 0.6)))
        })
        .collect()
}

/// Everything that follows from a Lagrangian, on one model.
fn check<S, const N: usize, const M: usize>(system: &S)
where
    S: System<Dims = Dims<N, M>>,
{
    for (t, q, v) in samples::<N>() {
        check_lagrangian_jet(system, t, &q, &v);
        check_noise_jets(system, t, &q, &v);

        let p = system.momentum_at(t, q, v);
        let state = State { t, q, p };
        // twice the rounding of the transform, times its condition number (below 10 here)
        assert_near(system.velocity(&State::at(t, q, p)).unwrap(), v, 1e-14);

        let energy = system.hamiltonian(&state).unwrap();
        let by_hand = p.iter().zip(&v).map(|(p, v)| p * v).sum::<f64>()
            - system.lagrangian_jet(t, &q, &v).value;
        assert!((energy - by_hand).abs() < 1e-13 * (1.0 + energy.abs()));

        // Hamilton's equations: (v, L_q) = (∂H/∂p, −∂H/∂q)
        let drift = system.drift(&state).unwrap();
        assert_near(drift.q, v, 1e-14);
        for i in 0..N {
            let h = |q, p| system.hamiltonian(&State { t, q, p }).unwrap();
            let [along_p] = difference(|d| [h(q, moved(&p, i, d))]);
            let [along_q] = difference(|d| [h(moved(&q, i, d), p)]);
            assert_near([drift.q[i], drift.p[i]], [along_p, -along_q], NEAR);
        }

        // z̈ = (Df) f + ∂f/∂t, the change of the drift along the motion
        let second = system.acceleration(&state).unwrap();
        let along = |d: f64| {
            let mut state = state;
            state.t += d;
            for i in 0..N {
                state.q[i] += d * drift.q[i];
                state.p[i] += d * drift.p[i];
            }
            system.drift(&state).unwrap()
        };
        assert_near(second.q, difference(|d| along(d).q), NEAR);
        assert_near(second.p, difference(|d| along(d).p), NEAR);

        check_noise_fields(system, &state);
    }
}

fn check_lagrangian_jet<S, const N: usize, const M: usize>(
    system: &S,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) where
    S: System<Dims = Dims<N, M>>,
{
    let jet = system.lagrangian_jet(t, q, v);
    let by = |f: &dyn Fn(&LagrangianJet<N>) -> [f64; N], t: f64, q: [f64; N], v: [f64; N]| {
        f(&system.lagrangian_jet(t, &q, &v))
    };
    for i in 0..N {
        let value = |jet: &LagrangianJet<N>| [jet.value; N];
        let dq = |jet: &LagrangianJet<N>| jet.dq;
        let dv = |jet: &LagrangianJet<N>| jet.dv;
        assert_near(
            [jet.dq[i]; N],
            difference(|d| by(&value, t, moved(q, i, d), *v)),
            NEAR,
        );
        assert_near(
            [jet.dv[i]; N],
            difference(|d| by(&value, t, *q, moved(v, i, d))),
            NEAR,
        );
        assert_near(
            jet.dqq[i],
            difference(|d| by(&dq, t, moved(q, i, d), *v)),
            NEAR,
        );
        assert_near(
            jet.dqv[i],
            difference(|d| by(&dv, t, moved(q, i, d), *v)),
            NEAR,
        );
        assert_near(
            jet.dvv[i],
            difference(|d| by(&dv, t, *q, moved(v, i, d))),
            NEAR,
        );
    }
    assert_near(
        jet.dqt,
        difference(|d| system.lagrangian_jet(t + d, q, v).dq),
        NEAR,
    );
    assert_near(
        jet.dvt,
        difference(|d| system.lagrangian_jet(t + d, q, v).dv),
        NEAR,
    );
}

fn check_noise_jets<S, const N: usize, const M: usize>(
    system: &S,
    t: f64,
    q: &[f64; N],
    p: &[f64; N],
) where
    S: System<Dims = Dims<N, M>>,
{
    let jets = system.noise_jets(t, q, p);
    for (a, jet) in jets.iter().enumerate() {
        let at = |q: [f64; N], p: [f64; N]| -> NoiseJet<N> { system.noise_jets(t, &q, &p)[a] };
        for i in 0..N {
            assert_near(jet.dqq[i], difference(|d| at(moved(q, i, d), *p).dq), NEAR);
            assert_near(jet.dqp[i], difference(|d| at(moved(q, i, d), *p).dp), NEAR);
            assert_near(jet.dpp[i], difference(|d| at(*q, moved(p, i, d)).dp), NEAR);
        }
    }
}

/// `½ Σ (Dg_a) g_a` is half the change of each field along itself.
fn check_noise_fields<S, const N: usize, const M: usize>(system: &S, state: &State<[f64; N]>)
where
    S: System<Dims = Dims<N, M>>,
{
    let mut expected = Field {
        q: [0.0; N],
        p: [0.0; N],
    };
    for a in 0..M {
        let mut unit = [0.0; M];
        unit[a] = 1.0;
        let g = system.noise(state, &unit);
        let along = |d: f64| {
            let mut state = *state;
            for i in 0..N {
                state.q[i] += d * g.q[i];
                state.p[i] += d * g.p[i];
            }
            system.noise(&state, &unit)
        };
        let (q, p) = (difference(|d| along(d).q), difference(|d| along(d).p));
        for i in 0..N {
            expected.q[i] += 0.5 * q[i];
            expected.p[i] += 0.5 * p[i];
        }
    }
    let correction = system.ito_correction(state);
    assert_near(correction.q, expected.q, NEAR);
    assert_near(correction.p, expected.p, NEAR);
}

#[test]
fn oscillator() {
    check(&Oscillator { sigma: 0.7 });
}

#[test]
fn kubo() {
    check(&Kubo { a: 1.5, sigma: 0.8 });
}

#[test]
fn pendulum() {
    check(&Pendulum { g: 9.8 });
}

#[test]
fn polar() {
    check(&Polar {
        m: 1.3,
        k: 0.9,
        sigma: [0.4, 0.6],
    });
}

#[test]
fn damped() {
    check(&Damped {
        c: 0.4,
        k: 2.0,
        b: 0.7,
    });
}

#[test]
fn relativistic() {
    check(&Relativistic::<1> { k: 2.0 });
    check(&Relativistic::<2> { k: 2.0 });
}

#[test]
fn correction_of_kubo_is_exact() {
    // σ = ¾: all products are exact
    let kubo = Kubo {
        a: 1.0,
        sigma: 0.75,
    };
    let c = kubo.ito_correction(&State::new([0.5], [-2.0]));
    assert_eq!(c.q, [-0.75 * 0.75 / 2.0 * 0.5]);
    assert_eq!(c.p, [-0.75 * 0.75 / 2.0 * -2.0]);
    let n = kubo.noise(&State::new([0.5], [-2.0]), &[0.5]);
    assert_eq!((n.q, n.p), ([-0.75], [-0.1875]));
}

#[test]
fn fast_particles_have_a_velocity() {
    // v = p/√(1 + p²), to twice the tolerance of Newton's method (its residual is relative
    // to |p| + |L_v|): the first Newton step from rest leaves |v| < 1, and near 1 the momentum is
    // resolved only to ε p², so that its residual cannot reach rounding level although the velocity
    // is exact to it
    let particle = Relativistic::<1> { k: 0.0 };
    for exponent in -40..=80 {
        let p = 10.0_f64.powf(f64::from(exponent) / 11.0);
        let v = particle.velocity(&State::new([0.0], [p])).unwrap();
        let exact = p / (1.0 + p * p).sqrt();
        assert!(
            (v[0] - exact).abs() <= 1e-15 * exact,
            "p = {p}: {v:?}, {exact}"
        );
        assert_eq!(
            particle.velocity(&State::new([0.0], [-p])).unwrap(),
            [-v[0]]
        );
    }
    assert_eq!(particle.velocity(&State::new([0.0], [0.0])).unwrap(), [0.0]);
    let particle = Relativistic::<3> { k: 0.0 };
    let p = [3.0, -40.0, 0.5];
    let norm = p.iter().map(|p| p * p).sum::<f64>();
    let v = particle.velocity(&State::new([0.0; 3], p)).unwrap();
    for i in 0..3 {
        assert!((v[i] - p[i] / (1.0 + norm).sqrt()).abs() < 1e-15);
    }
}

#[test]
fn a_momentum_without_velocity_is_an_error() {
    // below 1 the largest double has momentum 6.7e7
    let particle = Relativistic::<1> { k: 0.0 };
    match particle.velocity(&State::new([0.0], [1e9])) {
        Err(StepError::NoVelocity { reached, .. }) => assert!(reached < 0.1, "{reached}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn nothing_non_finite_is_returned() {
    // the potential k/r is not defined at r = 0, where with a momentum along r alone the velocity
    // would be
    let polar = Polar {
        m: 1.0,
        k: 1.0,
        sigma: [0.0; 2],
    };
    let state = State::new([0.0, 0.0], [1.0, 0.0]);
    assert!(matches!(
        polar.drift(&state),
        Err(StepError::SingularMass { .. })
    ));
    let kubo = Kubo {
        a: 1e200,
        sigma: 0.0,
    };
    let state = State::new([1e200], [0.0]);
    assert!(matches!(
        kubo.drift(&state),
        Err(StepError::NonFiniteResult { .. })
    ));
    assert!(matches!(
        kubo.acceleration(&state),
        Err(StepError::NonFiniteResult { .. })
    ));
    assert!(matches!(
        kubo.hamiltonian(&state),
        Err(StepError::NonFiniteResult { .. })
    ));
    let state = State::new([f64::NAN], [0.0]);
    assert!(matches!(
        kubo.drift(&state),
        Err(StepError::NonFiniteInput { .. })
    ));
    assert!(matches!(
        Relativistic::<1> { k: 1.0 }.velocity(&State::new([0.0], [f64::NAN])),
        Err(StepError::NonFiniteInput { .. })
    ));
}
