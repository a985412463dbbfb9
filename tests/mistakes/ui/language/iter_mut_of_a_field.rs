use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        for g in self.g.iter_mut() {
            *g += 1.0;
        }
        v.iter().map(|v| v * v).sum::<f64>() - self.g * (q[0] + q[1] + q[2]).cos()
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
