use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let [x, y, lambda] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.g * y + lambda * (x * x + y * y - 1.0)
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
