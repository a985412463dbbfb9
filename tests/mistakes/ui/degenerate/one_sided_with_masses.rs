use sve_runtime::prelude::*;

struct System;

#[variational(initial_point)]
impl System {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * v[0] * v[0] + q[1] * v[2] - q[0].powi(2) - q[1].powi(2) - q[2].powi(2)
    }
}

fn main() {
    let _ = Integrator::new(System, InitialPoint);
}
