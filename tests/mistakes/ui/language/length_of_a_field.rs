use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
    k: [f64; 2],
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut sum = v[0] * v[0] + v[1] * v[1];
        for i in 0..self.k.len() {
            sum -= self.g * self.k[i] * q[i];
        }
        sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0, k: [1.0; 2] }, Midpoint);
}
