use sve_runtime::prelude::*;

struct System;

#[variational(midpoint, endpoint)]
impl System {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        2.0 * (q[0] * v[1] - q[1] * v[0]) / (1.0 + square) - square
    }
}

fn main() {
    let _ = Integrator::new(System, Midpoint);
}
