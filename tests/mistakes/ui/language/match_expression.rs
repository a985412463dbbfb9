use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let scale = match self.side() {
            true => 1.0,
            false => 2.0,
        };
        scale * (v[0] * v[0] + v[1] * v[1] - q[0] * q[1])
    }

    fn side(&self) -> bool {
        self.g > 0.0
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
