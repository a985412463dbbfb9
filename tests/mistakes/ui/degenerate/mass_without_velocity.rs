use sve_runtime::prelude::*;

struct System;

#[variational(midpoint)]
impl System {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] / q[1] - 0.5 * q[1]
    }
}

fn main() {
    let _ = Integrator::new(System, Midpoint);
}
