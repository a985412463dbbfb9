use sve_runtime::prelude::*;

struct System;

#[variational(midpoint)]
impl System {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        q[1] * v[0] - q[0].powi(2) - q[1].powi(4)
    }

    #[h1]
    fn noise(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        q[0] * p[1]
    }
}

fn main() {
    let _ = Integrator::new(System, Midpoint);
}
