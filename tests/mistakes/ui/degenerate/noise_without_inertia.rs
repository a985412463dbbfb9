use sve_runtime::prelude::*;

struct System;

#[variational(midpoint)]
impl System {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] - 0.5 * (q[0] - q[1]).powi(2) - q[1].powi(2)
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> [f64; 2] {
        [q[0], q[0] * q[1]]
    }
}

fn main() {
    let _ = Integrator::new(System, Midpoint);
}
