//! Kinetic energies of sites that are no sums of `½ m v²`: relativistic ones, masses that are
//! matrices, and terms that are linear in the velocity.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;

use crate::common::{assert_same, spread};

/// Relativistic sites with masses of their own, friction, and noise.
mod relativistic {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { m: Vec<f64>, c: f64, nu: f64, sigma: f64 }
        [f64] 8
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l -= self.m[i] * self.c * self.c * (1.0 - v[i] * v[i] / (self.c * self.c)).sqrt();
                l -= 0.3 * q[i].powi(4);
            }
            for i in 1..q.len() {
                l -= 0.5 * (q[i] - q[i - 1]).powi(2);
            }
            l
        }
        #[gamma]
        each bath(&self, q) -> f64 |i| { self.sigma * q[i] }
        #[force]
        each drag(&self, q, v) -> f64 |i| { -self.nu * self.m[i] * v[i] + 0.1 * q[i].sin() }
    }
}

/// Bodies whose mass is a matrix, with a constant vector potential, in two loops: momenta are
/// affine.
mod matrices {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { m: Vec<f64>, off: Vec<f64>, a: [f64; 2], nu: f64 }
        [[f64; 2]] 12
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                let (x, y) = (v[i][0], v[i][1]);
                l += 0.5 * self.m[i] * (x * x + 2.0 * y * y) + self.off[i] * x * y;
                l -= (q[i][0] * q[i][1]).cos();
            }
            for i in 1..q.len() {
                l += self.a[0] * v[i - 1][0] + self.a[1] * v[i][1] + 0.1 * v[i][1] * v[i][1];
                l -= 0.5 * (q[i][0] - q[i - 1][1]).powi(2);
            }
            l
        }
        #[force]
        each drag(&self, q, v) -> [f64; 2] |i| { [-self.nu * v[i][0], 0.2 - 2.0 * self.nu * v[i][1]] }
    }
}

/// Relativistic bodies in a constant vector potential, and what some of them have beside.
mod bodies {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        explicit struct { a: Vector3<f64>, k: f64 }
        [Vector3<f64>] 8
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += self.a.dot(&v[i]) - (1.0 - v[i].norm_squared()).sqrt();
                for j in 0..i {
                    l += 1.0 / (1.0 + (q[i] - q[j]).norm_squared()).sqrt();
                }
            }
            for i in 0..q.len() {
                if i % 3 == 1 {
                    l += self.k * v[i][0] * v[i][2] + v[i][1].powi(4);
                }
            }
            l
        }
    }
}

fn small(n: usize, seed: u64, scale: f64) -> Vec<f64> {
    spread(n, seed).iter().map(|x| scale * x).collect()
}

fn masses(n: usize) -> Vec<f64> {
    spread(n, 3).iter().map(|x| 2.0 + x).collect()
}

fn pairs(seed: u64) -> [[f64; 2]; 12] {
    let x = spread(24, seed);
    std::array::from_fn(|i| [x[2 * i], x[2 * i + 1]])
}

fn vectors(seed: u64, scale: f64) -> [Vector3<f64>; 8] {
    let x = small(24, seed, scale);
    std::array::from_fn(|i| Vector3::from_column_slice(&x[3 * i..3 * i + 3]))
}

#[test]
fn steps_are_those_of_unrolled_systems() {
    let numbers = |seed, scale| -> [f64; 8] { small(8, seed, scale).try_into().expect("eight") };
    // momenta up to m c/2 and up to 4 m c: unrolled steps compute some momenta from velocities,
    // whose rounding errors grow with γ²
    for size in [0.5, 4.0] {
        compare!(
            explicit relativistic {
                m: masses(8),
                c: 1.2,
                nu: 0.6,
                sigma: 0.4
            },
            numbers(1, 1.0),
            numbers(2, size),
            numbers(4, 0.2)
        );
        compare!(
            explicit bodies {
                a: Vector3::new(0.3, -0.2, 0.1),
                k: 0.2
            },
            vectors(5, 1.0),
            vectors(6, size),
            []
        );
    }
    compare!(
        explicit matrices {
            m: masses(12),
            off: small(12, 8, 0.5),
            a: [0.4, -0.7],
            nu: 0.5
        },
        pairs(1),
        pairs(2),
        []
    );
}

/// Energies, velocities and temperatures of both systems of [`both`], and the way back from
/// velocities.
macro_rules! compare_mechanics {
    ($module:ident { $($field:ident: $value:expr),* $(,)? }, $q:expr, $p:expr) => {{
        let scene = $module::scene::System { $($field: $value),* };
        let unrolled = $module::unrolled::System { $($field: $value),* };
        let (state, expected) = (State::new($q.to_vec(), $p.to_vec()), State::new($q, $p));
        let v = unrolled.velocity(&expected).expect("a velocity");
        let found = SceneMechanics::velocity(&scene, &state).expect("a velocity");
        assert_same(&State::new(found.clone(), found), &v, &v, "velocity");
        let numbers = [
            (scene.hamiltonian(&state), unrolled.hamiltonian(&expected)),
            (scene.temperature(&state), unrolled.temperature(&expected)),
        ];
        for (found, expected) in numbers {
            let (found, expected) = (found.expect("a number"), expected.expect("a number"));
            assert!((found - expected).abs() <= 1e-13 * expected.abs(), "{found} {expected}");
        }
        let back = scene.state_with_velocity(0.0, $q.to_vec(), v.to_vec()).expect("a state");
        let unrolled = State::from_velocity(&unrolled, $q, v).expect("a state");
        assert_same(&back, &unrolled.q, &unrolled.p, "momentum");
    }};
}

#[test]
fn mechanics_is_that_of_unrolled_systems() {
    let numbers = |seed, scale| -> [f64; 8] { small(8, seed, scale).try_into().expect("eight") };
    compare_mechanics!(
        relativistic {
            m: masses(8),
            c: 1.2,
            nu: 0.6,
            sigma: 0.4
        },
        numbers(1, 1.0),
        numbers(2, 3.0)
    );
    compare_mechanics!(
        bodies {
            a: Vector3::new(0.3, -0.2, 0.1),
            k: 0.2
        },
        vectors(5, 1.0),
        vectors(6, 3.0)
    );
    compare_mechanics!(
        matrices {
            m: masses(12),
            off: small(12, 8, 0.5),
            a: [0.4, -0.7],
            nu: 0.5
        },
        pairs(1),
        pairs(2)
    );
}

/// A free relativistic site moves with v = p/√(m² + p²/c²), whatever its momentum, and 300 sites
/// do in blocks of steps.
#[test]
fn free_relativistic_sites_move_with_their_velocity() {
    struct Free {
        m: Vec<f64>,
        c: f64,
    }
    #[variational(stormer_verlet)]
    impl Free {
        fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
            let c2 = self.c * self.c;
            v.iter()
                .zip(&self.m)
                .map(|(v, m)| -m * c2 * (1.0 - v * v / c2).sqrt())
                .sum()
        }
    }
    let (n, h, steps) = (300, 0.1, 70);
    let m = masses(n);
    let p: Vec<f64> = spread(n, 5)
        .iter()
        .enumerate()
        .map(|(i, x)| x * 10f64.powi(i as i32 % 7 - 3))
        .collect();
    let free = Integrator::new(
        Free {
            m: m.clone(),
            c: 3.0,
        },
        StormerVerlet,
    );
    let mut path = free.trajectory(State::new(vec![0.0; n], p.clone()), h, NoNoise);
    let end = path.advance(steps).expect("steps");
    for i in 0..n {
        let v = p[i] / (m[i] * m[i] + p[i] * p[i] / 9.0).sqrt();
        let way = v * h * steps as f64;
        assert!(
            (end.q[i] - way).abs() <= 1e-14 * way.abs(),
            "{i}: {} {way}",
            end.q[i]
        );
        assert_eq!(end.p[i], p[i]);
    }
}

/// A step over h and back returns, and the energy of a step of length h has an error of order 2.
#[test]
fn stormer_verlet_is_symmetric_and_of_order_two() {
    let system = bodies::scene::System {
        a: Vector3::new(0.3, -0.2, 0.1),
        k: 0.2,
    };
    let start = State::new(vectors(5, 1.0).to_vec(), vectors(6, 0.5).to_vec());
    let bodies = Integrator::new(&system, StormerVerlet);
    assert_eq!(bodies.plan().kind(), BlockKind::Newton);
    let mut state = start.clone();
    bodies.step(&mut state, 0.1, &[]).expect("a step");
    bodies.step(&mut state, -0.1, &[]).expect("a step back");
    assert_same(&state, &start.q, &start.p, "back");
    let before = system.hamiltonian(&start).expect("an energy");
    let drift = |steps: u64| {
        let mut path = bodies.trajectory(start.clone(), 1.0 / steps as f64, NoNoise);
        let after = system.hamiltonian(path.advance(steps).expect("steps"));
        (after.expect("an energy") - before).abs()
    };
    let order = (drift(40) / drift(80)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

#[test]
fn a_site_without_a_velocity_is_named() {
    struct Bounded {
        m: Vec<f64>,
    }
    #[variational(endpoint)]
    impl Bounded {
        fn lagrangian(&self, _q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
            let mut l = 0.0;
            for i in 0..self.m.len() {
                l += self.m[i] * (1.0 + v[i][0] * v[i][0] + v[i][1] * v[i][1]).sqrt();
            }
            l
        }
    }
    let bounded = Integrator::new(
        Bounded {
            m: vec![1.0, 2.0, 1.0],
        },
        Endpoint,
    );
    let q = vec![[0.0; 2]; 3];
    let start = State::new(q.clone(), vec![[0.5, 0.0], [1.5, 0.1], [0.0, 1.1]]);
    let mut state = start.clone();
    let error = bounded
        .step(&mut state, 0.1, &[])
        .expect_err("a momentum above m");
    let StepError::Site { site: 2, error } = &error else {
        panic!("{error}");
    };
    assert!(matches!(**error, StepError::NoVelocity { .. }), "{error}");
    assert_eq!(state, start);
    // a site that no term mentions
    let mut state = State::new(vec![[0.0; 2]; 4], vec![[0.1; 2]; 4]);
    let error = bounded.step(&mut state, 0.1, &[]).expect_err("no mass");
    let StepError::Site { site: 3, error } = &error else {
        panic!("{error}");
    };
    assert!(matches!(**error, StepError::SingularMass { .. }), "{error}");
    // a loop over more sites than there are
    let mut state = State::new(vec![[0.0; 2]; 2], vec![[0.1; 2]; 2]);
    let error = bounded.step(&mut state, 0.1, &[]).expect_err("an index");
    assert!(
        matches!(
            error,
            StepError::Index {
                index: 2,
                length: 2,
                ..
            }
        ),
        "{error}"
    );
    // a number that is not finite is named as in other scenes
    let mut state = State::new(q.clone(), vec![[0.1, 0.1], [0.1, f64::NAN], [0.0; 2]]);
    let error = bounded.step(&mut state, 0.1, &[]).expect_err("not finite");
    let StepError::NonFiniteInput { what, .. } = &error else {
        panic!("{error}");
    };
    assert_eq!(what, "p[1][1]");
}

/// Where a function in T is not defined, its derivative may be finite: ½ v² + ln(1 + v) has no
/// velocity below −1 for any momentum.
#[test]
fn velocities_are_in_the_domain_of_the_kinetic_energy() {
    struct Logarithm;
    #[variational(endpoint)]
    impl Logarithm {
        fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
            v.iter().map(|v| 0.05 * v * v - (1.0 + v).ln()).sum()
        }
    }
    // p = v/10 − 1/(1 + v), in the domain an increasing function
    for p in [-1e4, -1.0, 0.0, 3.0] {
        let state = State::new(vec![0.0], vec![p]);
        let v = SceneMechanics::velocity(&Logarithm, &state).expect("a velocity")[0];
        assert!(
            v > -1.0 && (0.1 * v - 1.0 / (1.0 + v) - p).abs() <= 1e-12 * p.abs().max(1.0),
            "{v}"
        );
    }
    let error = Logarithm.state_with_velocity(0.0, vec![0.0; 2], vec![0.0, -2.0]);
    let error = error.expect_err("ln(−1)");
    assert!(matches!(error, StepError::Site { site: 1, .. }), "{error}");
}
