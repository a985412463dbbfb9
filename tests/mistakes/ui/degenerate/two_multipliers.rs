use sve_runtime::prelude::*;

struct Linkage;

#[variational(midpoint)]
impl Linkage {
    fn lagrangian(&self, q: [f64; 6], v: [f64; 6]) -> f64 {
        let kinetic = 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
        let first = q[0] * q[0] + q[1] * q[1] - 1.0;
        let second = (q[2] - q[0]).powi(2) + (q[3] - q[1]).powi(2) - 1.0;
        kinetic - q[1] - q[3] + q[4] * first + q[5] * second
    }
}

fn main() {
    let _ = Integrator::new(Linkage, Midpoint);
}
