//! Forces: friction of each site, pushes, and forces of neighbours.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use crate::common::spread;

mod chain {
    use sve_runtime::prelude::*;
    both! {
        struct { nu: Vec<f64>, sigma: f64, push: f64 }
        [f64] 9
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.3 * q[i].powi(4);
            }
            for i in 1..q.len() {
                l -= 0.5 * (q[i] - q[i - 1]).powi(2);
            }
            l
        }
        #[gamma]
        each bath(&self, q) -> f64 |i| { self.sigma * q[i] }
        #[force]
        each drag(&self, q, v; t) -> f64 |i| {
            -self.nu[i] * v[i] + self.push * (t + q[i]).sin() * (i as f64)
        }
    }
}

/// A wind that blows from site to site, and a swirl that no potential has.
mod bodies {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        struct { m: Vec<f64>, nu: f64, swirl: f64 }
        [Vector3<f64>] 5
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.m[i] * v[i].norm_squared();
                for j in 0..i {
                    l += 1.0 / (1.0 + (q[i] - q[j]).norm_squared()).sqrt();
                }
            }
            l
        }
        #[force]
        each wind(&self, q, v) -> Vector3<f64> |i| {
            let next = q[(i + 1) % q.len()];
            let mut f = next * (self.swirl * q[i][0]) - v[i] * (self.nu * self.m[i]);
            for j in 0..q.len() {
                f[1] += 0.1 * (q[j][0] - q[i][2]).sin();
            }
            f
        }
    }
}

#[test]
fn forces_of_scenes_are_those_of_unrolled_systems() {
    let numbers = |seed| -> [f64; 9] { spread(9, seed).try_into().expect("nine") };
    let nu: Vec<f64> = spread(9, 3).iter().map(|x| 2.0 + x).collect();
    compare!(
        chain {
            nu: nu.clone(),
            sigma: 0.4,
            push: 0.7
        },
        numbers(1),
        numbers(2),
        numbers(4).map(|x| 0.2 * x)
    );
    compare!(
        compositions chain {
            nu: nu.clone(),
            sigma: 0.4,
            push: 0.7
        },
        numbers(1),
        numbers(2),
        numbers(4).map(|x| 0.2 * x)
    );
    let vectors = |seed| -> [Vector3<f64>; 5] {
        let x = spread(15, seed);
        std::array::from_fn(|i| Vector3::from_column_slice(&x[3 * i..3 * i + 3]))
    };
    compare!(
        bodies {
            m: vec![1.0, 2.0, 0.5, 1.5, 3.0],
            nu: 0.8,
            swirl: 0.3
        },
        vectors(5),
        vectors(6),
        []
    );
}

/// A million free sites with friction stop as one does: with `a = h ν/(2 m)`, a step of Störmer and
/// Verlet multiplies the momentum by (1 − a)/(1 + a).
#[test]
fn friction_alone_is_exact_in_blocks_of_steps() {
    struct Free {
        nu: f64,
    }
    #[variational(stormer_verlet)]
    impl Free {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            (0..q.len()).map(|i| v[i] * v[i]).sum()
        }
        #[force]
        fn drag(&self, _q: &[f64], v: &[f64]) -> Vec<f64> {
            v.iter().map(|v| -self.nu * v).collect()
        }
    }
    let (n, h, steps) = (3000, 0.1, 200);
    let free = Integrator::new(Free { nu: 0.4 }, StormerVerlet);
    let start = State::new(vec![0.0; n], spread(n, 7));
    let mut path = free.trajectory(start.clone(), h, NoNoise);
    let end = path.advance(steps).expect("steps");
    let a = 0.5 * h * 0.4 / 2.0;
    let factor = ((1.0 - a) / (1.0 + a)).powi(steps as i32);
    // d = h p/(1 + a)/m summed over the steps is a geometric series: the way is (p₀ − p₁)/ν
    for i in 0..n {
        let (p, q) = (factor * start.p[i], (1.0 - factor) * start.p[i] / 0.4);
        assert!((end.p[i] - p).abs() < 1e-14, "{i}: {} {p}", end.p[i]);
        assert!((end.q[i] - q).abs() < 1e-13, "{i}: {} {q}", end.q[i]);
    }
}

/// A block of steps has the bits of single steps.
#[test]
fn trajectories_with_friction_have_the_bits_of_single_steps() {
    let system = chain::scene::System {
        nu: vec![0.5; 9],
        sigma: 0.0,
        push: 0.2,
    };
    let chain = Integrator::new(system, StormerVerlet);
    let start = State::new(spread(9, 1), spread(9, 2));
    let mut path = chain.trajectory(start.clone(), 0.05, Wiener::new(1));
    let end = path.advance(100).expect("steps").clone();
    let mut single = chain.trajectory(start, 0.05, Wiener::new(1));
    for _ in 0..100 {
        single.advance(1).expect("a step");
    }
    assert_eq!(&end, single.advance(0).expect("the state"));
}

#[test]
fn a_force_has_an_entry_for_each_site() {
    struct Short {
        to: usize,
    }
    #[variational(endpoint)]
    impl Short {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            (0..q.len()).map(|i| 0.5 * v[i] * v[i]).sum()
        }
        #[force]
        fn push(&self, q: &[f64], _v: &[f64]) -> Vec<f64> {
            (0..self.to).map(|i| -q[i]).collect()
        }
    }
    for to in [2, 3, 4] {
        let short = Integrator::new(Short { to }, Endpoint);
        let mut state = State::new(vec![1.0; 3], vec![0.5; 3]);
        let before = state.clone();
        let step = short.step(&mut state, 0.1, &[]);
        if to == 3 {
            assert_eq!(step, Ok(()));
            assert_eq!(state.p, vec![0.5 - 0.1 * 1.05; 3]);
            continue;
        }
        let error = step.expect_err("another length");
        let what = "the result of `push`".into();
        let expected = StepError::Length {
            t: 0.0,
            what,
            found: to,
            expected: 3,
        };
        assert_eq!(error, expected);
        assert_eq!(state, before);
    }
}
