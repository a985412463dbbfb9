use sve_runtime::prelude::*;

struct Swing {
    k: f64,
}

#[variational(midpoint)]
impl Swing {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.k * (q[0] - q[1]).powi(2) - q[0].cos()
    }

    #[symmetry]
    fn shift(&self, _q: [f64; 2]) -> [f64; 2] {
        [1.0, 1.0]
    }
}

fn main() {
    let system = Swing { k: 1.0 };
    let _ = Integrator::new(system, Midpoint);
}
