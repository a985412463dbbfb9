use sve_runtime::prelude::*;

const COUNT: usize = 2;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        for i in 0..COUNT {
            sum += v[i] * v[i] - self.g * q[i];
        }
        sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
