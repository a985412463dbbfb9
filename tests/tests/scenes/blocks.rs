//! Inner loops over consecutive sites, which are made in blocks.

use sve_runtime::nalgebra::{self, Vector3};
use sve_runtime::prelude::*;

use crate::common::spread;

/// Loops over many consecutive sites, some of them shifted, with numbers of fields of two types.
struct Stars {
    mass: Vec<f64>,
    light: nalgebra::DVector<f64>,
    coupling: f64,
    shift: usize,
}

#[variational(endpoint, midpoint)]
impl Stars {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i].norm_squared();
            for j in 0..i {
                let d = q[i] - q[j];
                l += self.mass[i] * self.mass[j] / (d.norm_squared() + 0.3).sqrt();
            }
        }
        for i in 0..q.len() {
            for j in i + 1..q.len() - 1 {
                l += self.coupling * self.mass[j + self.shift] * (q[i].x * q[j + 1].y).cos();
            }
            for j in 2..i {
                l -= self.coupling * self.light[j] * (q[j - 2].z - q[i].z).powi(2);
            }
        }
        l
    }
}

impl Stars {
    fn new(n: usize) -> Self {
        let positive = |seed| spread(n, seed).into_iter().map(|x| 1.2 + x);
        Self {
            mass: positive(1).collect(),
            light: nalgebra::DVector::from_iterator(n, positive(2)),
            coupling: 0.01,
            shift: 1,
        }
    }

    /// The impulses over the time h.
    fn impulses(&self, q: &[Vector3<f64>], h: f64) -> Vec<Vector3<f64>> {
        let n = q.len();
        let mut all = vec![Vector3::zeros(); n];
        for i in 0..n {
            for j in 0..i {
                let d = q[i] - q[j];
                let r = (d.norm_squared() + 0.3).sqrt();
                let force = -self.mass[i] * self.mass[j] / r.powi(3) * d;
                all[i] += h * force;
                all[j] -= h * force;
            }
            for j in i + 1..n - 1 {
                let (x, y) = (q[i].x, q[j + 1].y);
                let force = -self.coupling * self.mass[j + 1] * (x * y).sin();
                all[i].x += h * force * y;
                all[j + 1].y += h * force * x;
            }
            for j in 2..i {
                let force = 2.0 * self.coupling * self.light[j] * (q[j - 2].z - q[i].z);
                all[i].z += h * force;
                all[j - 2].z -= h * force;
            }
        }
        all
    }
}

/// Loops of 32 rounds and more are made in blocks of 16; shorter ones as they are written.
#[test]
fn loops_in_blocks_have_the_impulses_of_loops_by_hand() {
    let h = 0.01;
    for n in [3, 32, 33, 48, 97, 160] {
        let stars = Stars::new(n);
        let rows = |seed| -> Vec<Vector3<f64>> {
            let numbers = spread(3 * n, seed);
            numbers.chunks(3).map(Vector3::from_column_slice).collect()
        };
        let (q, p) = (rows(3), rows(4));
        let found = impulses!(&stars, q, Vector3::zeros(), h, &[]);
        let expected = stars.impulses(&q, h);
        let largest = expected.iter().map(Vector3::amax).fold(0.0, f64::max);
        for (i, (x, y)) in found.iter().zip(&expected).enumerate() {
            assert!((x - y).amax() < 1e-14 * largest, "{n} {i}: {x} {y}");
        }
        // bounds of slopes are made in blocks too
        let mut state = State::new(q.clone(), p.clone());
        let integrator = Integrator::new(&stars, Midpoint);
        integrator.step(&mut state, h, &[]).expect("a step");
        let mut d = vec![Vector3::zeros(); n];
        for _ in 0..40 {
            let nodes: Vec<_> = q.iter().zip(&d).map(|(q, d)| q + 0.5 * d).collect();
            let impulses = stars.impulses(&nodes, h);
            d = (0..n).map(|i| h * (p[i] + 0.5 * impulses[i])).collect();
        }
        for i in 0..n {
            let error = (state.q[i] - q[i] - d[i]).amax();
            assert!(error < 1e-14, "{n} {i}: {error:e}");
        }
    }
}

/// An index that is out of range within a loop in blocks is found where it is used first.
#[test]
fn loops_in_blocks_find_indices_out_of_range() {
    let stars = Stars {
        shift: 2,
        ..Stars::new(64)
    };
    let rows: Vec<Vector3<f64>> = vec![Vector3::new(0.1, 0.2, 0.3); 64];
    let mut state = State::new(rows.clone(), rows);
    let made = Integrator::new(&stars, Endpoint).step(&mut state, 0.1, &[]);
    let Err(StepError::Index {
        text,
        index,
        length,
        ..
    }) = made
    else {
        panic!("{made:?}");
    };
    let expected = "`self.mass[j + self.shift]` in `lagrangian` (i = 0, j = 62)";
    assert_eq!(&*text, expected);
    assert_eq!((index, length), (64, 64));
}
