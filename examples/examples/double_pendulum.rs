//! A double pendulum: a mass matrix that depends on the angles, and two noises that push the first arm.
//!
//! Without noise the energy error of the midpoint rule stays bounded along a chaotic motion, where that of Heun's method,
//! of the same order, drifts. The same step carries the noise.

use std::error::Error;

use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;

/// Angles from the downward vertical.
#[derive(Clone, Copy, Debug)]
struct DoublePendulum {
    m1: f64,
    m2: f64,
    l1: f64,
    l2: f64,
    g: f64,
    s: f64,
}

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let both = self.m1 + self.m2;
        let kinetic =
            0.5 * both * (self.l1 * v[0]).powi(2) + 0.5 * self.m2 * (self.l2 * v[1]).powi(2);
        let coupling = self.m2 * self.l1 * self.l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        let height = both * self.l1 * q[0].cos() + self.m2 * self.l2 * q[1].cos();
        kinetic + coupling + self.g * height
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> [f64; 2] {
        [self.s * q[0].sin(), self.s * q[0].cos()]
    }
}

/// Largest energy error in each of five parts of a run.
fn energy_errors<I>(method: &I, h: f64, steps: usize) -> Result<Vec<f64>, StepError>
where
    I: Method<System = DoublePendulum>,
{
    let start = State::new([2.0, 1.0], [0.0, 0.0]);
    let energy = method.system().hamiltonian(&start)?;
    let mut trajectory = method.trajectory(start, h, NoNoise);
    let mut parts = Vec::new();
    for _ in 0..5 {
        let mut worst: f64 = 0.0;
        for state in trajectory.by_ref().take(steps / 5) {
            worst = worst.max((method.system().hamiltonian(&state?)? - energy).abs());
        }
        parts.push(worst);
    }
    Ok(parts)
}

fn main() -> Result<(), Box<dyn Error>> {
    let pendulum = DoublePendulum {
        m1: 1.0,
        m2: 1.0,
        l1: 1.0,
        l2: 1.0,
        g: 9.8,
        s: 0.2,
    };
    let midpoint = Integrator::new(pendulum, Midpoint);
    println!("{}\n", midpoint.plan());

    let (h, steps) = (0.005, 100_000);
    println!(
        "largest energy error in each fifth of t ≤ {}, h = {h}, no noise",
        h * steps as f64
    );
    let row = |name, parts: Vec<f64>| {
        let cells: Vec<String> = parts.iter().map(|part| format!("{part:>10.2e}")).collect();
        println!("{name:>10} {}", cells.join(" "));
    };
    row("midpoint", energy_errors(&midpoint, h, steps)?);
    row("Heun", energy_errors(&Heun::new(pendulum), h, steps)?);

    println!("\none path with noise, s = {}", pendulum.s);
    println!("{:>4} {:>9} {:>9} {:>11}", "t", "q0", "q1", "energy");
    let trajectory = midpoint.trajectory(State::new([2.0, 1.0], [0.0, 0.0]), h, Wiener::new(42));
    for state in trajectory.take(1000).skip(199).step_by(200) {
        let state = state?;
        println!(
            "{:>4.1} {:>9.4} {:>9.4} {:>11.5}",
            state.t,
            state.q[0],
            state.q[1],
            pendulum.hamiltonian(&state)?
        );
    }
    Ok(())
}
