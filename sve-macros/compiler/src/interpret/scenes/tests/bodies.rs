//! Bodies in space, and noise.

use std::collections::HashMap;

use super::{Field, compare, read, rows};
use crate::algebra::tests::recipe::Random;
use crate::model::scene::Processes;

fn squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Pairs within a cut-off, bonds and angles, by vectors and by arrays.
#[test]
fn molecules() {
    let vectors = "fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for (i, v) in v.iter().enumerate() { l += 0.5 * self.mass[i] * v.norm_squared() - self.field.dot(&q[i]); }
        for i in 0..q.len() {
            for j in i + 1..q.len() {
                let r2 = (q[i] - q[j]).norm_squared();
                if r2 > self.cut2 { continue; }
                l -= self.eps / r2;
            }
            l -= (q[i] - self.anchor[i]).norm();
        }
        for &[i, j, k] in self.angles.iter() {
            let (a, b) = (q[i] - q[j], q[k] - q[j]);
            l -= a.dot(&b) / (a.norm() * b.norm());
        }
        l
    }";
    let arrays = "fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            for k in 0..3 { l += 0.5 * self.mass[i] * v[i][k].powi(2) - self.field[k] * q[i][k]; }
            let d = [q[i][0] - self.anchor[i][0], q[i][1] - self.anchor[i][1], q[i][2] - self.anchor[i][2]];
            l -= d.iter().map(|d| d * d).sum::<f64>().sqrt();
            l -= (i + 1..q.len()).map(|j| self.pair(&q[i], q[j])).sum::<f64>();
        }
        for angle in &self.angles {
            let [a, b, c] = [q[angle[0]], q[angle[1]], q[angle[2]]];
            let mut dot = 0.0;
            for k in 0..3 { dot += (a[k] - b[k]) * (c[k] - b[k]); }
            l -= dot / (Self::squared(a, b) * Self::squared(c, b)).sqrt();
        }
        l
    }
    fn pair(&self, a: &[f64; 3], b: [f64; 3]) -> f64 {
        let r2 = Self::squared(*a, b);
        if r2 <= self.cut2 { self.eps / r2 } else { 0.0 }
    }
    fn squared(a: [f64; 3], b: [f64; 3]) -> f64 { (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>() }";
    let (mass, field) = ([1.0, 2.0, 3.0, 4.0, 5.0], [0.1, 0.2, -9.8]);
    let anchors = rows(5, 3, &mut Random(8));
    let angles = [[0, 1, 2], [3, 1, 4], [2, 4, 0]];
    let anchor: Vec<Field> = anchors.iter().map(|row| Field::numbers(row)).collect();
    let fields = HashMap::from([
        ("mass", Field::numbers(&mass)),
        ("field", Field::numbers(&field)),
        ("cut2", Field::Number(1.1)),
        ("eps", Field::Number(0.3)),
        ("anchor", Field::List(anchor)),
        (
            "angles",
            Field::List(angles.iter().map(|a| Field::integers(a)).collect()),
        ),
    ]);
    for body in [vectors, arrays] {
        compare(body, &fields, &[5], |q, v| {
            let mut l = 0.0;
            for i in 0..5 {
                let v2: f64 = v[i].iter().map(|v| v * v).sum();
                let work: f64 = q[i].iter().zip(&field).map(|(q, g)| q * g).sum();
                l += 0.5 * mass[i] * v2 - work - squared(&q[i], &anchors[i]).sqrt();
                let pairs = (i + 1..5).map(|j| squared(&q[i], &q[j]));
                l -= pairs
                    .filter(|&r2| r2 <= 1.1)
                    .map(|r2| 0.3 / r2)
                    .sum::<f64>();
            }
            for [i, j, k] in angles {
                let dot: f64 = (0..3)
                    .map(|c| (q[i][c] - q[j][c]) * (q[k][c] - q[j][c]))
                    .sum();
                l -= dot / (squared(&q[i], &q[j]) * squared(&q[k], &q[j])).sqrt();
            }
            l
        });
    }
}

/// A process a site, and a few processes.
#[test]
fn noises() {
    let lagrangian = "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 { v.iter().map(|v| 0.5 * v * v).sum::<f64>() }";
    let noises = "
        #[gamma] fn bath(&self, q: &[f64]) -> Vec<f64> { (1..q.len()).map(|i| self.sigma * q[i] * i as f64).collect() }
        #[gamma] fn all(&self, t: f64, q: &[f64]) -> f64 { let mut sum = 0.0; for x in q { sum += x.sin(); } t * sum }
        #[gamma] fn ends(&self, q: &[f64]) -> [f64; 2] { [q[0], q[q.len() - 1].powi(2)] }
        #[gamma] fn other(&self, q: &[f64]) -> Vec<f64> { q.iter().map(|x| x * x).collect::<Vec<f64>>() }";
    let read = read(&format!("{lagrangian} {noises}"));
    let fields = HashMap::from([("sigma", Field::Number(0.2))]);
    let q = rows(4, 1, &mut Random(5));
    let mut data = read.data(&fields, &q, &q);
    let values: Vec<Vec<f64>> = (read.scene.noises.iter())
        .map(|noise| match &noise.processes {
            Processes::Listed(values) => values.iter().map(|&e| data.number(e, None)).collect(),
            Processes::Each(sums) => data.terms(sums[0].0, &read.scene.sums[sums[0].0]),
        })
        .collect();
    let x: Vec<f64> = q.iter().map(|row| row[0]).collect();
    let expected = [
        (1..4).map(|i| 0.2 * x[i] * i as f64).collect(),
        vec![0.7 * x.iter().map(|x| x.sin()).sum::<f64>()],
        vec![x[0], x[3] * x[3]],
        x.iter().map(|x| x * x).collect::<Vec<f64>>(),
    ];
    assert_eq!(values.len(), expected.len());
    for (values, expected) in values.iter().zip(&expected) {
        assert_eq!(values.len(), expected.len());
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-14, "{value}, not {expected}");
        }
    }
}
