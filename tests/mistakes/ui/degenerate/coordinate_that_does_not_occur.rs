use sve_runtime::prelude::*;

struct System;

#[variational(midpoint)]
impl System {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        q[1] * v[0] - q[0].powi(2) - q[1].powi(2)
    }
}

fn main() {
    let _ = Integrator::new(System, Midpoint);
}
