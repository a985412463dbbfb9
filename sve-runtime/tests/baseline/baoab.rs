//! BAOAB: its formula, exact moments of a harmonic system in equilibrium, and systems that it
//! refuses.

use sve_runtime::baseline::Baoab;
use sve_runtime::prelude::*;

/// Two coordinates of different masses and rates of friction, in a harmonic potential.
#[derive(Clone, Copy)]
struct Harmonic {
    m: [f64; 2],
    k: f64,
    /// Rates of friction.
    nu: [f64; 2],
    kt: f64,
}

#[variational(midpoint)]
impl Harmonic {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * self.m[0] * v[0] * v[0] + 0.5 * self.m[1] * v[1] * v[1]
            - 0.5 * self.k * (q[0] * q[0] + q[0] * q[1] + 2.0 * q[1] * q[1])
    }

    #[force]
    fn friction(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [
            -self.nu[0] * self.m[0] * v[0],
            -self.nu[1] * self.m[1] * v[1],
        ]
    }

    #[gamma]
    fn bath(&self, q: [f64; 2]) -> [f64; 2] {
        [
            (2.0 * self.nu[0] * self.m[0] * self.kt).sqrt() * q[0],
            (2.0 * self.nu[1] * self.m[1] * self.kt).sqrt() * q[1],
        ]
    }
}

const SYSTEM: Harmonic = Harmonic {
    m: [1.0, 2.5],
    k: 1.5,
    nu: [0.7, 2.0],
    kt: 0.4,
};

type Matrix = [[f64; 4]; 4];

fn image(z: [f64; 4], h: f64, dw: [f64; 2]) -> [f64; 4] {
    let mut state = State::new([z[0], z[1]], [z[2], z[3]]);
    Baoab::new(SYSTEM).step(&mut state, h, &dw).unwrap();
    [state.q[0], state.q[1], state.p[0], state.p[1]]
}

/// The covariance in equilibrium, the limit of `C = A C Aᵀ + h B Bᵀ`; A and B are read off the
/// step, which is linear.
fn covariance(h: f64) -> Matrix {
    let unit = |i: usize| core::array::from_fn(|j| f64::from(u8::from(i == j)));
    let a: [[f64; 4]; 4] = core::array::from_fn(|i| image(unit(i), h, [0.0; 2]));
    let b = [
        image([0.0; 4], h, [1.0, 0.0]),
        image([0.0; 4], h, [0.0, 1.0]),
    ];
    let mut c = [[0.0; 4]; 4];
    for _ in 0..20_000 {
        let mut next = [[0.0; 4]; 4];
        for i in 0..4 {
            for j in 0..4 {
                next[i][j] = h * (b[0][i] * b[0][j] + b[1][i] * b[1][j]);
                for k in 0..4 {
                    for l in 0..4 {
                        next[i][j] += a[k][i] * c[k][l] * a[l][j];
                    }
                }
            }
        }
        c = next;
    }
    c
}

/// `kT K⁻¹` for positions at every h. The momenta have an error of order 2.
#[test]
fn positions_in_equilibrium_are_exact() {
    let Harmonic { m, k, kt, .. } = SYSTEM;
    // the inverse of k [[1, ½], [½, 2]]
    let determinant = k * (2.0 - 0.25);
    let exact = [[2.0, -0.5], [-0.5, 1.0]].map(|row| row.map(|x: f64| kt * x / determinant));
    let mut errors = Vec::new();
    for h in [0.1, 0.2, 0.5, 1.0, 1.4] {
        let c = covariance(h);
        for i in 0..2 {
            for j in 0..2 {
                assert!((c[i][j] - exact[i][j]).abs() < 1e-13, "{h}: {c:?}");
                assert!(c[i][j + 2].abs() < 1e-13, "{h}: {c:?}");
            }
        }
        errors.push((c[2][2] - m[0] * kt).abs());
    }
    assert!((errors[1] / errors[0] - 4.0).abs() < 0.05, "{errors:?}");
}

/// One step by hand, with the friction solved exactly.
#[test]
fn a_step_is_that_of_the_formula() {
    struct Well {
        nu: f64,
    }

    #[variational(midpoint)]
    impl Well {
        fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
            v * v - (1.0 + t) * q.powi(4)
        }
        #[force]
        fn friction(&self, q: f64, v: f64) -> f64 {
            1.0 - 2.0 * self.nu * v + q
        }
        #[gamma]
        fn bath(&self, q: f64) -> f64 {
            3.0 * q
        }
    }

    let (h, nu, dw) = (0.2, 0.8, 0.3);
    let (t, mut q, mut p) = (0.5, 0.6, -0.4);
    let mut state = State::at(t, [q], [p]);
    Baoab::new(Well { nu }).step(&mut state, h, &[dw]).unwrap();
    let force = |t: f64, q: f64| -4.0 * (1.0 + t) * q.powi(3) + 1.0 + q;
    p += 0.5 * h * force(t, q);
    q += 0.5 * h * p / 2.0;
    let decay = (-nu * h).exp();
    p = decay * p + ((1.0 - decay * decay) / (2.0 * nu * h)).sqrt() * 3.0 * dw;
    q += 0.5 * h * p / 2.0;
    p += 0.5 * h * force(t + h, q);
    assert!((state.q[0] - q).abs() < 1e-15 && (state.p[0] - p).abs() < 1e-15);
    assert_eq!(state.t, t + h);
}

/// Without friction and noise it is the rule of Störmer and Verlet, and steps back.
#[test]
fn without_a_bath_it_is_leapfrog() {
    struct Pendulum;

    #[variational(stormer_verlet)]
    impl Pendulum {
        fn lagrangian(&self, q: f64, v: f64) -> f64 {
            0.5 * v * v + q.cos()
        }
    }

    let start = State::new([1.0], [0.5]);
    let (mut state, mut expected) = (start, start);
    let method = Baoab::new(Pendulum);
    method.step(&mut state, 0.1, &[]).unwrap();
    Integrator::new(Pendulum, StormerVerlet)
        .step(&mut expected, 0.1, &[])
        .unwrap();
    assert!((state.q[0] - expected.q[0]).abs() < 1e-15);
    assert!((state.p[0] - expected.p[0]).abs() < 1e-15);
    method.step(&mut state, -0.1, &[]).unwrap();
    assert!((state.q[0] - 1.0).abs() < 1e-15 && (state.p[0] - 0.5).abs() < 1e-15);
}

struct Drag;

#[variational(midpoint)]
impl Drag {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - q * q
    }
    #[force]
    fn drag(&self, _q: f64, v: f64) -> f64 {
        -v.powi(3)
    }
}

struct Coupled;

#[variational(midpoint)]
impl Coupled {
    fn lagrangian(&self, _q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1])
    }
    #[force]
    fn friction(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [v[1] - v[0], v[0] - v[1]]
    }
}

struct Shared;

#[variational(midpoint)]
impl Shared {
    fn lagrangian(&self, _q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1])
    }
    #[force]
    fn friction(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [-v[0], -2.0 * v[1]]
    }
    #[gamma]
    fn bath(&self, q: [f64; 2]) -> f64 {
        q[0] + q[1]
    }
}

struct Kubo;

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        q * q + p * p
    }
}

/// A term linear in v: p = v + 1.
struct Shifted;

#[variational(midpoint)]
impl Shifted {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + v - 0.5 * q * q
    }
}

#[test]
fn what_cannot_be_solved_exactly_is_refused() {
    fn check<I: Method>(method: &I, start: sve_runtime::system::StateOf<I::System>, message: &str)
    where
        sve_runtime::system::StateOf<I::System>: PartialEq + core::fmt::Debug,
    {
        let mut state = start;
        let dw = <sve_runtime::system::IncrementsOf<I::System> as sve_runtime::__private::Increments>::NONE;
        let error = method.step(&mut state, 0.1, &dw).unwrap_err();
        assert!(matches!(error, StepError::NotLangevin { .. }), "{error}");
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(state, start);
    }
    let rest = State::new([1.0], [1.0]);
    check(&Baoab::new(Shifted), rest, "not zero at rest");
    let start = State::new([1.0, 2.0], [0.5, 1.0]);
    check(
        &Baoab::new(Drag),
        State::new([1.0], [0.5]),
        "not affine in the velocity",
    );
    check(&Baoab::new(Coupled), start, "couples the momenta");
    check(
        &Baoab::new(Shared),
        start,
        "couples coordinates of different rates",
    );
    check(
        &Baoab::new(Kubo),
        State::new([1.0], [0.5]),
        "depends on the momentum",
    );
}
