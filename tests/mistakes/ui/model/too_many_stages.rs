use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint, gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 30], v: [f64; 30]) -> f64 {
        let mut sum = 0.0;
        for i in 0..30 {
            sum += v[i] * v[i] + self.g * q[i].cos();
        }
        sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
