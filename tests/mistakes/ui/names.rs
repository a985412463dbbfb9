use sve_runtime::prelude::*;

const STIFFNESS: f64 = 2.0;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[1] * v[1] - STIFNESS * self.g * q[0] * q[1]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: STIFFNESS }, Midpoint);
    let _ = Integrator::new(Pendulum { g: STIFFNESS }, midpoint);
}
