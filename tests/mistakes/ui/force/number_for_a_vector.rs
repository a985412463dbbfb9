use sve_runtime::prelude::*;

struct Wind {
    k: f64,
}

#[variational(midpoint)]
impl Wind {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.k * (q[0] * q[0] + q[1] * q[1])
    }

    #[force]
    fn drag(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        -self.k * v[0] * q[0]
    }
}

fn main() {
    let system = Wind { k: 1.0 };
    let _ = Integrator::new(system, Midpoint);
}
