use sve_runtime::prelude::*;

struct Bead {
    g: f64,
}

#[variational(midpoint)]
impl Bead {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) - self.g * q[2]
    }

    #[constraint]
    fn cylinder(&self, q: [f64; 3]) -> f64 {
        q[0] * q[0] + 2.0 * q[1] * q[1] - 1.0
    }

    #[symmetry]
    fn turn(&self, q: [f64; 3]) -> [f64; 3] {
        [-q[1], q[0], 0.0]
    }
}

fn main() {
    let _ = Integrator::new(Bead { g: 1.0 }, Midpoint);
}
