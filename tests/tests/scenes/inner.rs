//! Inner sums that enter formulas of the sum around them: densities at atoms, and sums within sums.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use crate::common::spread;

/// Atoms embedded in the density of the others, each with a factor that depends on its own place.
mod embedded {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        struct { m: Vec<f64>, a: f64 }
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
        struct { g: f64, sigma: f64 }
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
            l - self.g * all * all
        }
        #[gamma]
        each bath(&self, q) -> f64 |i| {
            let s = q.iter().map(|x| (x - q[i]).cos()).sum::<f64>();
            self.sigma * s * s
        }
        #[force]
        each push(&self, q, _v) -> f64 |i| {
            let s = q.iter().map(|x| (x * q[i]).sin()).sum::<f64>();
            0.02 * s * s
        }
    }
}

/// Formulas of sums alone: the weight of the innermost sum is found through those around it.
mod tower {
    use sve_runtime::prelude::*;
    both! {
        struct { g: f64 }
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
    // bounds of sums of sums are wide unless the motion is small
    compare!(tower { g: 0.1 }, q, p.map(|x| 0.1 * x), []);
}

#[test]
fn embedded_atoms_step_like_unrolled_ones() {
    let m: Vec<f64> = (1..=6).map(f64::from).collect();
    let rows = |seed| -> [Vector3<f64>; 6] {
        let numbers = spread(18, seed);
        std::array::from_fn(|i| Vector3::from_column_slice(&numbers[3 * i..3 * i + 3]))
    };
    compare!(
        embedded {
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
        nested {
            g: 0.01,
            sigma: 0.02
        },
        q,
        p.map(|x| 0.1 * x),
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

/// Atoms in a periodic box, of which those within a cut-off add to a density, and each of which
/// sits in the field of a total of all densities.
struct Metal {
    side: f64,
    cut2: f64,
    mean: f64,
}

#[variational(midpoint, endpoint)]
impl Metal {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        let mut all = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i].norm_squared();
            let mut density = 0.0;
            for j in 0..q.len() {
                if j != i {
                    let mut r2 = 0.0;
                    for k in 0..3 {
                        let d = q[i][k] - q[j][k];
                        r2 += (d - self.side * (d / self.side).round()).powi(2);
                    }
                    if r2 < self.cut2 {
                        density += (1.0 - r2 / self.cut2).powi(4);
                        l -= 0.3 * (1.0 - r2 / self.cut2).powi(6);
                    }
                }
            }
            l += (0.2 + density).sqrt();
            all += density;
        }
        l - self.mean * all * all / q.len() as f64
    }
}

/// The solution of a midpoint step is that of a fixed-point iteration with the impulses of the
/// endpoint rule.
#[test]
fn midpoint_steps_of_embedded_atoms_solve_their_equations() {
    let metal = Metal {
        side: 3.0,
        cut2: 1.5,
        mean: 0.1,
    };
    let n = 60;
    let rows = |seed| -> Vec<Vector3<f64>> {
        let numbers = spread(3 * n, seed);
        let rows = numbers.chunks(3);
        rows.map(|x| 1.5 * Vector3::from_column_slice(x)).collect()
    };
    let (q, p, h) = (rows(7), rows(8), 5e-3);
    let mut state = State::new(q.clone(), p.clone());
    Integrator::new(&metal, Midpoint)
        .step(&mut state, h, &[])
        .expect("a step");
    let (mut d, mut impulse) = (vec![Vector3::zeros(); n], Vec::new());
    for _ in 0..60 {
        let node: Vec<_> = q.iter().zip(&d).map(|(q, d)| q + 0.5 * d).collect();
        impulse = impulses!(&metal, node, Vector3::zeros(), h, &[]);
        d = (0..n).map(|i| h * (p[i] + 0.5 * impulse[i])).collect();
    }
    for i in 0..n {
        let [x, y] = [state.q[i] - (q[i] + d[i]), state.p[i] - (p[i] + impulse[i])];
        assert!(x.amax() < 4e-15 && y.amax() < 4e-15, "{i}: {x} {y}");
    }
}

/// Returns the smallest and the largest row sum of h/4 times −∂I/∂q by Gershgorin, from differences
/// of the impulses `of`.
fn row_sums(q: &[f64], h: f64, of: impl Fn(&[f64]) -> Vec<f64>) -> [f64; 2] {
    let (n, e) = (q.len(), 1e-5);
    let columns: Vec<Vec<f64>> = (0..n)
        .map(|j| {
            let [a, b] = [-e, e].map(|e| {
                let mut q = q.to_vec();
                q[j] += e;
                of(&q)
            });
            let slope = a
                .iter()
                .zip(&b)
                .map(|(a, b)| 0.25 * h * (a - b) / (2.0 * e));
            slope.collect()
        })
        .collect();
    let mut found = [f64::INFINITY, f64::NEG_INFINITY];
    for i in 0..n {
        let others = (0..n).filter(|&j| j != i).map(|j| columns[j][i].abs());
        let others: f64 = others.sum();
        found[0] = found[0].min(columns[i][i] - others);
        found[1] = found[1].max(columns[i][i] + others);
    }
    found
}

/// At rest and in a short step the boxes are points or nearly so, and only the triangle inequality
/// is between bounds and row sums.
#[test]
fn bounds_of_sums_contain_the_row_sums_of_differences() {
    let check = |result: Result<(), StepError>, [low, high]: [f64; 2]| {
        let Err(StepError::Stiff { bounds, .. }) = result else {
            panic!("{result:?}");
        };
        let size = 1e-7 * (high - low);
        assert!(
            bounds[0] <= low + size && high - size <= bounds[1],
            "{bounds:?} {low} {high}"
        );
        (bounds[1] - bounds[0]) / (high - low)
    };
    let n = 12;
    let rows = |numbers: &[f64]| -> Vec<Vector3<f64>> {
        let rows = numbers.chunks(3);
        rows.map(Vector3::from_column_slice).collect()
    };
    for seed in 1..20 {
        let q = spread(3 * n, seed);
        let p = spread(3 * n, seed + 40);
        for (mean, h, speed) in [(0.0, 2.0, 0.0), (0.1, 2.0, 0.0), (1e7, 1e-3, 1.0)] {
            let (side, cut2) = (3.0, 1.5);
            let metal = Metal { side, cut2, mean };
            let [q, p] = [q.clone(), p.iter().map(|p| speed * p).collect()];
            for part in [0.0, 0.2, 0.5] {
                let node: Vec<f64> = q.iter().zip(&p).map(|(q, p)| q + part * h * p).collect();
                let found = row_sums(&node, h, |q| {
                    let impulses = impulses!(&metal, rows(q), Vector3::zeros(), h, &[]);
                    impulses.iter().flatten().copied().collect()
                });
                let mut state = State::new(rows(&q), rows(&p));
                let result = Integrator::new(&metal, Midpoint).step(&mut state, h, &[]);
                let ratio = check(result, found);
                assert!(ratio < 10.0, "{ratio}");
            }
        }
        let system = nested::scene::System {
            g: 0.05,
            sigma: 0.3,
        };
        let (h, dw) = (2.0, spread(7, seed + 20));
        let mut state = State::new(q[..7].to_vec(), vec![0.0; 7]);
        let result = Integrator::new(&system, Midpoint).step(&mut state, h, &dw);
        let found = row_sums(&q[..7], h, |q| impulses!(&system, q, 0.0, h, &dw));
        // the magnitudes of 7³ numbers of different signs
        let ratio = check(result, found);
        assert!(ratio < 100.0, "{ratio}");
    }
}
