//! Lattices in two and three dimensions, open and periodic.

use sve_runtime::prelude::*;

use crate::common::spread;

mod open {
    use sve_runtime::prelude::*;
    both! {
        struct { k: f64 }
        [f64] 12
        |self, q, v| {
            let (nx, ny) = (4, q.len() / 4);
            let mut l = 0.0;
            for i in 0..nx {
                for j in 0..ny {
                    let c = i * ny + j;
                    l += 0.5 * v[c] * v[c] - 0.25 * (q[c] * q[c] - 1.0).powi(2);
                    if i + 1 < nx {
                        l -= 0.5 * self.k * (q[c + ny] - q[c]).powi(2);
                    }
                    if j + 1 < ny {
                        l -= 0.5 * self.k * (q[c + 1] - q[c]).powi(2);
                    }
                }
            }
            l
        }
    }
}

mod periodic {
    use sve_runtime::prelude::*;
    both! {
        struct { k: f64 }
        [[f64; 2]] 12
        |self, q, v| {
            let ny = 3;
            let nx = q.len() / ny;
            let mut l = 0.0;
            for i in 0..nx {
                for j in 0..ny {
                    let c = i * ny + j;
                    let right = i * ny + (j + 1) % ny;
                    let down = (i + 1) % nx * ny + j;
                    for a in 0..2 {
                        l += 0.5 * v[c][a] * v[c][a] - 0.25 * q[c][a].powi(4);
                        l -= 0.5 * self.k * (q[right][a] - q[c][a]).powi(2);
                    }
                    l += (q[down][0] - q[c][0]).cos() * (q[down][1] - q[c][1]).cos();
                }
            }
            l
        }
    }
}

mod cube {
    use sve_runtime::prelude::*;
    both! {
        struct { k: f64 }
        [f64] 24
        |self, q, v| {
            let (nx, ny) = (2, 3);
            let nz = q.len() / (nx * ny);
            let mut l = 0.0;
            for i in 0..nx {
                for j in 0..ny {
                    for k in 0..nz {
                        let c = (i * ny + j) * nz + k;
                        l += 0.5 * v[c] * v[c] - 0.25 * q[c].powi(4);
                        l -= 0.5 * self.k * (q[(i * ny + j) * nz + (k + 1) % nz] - q[c]).powi(2);
                        l -= 0.4 * (q[(i * ny + (j + 1) % ny) * nz + k] - q[c]).powi(2);
                        if i + 1 < nx {
                            l -= 0.3 * (q[c + ny * nz] - q[c]).powi(2);
                        }
                    }
                }
            }
            l
        }
    }
}

fn array<const N: usize>(seed: u64) -> [f64; N] {
    spread(N, seed).try_into().expect("the length")
}

fn rows<const N: usize>(seed: u64) -> [[f64; 2]; N] {
    let numbers = spread(2 * N, seed);
    std::array::from_fn(|i| [numbers[2 * i], numbers[2 * i + 1]])
}

#[test]
fn lattices_step_as_unrolled_ones() {
    compare!(open { k: 0.6 }, array::<12>(1), array::<12>(2), []);
    compare!(periodic { k: 0.6 }, rows::<12>(3), rows::<12>(4), []);
    compare!(cube { k: 0.6 }, array::<24>(5), array::<24>(6), []);
}
