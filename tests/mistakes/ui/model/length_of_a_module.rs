use sve_runtime::prelude::*;

mod sizes {
    pub const DIM: usize = 3;
}

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; sizes::DIM], v: [f64; sizes::DIM]) -> f64 {
        v.iter().map(|v| v * v).sum::<f64>() - self.g * (q[0] * q[1] * q[2]).cos()
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
