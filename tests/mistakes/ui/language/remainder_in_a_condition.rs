use sve_runtime::prelude::*;

struct Driven {
    push: f64,
}

#[variational(midpoint)]
impl Driven {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        let switch = if t % 1.0 < 0.5 { self.push } else { 0.0 };
        0.5 * v * v + switch * q
    }
}

fn main() {
    let _ = Integrator::new(Driven { push: 1.0 }, Midpoint);
}
