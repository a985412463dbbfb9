use sve_runtime::prelude::*;

struct Wall {
    u: f64,
}

#[variational(midpoint)]
impl Wall {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.u * (-(q[0] / 1e-6).powi(2)).exp()
    }

    #[symmetry]
    fn shift(&self, _q: [f64; 2]) -> [f64; 2] {
        [1.0, 1.0]
    }
}

fn main() {
    let system = Wall { u: 1.0 };
    let _ = Integrator::new(system, Midpoint);
}
