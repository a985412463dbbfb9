use sve_runtime::prelude::*;

struct System;

#[variational(midpoint(weak2))]
impl System {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        q[1] * v[0] - q[0].powi(2) - q[1].powi(4)
    }

    #[gamma]
    fn noise(&self, q: [f64; 2]) -> f64 {
        q[0] * q[1]
    }
}

fn main() {
    let _ = Integrator::new(System, Weak2(Midpoint));
}
