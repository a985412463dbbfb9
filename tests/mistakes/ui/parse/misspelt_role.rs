use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.g * q[0] * q[1]
    }

    #[symetry]
    fn rest(&self, _q: [f64; 2]) -> [f64; 2] {
        [1.0, 1.0]
    }

    #[H1]
    fn jitter(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        q[0] * p[0]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
