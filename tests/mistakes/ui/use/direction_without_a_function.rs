use sve_runtime::prelude::*;

struct Pendulum;

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        q
    }
}

fn main() {
    let pendulum = Integrator::new(Pendulum, Midpoint);
    let start = State::new([1.0], [0.0]);
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).rising();
}
