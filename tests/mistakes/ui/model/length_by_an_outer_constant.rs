use sve_runtime::prelude::*;

const DIM: usize = 3;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    const N: usize = DIM;

    fn lagrangian(&self, q: [f64; Self::N], v: [f64; Self::N]) -> f64 {
        v.iter().map(|v| v * v).sum::<f64>() - self.g * (q[0] * q[1] * q[2]).cos()
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
