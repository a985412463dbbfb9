use sve_runtime::prelude::*;

struct Bead;

#[variational(midpoint)]
impl Bead {
    fn lagrangian(&self, _q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1])
    }

    #[constraint]
    fn ring(&self, q: [f64; 2]) -> f64 {
        q[0] * q[0] + q[1] * q[1] - 1.0
    }
}

fn main() {
    let _ = Integrator::new(Bead, Midpoint);
}
