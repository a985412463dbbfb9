use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let n = 2_u8;
        v.iter().map(|v| v * v).sum::<f64>() - self.g * (n + q.len()) as f64 * q[0]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
