use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r = q[0].cos() * q[1].cos() + q[0].sin() * q[1].sin();
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.g * r * (q[0] - q[1]).exp() - 1e-14 * q[0]
    }

    #[symmetry]
    fn shift(&self, _q: [f64; 2]) -> [f64; 2] {
        [1.0, 1.0]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
