use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f32; 1], v: [f32; 1]) -> f64 {
        f64::from(v[0] * v[0]) - self.g * f64::from(q[0])
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
