use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let a = std::array::from_fn(|i| 2.0 * q[i]);
        let sum: f64 = a.iter().sum();
        v.iter().map(|v| v * v).sum::<f64>() - self.g * sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
