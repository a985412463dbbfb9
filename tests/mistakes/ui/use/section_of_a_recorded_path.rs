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
    let recorded = Recorded::record(Wiener::new(1), 0.1, 1, 100).unwrap();
    let _ = pendulum.trajectory(start, 0.1, recorded).crossings(|_, state| state.q[0]);
}
