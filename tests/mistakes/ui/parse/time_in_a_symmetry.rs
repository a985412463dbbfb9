use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g
    }

    #[symmetry]
    fn drift(&self, q: f64, t: f64) -> f64 {
        1.0 + 0.0 * q * t
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
