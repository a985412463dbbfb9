use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian<const N: usize>(&self, q: [f64; N], v: [f64; N]) -> f64 {
        v[0] * v[0] - self.g * q[0]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
