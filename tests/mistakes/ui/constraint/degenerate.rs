use sve_runtime::prelude::*;

struct Bead {
    g: f64,
}

#[variational(midpoint)]
impl Bead {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        q[0] * v[1] + 0.5 * v[2] * v[2] - self.g * q[2] - q[0] * q[0] - q[1] * q[1]
    }

    #[constraint]
    fn plane(&self, q: [f64; 3]) -> f64 {
        q[2] - q[1]
    }
}

fn main() {
    let _ = Integrator::new(Bead { g: 1.0 }, Midpoint);
}
