//! Chains and rings, with masses of their own and with noise.

use sve_runtime::prelude::*;

use crate::common::spread;

mod free {
    use sve_runtime::prelude::*;
    both! {
        struct { mass: Vec<f64>, beta: f64 }
        [f64] 9
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.mass[i] * v[i] * v[i];
            }
            for i in 1..q.len() {
                let d = q[i] - q[i - 1];
                l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
            }
            l
        }
    }
}

mod fixed {
    use sve_runtime::prelude::*;
    both! {
        struct { k: Vec<f64>, g: f64 }
        [f64] 8
        |self, q, v| {
            let n = q.len();
            let mut l = 0.0;
            for i in 0..n {
                l += 0.5 * v[i].powi(2) + self.g * q[i].cos() * (1.0 + 0.1 * (i as f64));
                if i == 0 {
                    l -= 0.3 * q[i].powi(2);
                } else {
                    l -= 0.5 * self.k[i] * (q[i] - q[i - 1]).powi(2);
                }
            }
            l - 0.7 * q[n - 1].powi(2) + 0.05 * q[0] * q[n - 1]
        }
    }
}

macro_rules! rings {
    ($($name:ident $n:literal),*) => {$(
        mod $name {
            use sve_runtime::prelude::*;
            both! {
                struct { g: f64 }
                [f64] $n
                |self, q, v| {
                    let n = q.len();
                    let mut l = 0.0;
                    for i in 0..n {
                        let next = q[(i + 1) % n];
                        l += 0.5 * v[i] * v[i] - self.g * (1.0 - (next - q[i]).cos()) - 0.1 * q[i] * next;
                    }
                    l
                }
            }
        }
    )*};
}
rings!(one 1, two 2, three 3, eight 8);

mod each {
    use sve_runtime::prelude::*;
    both! {
        struct { sigma: Vec<f64> }
        [f64] 8
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.25 * q[i].powi(4);
            }
            for i in 1..q.len() {
                l -= 0.5 * (q[i] - q[i - 1]).powi(2);
            }
            l
        }
        #[gamma]
        each bath(&self, q) -> f64 |i| { self.sigma[i] * q[i] * q[i] }
    }
}

mod listed {
    use sve_runtime::prelude::*;
    both! {
        struct { sigma: f64 }
        [f64] 8
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.25 * q[i].powi(4);
            }
            l
        }
        #[gamma]
        fn two(&self, q) -> [f64; 2] {
            let mut even = 0.0;
            let mut all = 0.0;
            for i in 0..q.len() {
                if i % 2 == 0 {
                    even += q[i].sin();
                }
                all += q[i] * q[i];
            }
            [self.sigma * even, self.sigma * (all + even)]
        }
    }
}

fn array<const N: usize>(seed: u64) -> [f64; N] {
    spread(N, seed).try_into().expect("the length")
}

#[test]
fn chains_step_as_unrolled_ones() {
    let mass: Vec<f64> = (0..9).map(|i| 1.0 + 0.2 * f64::from(i)).collect();
    compare!(
        free {
            mass: mass.clone(),
            beta: 0.7
        },
        array::<9>(1),
        array::<9>(2),
        []
    );
    compare!(
        fixed {
            k: mass.clone(),
            g: 0.4
        },
        array::<8>(3),
        array::<8>(4),
        []
    );
}

#[test]
fn rings_of_any_length_step_as_unrolled_ones() {
    compare!(one { g: 0.8 }, array::<1>(5), array::<1>(6), []);
    compare!(two { g: 0.8 }, array::<2>(5), array::<2>(6), []);
    compare!(three { g: 0.8 }, array::<3>(5), array::<3>(6), []);
    compare!(eight { g: 0.8 }, array::<8>(5), array::<8>(6), []);
}

#[test]
fn noisy_chains_step_as_unrolled_ones() {
    let sigma = spread(8, 9);
    compare!(
        each {
            sigma: sigma.clone()
        },
        array::<8>(7),
        array::<8>(8),
        array::<8>(10)
    );
    compare!(
        compositions each {
            sigma: sigma.clone()
        },
        array::<8>(7),
        array::<8>(8),
        array::<8>(10)
    );
    compare!(
        listed { sigma: 0.6 },
        array::<8>(7),
        array::<8>(8),
        [0.3, -0.2]
    );
}

/// The processes of functions that return numbers come first, whatever the order of the functions.
#[test]
fn processes_of_sites_follow_the_listed_ones() {
    struct Mixed;
    #[variational(endpoint)]
    impl Mixed {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.0 * q[i];
            }
            l
        }
        #[gamma]
        fn sites(&self, q: &[f64]) -> Vec<f64> {
            q.iter().map(|q| 2.0 * q).collect()
        }
        #[gamma]
        fn all(&self, q: &[f64]) -> f64 {
            q.iter().sum::<f64>()
        }
    }
    let mut state = State::new(vec![0.0; 3], vec![0.0; 3]);
    let integrator = Integrator::new(Mixed, Endpoint);
    integrator
        .step(&mut state, 0.1, &[0.5, 1.0, 2.0, 3.0])
        .expect("a step");
    assert_eq!(state.p, [2.5, 4.5, 6.5]);
    let error = integrator
        .step(&mut state, 0.1, &[0.5, 1.0])
        .expect_err("four processes");
    assert_eq!(state.p, [2.5, 4.5, 6.5]);
    assert!(error.to_string().contains('4'), "{error}");
}

/// Trajectories of scenes are iterators as others are, also where they are borrowed: adapters that
/// fold them compile.
#[test]
fn borrowed_trajectories_are_folded() {
    struct Springs;
    #[variational(endpoint)]
    impl Springs {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            (0..q.len())
                .map(|i| 0.5 * (v[i] * v[i] - q[i] * q[i]))
                .sum()
        }
    }
    let springs = Integrator::new(Springs, Endpoint);
    let start = State::new(vec![1.0; 3], vec![0.0; 3]);
    let mut path = springs.trajectory(start, 0.125, NoNoise);
    assert!(path.by_ref().take(4).all(|state| state.is_ok()));
    let mut saved = path.every(2);
    let last = saved.by_ref().take(3).last();
    assert_eq!(last.expect("a state").expect("a step").t, 1.0);
}
