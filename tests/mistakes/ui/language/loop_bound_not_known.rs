use sve_runtime::prelude::*;

struct Pendulum {
    count: usize,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut sum = v[0] * v[0] + v[1] * v[1];
        for _ in 0..self.count {
            sum -= q[0] * q[1];
        }
        sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { count: 2 }, Midpoint);
}
