use sve_runtime::prelude::*;

struct Pendulum<'a> {
    g: f64,
    name: &'a str,
}

#[variational(midpoint)]
impl<'a> Pendulum<'a> {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.g * q[0] * q[1]
    }
}

fn main() {
    let pendulum = Pendulum { g: 1.0, name: "" };
    let _ = pendulum.name;
    let integrator = Integrator::new(pendulum, Midpoint);
    let mut state = State::new([0.1, 0.2], [0.0, 0.0]);
    let _ = integrator.step(&mut state, 0.01, &[]);
}
