use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(gauss(3, 4))]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0] * v[0] - self.g * q[0]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
