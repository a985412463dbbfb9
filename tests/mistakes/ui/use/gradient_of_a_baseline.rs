use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        q
    }
}

fn main() {
    let heun = Heun::new(Pendulum { g: 9.8 });
    let path = heun.trajectory(State::new([1.0], [0.0]), 0.1, Wiener::new(1));
    let _ = path.gradient(10, |_, state| Some(state.q[0]));
}
