use sve_runtime::prelude::*;

struct Pendulum {
    masses: [f64; 2],
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut sum = v[0] * v[0] + v[1] * v[1];
        for m in self.masses {
            sum -= m * q[0] * q[1];
        }
        sum
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { masses: [1.0; 2] }, Midpoint);
}
