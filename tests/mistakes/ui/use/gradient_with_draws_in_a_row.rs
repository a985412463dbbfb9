use sve_runtime::noise::Noise;
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

/// A source whose increments follow one another.
struct Draws(f64);

impl Noise for Draws {
    fn increments(&mut self, _: u64, _: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0 = -self.0;
        dw.fill(self.0);
        Ok(())
    }
}

fn main() {
    let pendulum = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let path = pendulum.trajectory(State::new([1.0], [0.0]), 0.1, Draws(0.1));
    let _ = path.gradient(10, |_, state| Some(state.q[0]));
}
