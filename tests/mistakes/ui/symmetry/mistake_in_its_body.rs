use sve_runtime::prelude::*;

struct Trap {
    k: f64,
}

#[variational(midpoint)]
impl Trap {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.k * (q[0] * q[0] + q[1] * q[1])
    }

    #[symmetry]
    fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0].abs()]
    }
}

fn main() {
    let system = Trap { k: 1.0 };
    let _ = system.rotation_momentum(&State::new([1.0, 0.0], [0.0, 1.0]));
    let _ = Integrator::new(system, Midpoint);
}
