use sve_runtime::prelude::*;

struct Ellipse {
    k: f64,
}

#[variational(midpoint)]
impl Ellipse {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.k * (q[0] * q[0] + 2.0 * q[1] * q[1])
    }

    #[symmetry]
    fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

fn main() {
    let system = Ellipse { k: 1.0 };
    let _ = system.rotation_momentum(&State::new([1.0, 0.0], [0.0, 1.0]));
    let _ = Integrator::new(system, Midpoint);
}
