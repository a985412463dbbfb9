//! Inner sums that enter formulas of the sum around them: densities at atoms, and sums within sums.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use crate::common::spread;

/// Atoms embedded in the density of the others, each with a factor that depends on its own place.
mod embedded {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        explicit struct { m: Vec<f64>, a: f64 }
        [Vector3<f64>] 6
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.m[i] * v[i].norm_squared();
                let mut density = 0.0;
                for j in 0..q.len() {
                    if j != i {
                        density += (-(q[i] - q[j]).norm_squared()).exp();
                    }
                }
                l += self.a * (1.0 + 0.2 * q[i][0]) * (0.1 + density).sqrt();
            }
            l
        }
    }
}

/// Three levels, of which two enter formulas, times a sum that does not; a mean field of densities;
/// and a noise of each site by its density.
mod nested {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { g: f64, sigma: f64 }
        [f64] 7
        |self, q, v| {
            let n = q.len();
            let mut l = 0.0;
            let mut all = 0.0;
            for i in 0..n {
                l += 0.5 * v[i] * v[i];
                let mut outer = 0.0;
                for j in 0..n {
                    let mut inner = 0.0;
                    for k in 0..j {
                        inner += (q[j] * q[k] - 0.3 * q[i]).sin();
                    }
                    outer += inner * inner * (q[i] - q[j]).cos();
                }
                l -= self.g * outer * outer * q[(i + 1) % n];
                all += (1.0 + outer * outer).ln();
            }
            l - 0.1 * all * all
        }
        gamma {
            fn bath(&self, q: &[f64]) -> Vec<f64> {
                (0..q.len())
                    .map(|i| {
                        let s = q.iter().map(|x| (x - q[i]).cos()).sum::<f64>();
                        self.sigma * s * s
                    })
                    .collect()
            }
        } or {
            fn bath(&self, q: [f64; 7]) -> [f64; 7] {
                let mut gamma = [0.0; 7];
                for i in 0..7 {
                    let mut s = 0.0;
                    for j in 0..7 {
                        s += (q[j] - q[i]).cos();
                    }
                    gamma[i] = self.sigma * s * s;
                }
                gamma
            }
        }
        force {
            fn push(&self, q: &[f64], _v: &[f64]) -> Vec<f64> {
                (0..q.len())
                    .map(|i| {
                        let s = q.iter().map(|x| (x * q[i]).sin()).sum::<f64>();
                        0.2 * s * s
                    })
                    .collect()
            }
        } or {
            fn push(&self, q: [f64; 7], _v: [f64; 7]) -> [f64; 7] {
                let mut f = [0.0; 7];
                for i in 0..7 {
                    let mut s = 0.0;
                    for j in 0..7 {
                        s += (q[j] * q[i]).sin();
                    }
                    f[i] = 0.2 * s * s;
                }
                f
            }
        }
    }
}

/// Formulas of sums alone: the weight of the innermost sum is found through those around it.
mod tower {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { g: f64 }
        [f64] 6
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i];
                let mut outer = 0.0;
                for j in 0..q.len() {
                    let mut inner = 0.0;
                    for k in 0..q.len() {
                        inner += ((i + 2 * j) as f64 * q[k]).cos();
                    }
                    outer += inner * inner;
                }
                l -= self.g * outer.sqrt();
            }
            l
        }
    }
}

#[test]
fn formulas_of_sums_alone_step_like_unrolled_ones() {
    let [q, p]: [[f64; 6]; 2] = [1, 2].map(|seed| spread(6, seed).try_into().expect("6 numbers"));
    compare!(explicit tower { g: 0.3 }, q, p, []);
}

#[test]
fn embedded_atoms_step_like_unrolled_ones() {
    let m: Vec<f64> = (1..=6).map(f64::from).collect();
    let rows = |seed| -> [Vector3<f64>; 6] {
        let numbers = spread(18, seed);
        std::array::from_fn(|i| Vector3::from_column_slice(&numbers[3 * i..3 * i + 3]))
    };
    compare!(
        explicit embedded {
            m: m.clone(),
            a: 0.7
        },
        rows(5),
        rows(6),
        []
    );
}

#[test]
fn sums_within_sums_step_like_unrolled_ones() {
    let [q, p, dw]: [[f64; 7]; 3] =
        [1, 2, 3].map(|seed| spread(7, seed).try_into().expect("7 numbers"));
    compare!(
        explicit nested {
            g: 0.05,
            sigma: 0.02
        },
        q,
        p,
        dw.map(|x| 0.1 * x)
    );
}

#[test]
fn energies_of_inner_sums_are_those_of_the_users_function() {
    let (g, sigma) = (0.05, 0.02);
    let system = nested::scene::System { g, sigma };
    let state = State::new(spread(20, 1), vec![0.0; 20]);
    let expected = -system.lagrangian(&state.q, &state.p);
    let found = system.hamiltonian(&state).expect("an energy");
    assert!((found - expected).abs() < 1e-13 * expected.abs());
}

/// A condition outside of all loops guards the sums in it.
#[test]
fn a_sum_under_a_condition_is_computed_where_it_holds() {
    struct Guarded {
        on: usize,
        weight: Vec<f64>,
    }
    #[variational(endpoint)]
    impl Guarded {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            if self.on > 0 {
                let s = (0..q.len()).map(|i| self.weight[i] * q[i]).sum::<f64>();
                l -= 0.5 * s * s;
            }
            l
        }
    }
    let q = vec![1.0, 2.0];
    for (on, weight, p) in [(0, vec![], [0.0, 0.0]), (1, vec![1.0, 3.0], [-1.75, -5.25])] {
        let mut state = State::new(q.clone(), vec![0.0; 2]);
        let guarded = Integrator::new(Guarded { on, weight }, Endpoint);
        guarded.step(&mut state, 0.25, &[]).expect("a step");
        assert_eq!(state.p, p);
    }
}

/// Closures within closures have counters of different names.
#[test]
fn the_plan_lists_inner_sums() {
    let (g, sigma) = (0.05, 0.02);
    let plan = Integrator::new(nested::scene::System { g, sigma }, Endpoint).plan();
    let plan = plan.to_string();
    let line = " += cos(q[j] − q[i]) for i in 0..q.len(), for j in 0..q.len()";
    assert!(plan.contains(line), "{plan}");
}
