use sve_runtime::prelude::*;

mod consts {
    pub const PI: f64 = 3.14;
}

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[1] * v[1] - self.g * q[0] * q[1] * consts::PI
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
