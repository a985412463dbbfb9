use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut x = q[0];
        for _ in 0..50_000 {
            x = (self.g * x).sin();
        }
        v[0] * v[0] + v[1] * v[1] - x
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
