use sve_runtime::prelude::*;

struct Pendulum<const N: usize> {
    g: f64,
}

#[variational(midpoint)]
impl<const N: usize> Pendulum<N> {
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0] * v[0] + self.g * q[0].cos()
    }
}

fn main() {
    let integrator = Integrator::new(Pendulum::<2> { g: 1.0 }, Midpoint);
    let mut state = State::new([0.1], [0.0]);
    let _ = integrator.step(&mut state, 0.01, &[]);
}
