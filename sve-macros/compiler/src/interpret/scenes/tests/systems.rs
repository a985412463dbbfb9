//! Chains, rings, lattices and lists of numbers.

use std::collections::HashMap;

use super::{Field, compare};

fn no_fields() -> HashMap<&'static str, Field> {
    HashMap::new()
}

fn kinetic(v: &[Vec<f64>]) -> f64 {
    v.iter().map(|v| 0.5 * v[0] * v[0]).sum()
}

#[test]
fn chain() {
    let body = "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n { l += 0.5 * self.mass[i] * v[i].powi(2) - self.site(q[i]); }
        for i in 1..n { let d = q[i] - q[i - 1]; l -= 0.5 * self.k * d * d + 0.25 * d.powi(4); }
        l
    }
    fn site(&self, x: f64) -> f64 { (1.0 - x.cos()) * self.depth }";
    let mass: Vec<f64> = (0..20).map(|i| 1.0 + f64::from(i)).collect();
    let fields = HashMap::from([
        ("mass", Field::numbers(&mass)),
        ("k", Field::Number(1.5)),
        ("depth", Field::Number(0.3)),
    ]);
    compare(body, &fields, &[0, 1, 2, 17], |q, v| {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * mass[i] * v[i][0].powi(2) - 0.3 * (1.0 - q[i][0].cos());
        }
        for i in 1..q.len() {
            let d = q[i][0] - q[i - 1][0];
            l -= 0.75 * d * d + 0.25 * d.powi(4);
        }
        l
    });
}

/// The same ring in several spellings.
#[test]
fn rings_and_iterators() {
    let heads = [
        "for i in 0..q.len() { l -= self.bond(q[(i + 1) % q.len()] - q[i]); }",
        "for (i, x) in q.iter().enumerate() { l -= self.bond(q[(i + 1) % q.len()] - x); }",
        "let n = q.len(); for i in 0..n { let j = (i + n - 1) % n; let d = q[i] - q[j]; l = l - self.bond(d); }",
        "l -= (0..q.len()).map(|i| self.bond(q[(i + 1) % q.len()] - q[i])).sum::<f64>();",
        "let bond = |d: f64| self.bond(d); if q.len() > 0 { l -= bond(q[0] - q[q.len() - 1]); } for w in q.windows(2) { l -= bond(w[1] - w[0]); }",
        "if !q.is_empty() { l -= self.bond(q[0] - q[q.len() - 1]); } for (a, b) in q.iter().zip(&q[1..]) { l -= self.bond(b - a); }",
        "for (i, a) in q.iter().enumerate().rev() { let j = if false { 0 } else { i + 1 }; let b = q[j % q.len()]; l -= self.bond(b - *a); }",
        "for i in 0..q.len() { for k in 0..2 { if k == 1 { l -= self.bond(q[(i + k) % q.len()] - q[i]); } } }",
        "for i in 0..q.len() { if i + 1 < q.len() { l -= self.bond(q[i + 1] - q[i]); } else { l -= self.bond(q[0] - q[i]); } }",
        "for i in 0..q.len() { let next = if i + 1 < q.len() { q[i + 1] } else { q[0] }; let _ = next; } for i in 0..q.len() { if i + 1 == q.len() { l -= self.bond(q[0] - q[i]); continue; } l -= self.bond(q[i + 1] - q[i]); }",
    ];
    for head in heads {
        let body = format!(
            "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {{
                let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
                {head}
                l
            }}
            fn bond(&self, d: f64) -> f64 {{ 1.0 - d.cos() }}"
        );
        compare(&body, &no_fields(), &[0, 1, 2, 9], |q, v| {
            let n = q.len();
            let bond = |i: usize| 1.0 - (q[(i + 1) % n][0] - q[i][0]).cos();
            kinetic(v) - (0..n).map(bond).sum::<f64>()
        });
    }
}

#[test]
fn lattices() {
    let body = "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let (nx, ny) = (self.nx, self.ny);
        let mut l = 0.0;
        for i in 0..nx {
            for j in 0..ny {
                let c = i * ny + j;
                l += 0.5 * v[c] * v[c];
                if i + 1 < nx { l -= self.k * (q[c + ny] - q[c]).powi(2); }
                if j + 1 < ny { l -= self.k * (q[c + 1] - q[c]).powi(2); }
                let (left, up) = (i * ny + (j + ny - 1) % ny, (i + nx - 1) % nx * ny + j);
                l -= (q[left] - q[c]).powi(4) + q[up] * q[c];
            }
        }
        l
    }";
    let fields = HashMap::from([
        ("nx", Field::Integer(4)),
        ("ny", Field::Integer(5)),
        ("k", Field::Number(0.4)),
    ]);
    compare(body, &fields, &[20], |q, v| {
        let mut l = kinetic(v);
        for i in 0..4 {
            for j in 0..5 {
                let at = |i: usize, j: usize| q[i % 4 * 5 + j % 5][0];
                if i < 3 {
                    l -= 0.4 * (at(i + 1, j) - at(i, j)).powi(2);
                }
                if j < 4 {
                    l -= 0.4 * (at(i, j + 1) - at(i, j)).powi(2);
                }
                l -= (at(i, j + 4) - at(i, j)).powi(4) + at(i + 3, j) * at(i, j);
            }
        }
        l
    });
    let cube = "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = self.side;
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 0..n { for j in 0..n { for k in 0..n {
            let at = self.at(i, j, k);
            l -= (q[self.at(i + 1, j, k)] - q[at]).cos() + (q[self.at(i, j, k + 1)] - q[at]).powi(2);
            if j != n - 1 && !(k == 0 || i > 1) { l -= q[self.at(i, j + 1, k)] * q[at]; }
        } } }
        l
    }
    fn at(&self, i: usize, j: usize, k: usize) -> usize { ((i % self.side) * self.side + j % self.side) * self.side + k % self.side }";
    let fields = HashMap::from([("side", Field::Integer(3))]);
    compare(cube, &fields, &[27], |q, v| {
        let at = |i: usize, j: usize, k: usize| q[((i % 3) * 3 + j % 3) * 3 + k % 3][0];
        let mut l = kinetic(v);
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    let own = at(i, j, k);
                    l -= (at(i + 1, j, k) - own).cos() + (at(i, j, k + 1) - own).powi(2);
                    if j != 2 && !(k == 0 || i > 1) {
                        l -= at(i, j + 1, k) * own;
                    }
                }
            }
        }
        l
    });
}

#[test]
fn lists_of_bonds_and_kinds() {
    let body = "fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for &[i, j] in &self.bonds { l -= (q[i] - q[j]).powi(2); }
        for k in 0..self.bonds.len() {
            let [i, j] = self.bonds[k];
            l -= self.eps[self.kind[i]][self.kind[j]] * (q[self.bonds[k][0]] - q[j]).cos() * self.rest[k];
        }
        for (bond, rest) in self.bonds.iter().zip(&self.rest) { l += rest * q[bond[0]] * t.sin(); }
        for i in 0..q.len() { for k in self.start[i]..self.start[i + 1] {
            let j = self.list[k];
            if self.kind[i] == self.kind[j] { continue; }
            l -= q[i] * q[j] * (k as f64);
        } }
        for i in 0..q.len() { for &j in &self.list[self.start[i]..self.start[i + 1]] { l -= self.table[(self.kind[i], self.kind[j])] * q[j]; } }
        l
    }";
    let bonds = [[0, 1], [1, 2], [3, 3], [4, 0]];
    let (kind, rest) = ([0, 1, 0, 1, 0], [0.5, 1.5, 2.0, -1.0]);
    let (start, list) = ([0, 2, 3, 3, 6, 7], [1, 2, 4, 0, 3, 4, 2]);
    let eps = [[1.0, 0.5], [0.25, 2.0]];
    let fields = HashMap::from([
        (
            "bonds",
            Field::List(bonds.iter().map(|b| Field::integers(b)).collect()),
        ),
        ("kind", Field::integers(&kind)),
        ("rest", Field::numbers(&rest)),
        ("start", Field::integers(&start)),
        ("list", Field::integers(&list)),
        ("eps", Field::bodies(&eps)),
        ("table", Field::bodies(&eps)),
    ]);
    compare(body, &fields, &[5], |q, v| {
        let mut l = kinetic(v);
        for (k, &[i, j]) in bonds.iter().enumerate() {
            let (a, b) = (q[i][0], q[j][0]);
            l -= (a - b).powi(2) + eps[kind[i]][kind[j]] * (a - b).cos() * rest[k];
            l += rest[k] * a * 0.7_f64.sin();
        }
        for i in 0..5 {
            for k in start[i]..start[i + 1] {
                let j = list[k];
                l -= eps[kind[i]][kind[j]] * q[j][0];
                if kind[i] != kind[j] {
                    l -= q[i][0] * q[j][0] * k as f64;
                }
            }
        }
        l
    });
}

/// Products of integer fields, and sums that other formulas read.
#[test]
fn integer_fields_and_sums_in_formulas() {
    let body = "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let cells = self.nx * self.ny;
        let n: f64 = q.len() as f64;
        let mean = q.iter().map(|x| x.cos()).sum::<f64>() / n;
        let mut l = v.iter().copied().map(|v| 0.5 * v * v).sum::<f64>() + n * mean * mean;
        for c in 0..cells { l -= q[c] * self.nx as f64; }
        for i in q.len().min(cells).saturating_sub(2)..q.len().max(3) { l += i as f64 * q[i]; }
        let (mut a, mut b) = (0.0, [1.0, 2.0]);
        for (i, x) in q.iter().enumerate() {
            a += x;
            b[0] -= x * x * a0(i);
            let mut density = 0.0;
            for y in q.iter().filter(|y| **y != *x).skip(0) { density += y; }
            b[1] += density * x;
        }
        l + a + b[0] * b[1]
    }";
    let body = body
        .replace("a0(i)", "(1.0 + i as f64)")
        .replace(".skip(0)", "");
    let fields = HashMap::from([("nx", Field::Integer(2)), ("ny", Field::Integer(3))]);
    compare(&body, &fields, &[6, 8], |q, v| {
        let n = q.len();
        let mean = q.iter().map(|x| x[0].cos()).sum::<f64>() / n as f64;
        let mut l = kinetic(v) + n as f64 * mean * mean;
        l -= (0..6).map(|c| 2.0 * q[c][0]).sum::<f64>();
        l += (4..n).map(|i| i as f64 * q[i][0]).sum::<f64>();
        let (mut a, mut b) = (0.0, [1.0, 2.0]);
        for (i, x) in q.iter().enumerate() {
            a += x[0];
            b[0] -= x[0] * x[0] * (1.0 + i as f64);
            let density: f64 = q.iter().filter(|y| y[0] != x[0]).map(|y| y[0]).sum();
            b[1] += density * x[0];
        }
        l + a + b[0] * b[1]
    });
}
