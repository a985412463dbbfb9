use sve_runtime::prelude::*;

struct System;

#[variational(midpoint)]
impl System {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] + v[1]).powi(2) - q[0].powi(2) - q[1].powi(2)
    }
}

fn main() {
    let _ = Integrator::new(System, Midpoint);
}
