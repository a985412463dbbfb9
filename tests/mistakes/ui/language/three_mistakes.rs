use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let wall = (q[0] - q[1]).abs();
        let angle = q[0] % 6.28;
        v[0] * v[0] + v[1] * v[1] - self.g * wall * angle * q[0].sine()
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
