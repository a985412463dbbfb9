//! Rods that hang from one another, whose mass matrix couples all angles: 33 coordinates.

use sve_runtime::prelude::*;

struct Pendulum {
    m: f64,
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 33], v: [f64; 33]) -> f64 {
        let mut l = 0.0;
        for i in 0..33 {
            let carried = self.m * (33 - i) as f64;
            l += 0.5 * carried * v[i].powi(2) + carried * self.g * q[i].cos();
            for j in 0..i {
                l += carried * v[i] * v[j] * (q[i] - q[j]).cos();
            }
        }
        l
    }
}

pub(crate) fn check() {
    let state = State::new(std::array::from_fn(|i| 0.3 * (i as f64).sin()), [0.0; 33]);
    super::check(Pendulum { m: 1.0, g: 9.8 }, Midpoint, state);
}
