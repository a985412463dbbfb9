use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        for i in 0..3_usize {
            sum += (i - 1) as f64 * q[i];
        }
        v.iter().map(|v| v * v).sum::<f64>() - self.g * sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
