use sve_runtime::prelude::*;

struct Bead {
    g: f64,
}

#[variational(midpoint)]
impl Bead {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) - self.g * q[2]
    }

    #[h1(projected)]
    fn lift(&self, _q: [f64; 3], p: [f64; 3]) -> f64 {
        self.g * p[2]
    }

    #[constraint]
    fn sphere(&self, q: [f64; 3]) -> f64 {
        q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0
    }
}

fn main() {
    let _ = Integrator::new(Bead { g: 1.0 }, Midpoint);
}
