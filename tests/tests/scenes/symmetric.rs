//! Systems with symmetries, as scenes and unrolled.

use sve_runtime::nalgebra::Vector3;

use crate::common::spread;

/// A ring with masses of its own, and a noise of each bond.
pub(crate) mod ring {
    use sve_runtime::prelude::*;
    both! {
        struct { mass: Vec<f64>, beta: f64, sigma: f64 }
        [f64] 7
        |self, q, v| {
            let n = q.len();
            let mut l = 0.0;
            for i in 0..n {
                let d = q[(i + 1) % n] - q[i];
                l += 0.5 * self.mass[i] * v[i] * v[i] - 0.5 * d * d - 0.25 * self.beta * d.powi(4);
            }
            l
        }
        #[gamma]
        each bonds(&self, q) -> f64 |i| { self.sigma * (q[(i + 1) % q.len()] - q[i]).sin() }
        #[symmetry]
        each shift(&self, q) -> f64 |_i| { 1.0 }
    }
}

/// Stars with the forces of all pairs, and one noise of their distances.
pub(crate) mod stars {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        struct { m: Vec<f64>, sigma: f64 }
        [Vector3<f64>] 5
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.m[i] * v[i].norm_squared();
                for j in 0..i {
                    l += self.m[i] * self.m[j] / ((q[i] - q[j]).norm_squared() + 0.1).sqrt();
                }
            }
            l
        }
        #[gamma]
        fn breath(&self, q) -> f64 {
            let mut g = 0.0;
            for i in 0..q.len() {
                for j in 0..i {
                    g += self.sigma * (1.0 + (q[i] - q[j]).norm_squared()).ln();
                }
            }
            g
        }
        #[symmetry]
        each along(&self, q) -> Vector3<f64> |_i| { Vector3::new(0.0, 2.0, -1.0) }
        #[symmetry]
        each turn(&self, q) -> Vector3<f64> |i| { Vector3::new(1.0, -0.5, 2.0).cross(&q[i]) }
    }
}

/// Bodies in a plane in a round well about the origin, which no translation leaves as it is.
pub(crate) mod planar {
    use sve_runtime::prelude::*;
    both! {
        struct { k: f64 }
        [[f64; 2]] 4
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                l -= self.k * (q[i][0].powi(2) + q[i][1].powi(2)).powi(2);
                for j in 0..i {
                    l -= (q[i][0] * q[j][0] + q[i][1] * q[j][1]).sin();
                }
            }
            l
        }
        #[symmetry]
        each turn(&self, q) -> [f64; 2] |i| { [-q[i][1], q[i][0]] }
    }
}

/// Rotors in the field of their mean, and in that of all others.
pub(crate) mod rotors {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { j: f64, weight: Vec<f64> }
        [f64] 6
        |self, q, v| {
            let n = q.len() as f64;
            let x = q.iter().map(|q| q.cos()).sum::<f64>() / n;
            let y = q.iter().map(|q| q.sin()).sum::<f64>() / n;
            let mut l = self.j * n * (x * x + y * y);
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i];
                let mut field = 0.0;
                for k in 0..q.len() {
                    field += self.weight[k] * (q[i] - q[k]).cos();
                }
                l += (1.0 + field * field).sqrt() / n;
            }
            l
        }
        #[symmetry]
        each angle(&self, q) -> f64 |_i| { 1.0 }
    }
}

/// Charges. The generator has an entry of its own for each site.
pub(crate) mod charges {
    use sve_runtime::prelude::*;
    both! {
        struct { charge: Vec<f64> }
        [f64] 4
        |self, q, v| {
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            for i in 0..q.len() {
                let j = (i + 2) % q.len();
                l -= (self.charge[j] * q[i] - self.charge[i] * q[j]).powi(2);
            }
            l
        }
        #[symmetry]
        each phase(&self, q) -> f64 |i| { self.charge[i] }
    }
}

/// Bodies that are drawn to their centre. Along a shift the centre moves by Σ 1/n.
pub(crate) mod centred {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { k: f64 }
        [[f64; 2]] 4
        |self, q, v| {
            let n = q.len() as f64;
            let x = q.iter().map(|q| q[0]).sum::<f64>() / n;
            let y = q.iter().map(|q| q[1]).sum::<f64>() / n;
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                l -= self.k * ((q[i][0] - x).powi(2) + (q[i][1] - y).powi(2)).powi(2);
            }
            l
        }
        #[symmetry]
        each turn(&self, q) -> [f64; 2] |i| { [-q[i][1], q[i][0]] }
        #[symmetry]
        each shift(&self, q) -> [f64; 2] |_i| { [0.5, 1.5] }
    }
}

pub(crate) fn rows<const N: usize>(seed: u64) -> [f64; N] {
    spread(N, seed).try_into().expect("the numbers")
}

pub(crate) fn pairs<const N: usize>(seed: u64) -> [[f64; 2]; N] {
    let numbers = spread(2 * N, seed);
    std::array::from_fn(|i| [numbers[2 * i], numbers[2 * i + 1]])
}

pub(crate) fn vectors<const N: usize>(seed: u64) -> [Vector3<f64>; N] {
    let numbers = spread(3 * N, seed);
    std::array::from_fn(|i| Vector3::from_column_slice(&numbers[3 * i..3 * i + 3]))
}

/// Different positive numbers.
pub(crate) fn positive(n: usize, seed: u64) -> Vec<f64> {
    spread(n, seed).into_iter().map(|x| 1.5 + x).collect()
}
