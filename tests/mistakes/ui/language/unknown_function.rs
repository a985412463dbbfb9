use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

fn potential(q: [f64; 2]) -> f64 {
    q[0] * q[1]
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[1] * v[1] - self.g * potential(q)
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
