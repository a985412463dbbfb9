//! Synchrotron oscillations of a particle bunch, with noise in phase and amplitude of the accelerating field.
//!
//! H = p²/2 − ω² cos q. Phase and amplitude noise kick the particle: γ₁ = −σ₁ cos q, γ₂ = −σ₂ sin q, two Wiener processes.
//! Particles outside the separatrix H = ω² are lost from the bucket.

use std::error::Error;

use sve_runtime::prelude::*;

#[derive(Clone, Copy, Debug)]
struct Synchrotron {
    omega: f64,
    sigma1: f64,
    sigma2: f64,
}

#[variational(endpoint)]
impl Synchrotron {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.omega.powi(2) * q.cos()
    }

    #[gamma]
    fn kicks(&self, q: f64) -> [f64; 2] {
        [-self.sigma1 * q.cos(), -self.sigma2 * q.sin()]
    }
}

const H: f64 = 0.02;
const PARTICLES: u64 = 1000;

/// Properties of the bunch at a time.
#[derive(Clone, Copy, Debug, Default)]
struct Bunch {
    energy: f64,
    outside: u32,
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Synchrotron {
        omega: 1.0,
        sigma1: 0.1,
        sigma2: 0.1,
    };
    let endpoint = Integrator::new(machine, Endpoint);
    println!("{}\n", endpoint.plan());

    // dH = … + ½ (σ₁² sin² q + σ₂² cos² q) dt: for σ₁ = σ₂ = σ the mean energy grows as σ²t/2, whatever the motion
    let start = State::new([0.5], [0.0]);
    let first = machine.hamiltonian(&start)?;
    let stops: Vec<usize> = (1..=5).map(|k| 1000 * k).collect();
    let mut bunches = vec![Bunch::default(); stops.len()];
    for particle in 0..PARTICLES {
        let mut trajectory = endpoint.trajectory(start, H, Wiener::new(42).path(particle));
        let mut done = 0;
        for (bunch, &stop) in bunches.iter_mut().zip(&stops) {
            for state in trajectory.by_ref().take(stop - done) {
                state?;
            }
            done = stop;
            let energy = machine.hamiltonian(trajectory.state())?;
            bunch.energy += energy / PARTICLES as f64;
            bunch.outside += u32::from(energy > machine.omega.powi(2));
        }
    }
    println!("{PARTICLES} particles from q = 0.5 at rest, h = {H}");
    println!(
        "{:>6} {:>13} {:>13} {:>13}",
        "t", "H₀ + σ²t/2", "mean energy", "lost"
    );
    for (bunch, &stop) in bunches.iter().zip(&stops) {
        let t = stop as f64 * H;
        let exact = first + 0.5 * machine.sigma1.powi(2) * t;
        println!(
            "{t:>6} {exact:>13.4} {:>13.4} {:>11.1} %",
            bunch.energy,
            100.0 * f64::from(bunch.outside) / PARTICLES as f64
        );
    }
    Ok(())
}
