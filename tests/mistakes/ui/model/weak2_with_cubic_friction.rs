use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint, midpoint(weak2))]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0] * v[0] + self.g * q[0].cos()
    }

    #[gamma]
    fn push(&self, q: [f64; 1]) -> f64 {
        self.g * q[0] * q[0]
    }

    #[force]
    fn friction(&self, _q: [f64; 1], v: [f64; 1]) -> [f64; 1] {
        [-self.g * v[0].powi(3)]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
