use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0] * v[0] - self.g * q[0]
    }

    #[gamma]
    fn push(&self, q: [f64; 1]) -> f64 {
        self.g * q[0]
    }
}

fn main() {
    let pendulum = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
    let state = State::new([1.0], [0.0]);
    let _ = pendulum.trajectory(state, 0.1, 42);
}
