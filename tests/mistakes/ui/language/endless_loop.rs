use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut x = q[0];
        loop {
            x *= self.g;
            if x > q[1] {
                break;
            }
        }
        v[0] * v[0] + v[1] * v[1] - x
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
