use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        let mut add = |x: f64| sum += x * x;
        add(v[0]);
        add(v[1]);
        sum - self.g * q[0] * q[1]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
