//! The energy of the outer solar system over up to a hundred million days: its error is that of
//! rounding, and grows like the square root of the time.

use sve_models::is_thorough;
use sve_runtime::prelude::*;

use super::gauss::{errors, walks};
use outer_solar_system::{GRAVITY, MASSES, start};

/// Masses and start are those of the example `work_precision`, which has the end too.
#[path = "../../../../examples/examples/work_precision/planets.rs"]
#[allow(dead_code)]
mod outer_solar_system;

/// The Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto: astronomical units,
/// days, solar masses.
struct OuterSolarSystem {
    gravity: f64,
    masses: [f64; 6],
}

#[variational(gauss(8))]
impl OuterSolarSystem {
    fn lagrangian(&self, q: [[f64; 3]; 6], v: [[f64; 3]; 6]) -> f64 {
        let mut value = 0.0;
        for i in 0..6 {
            value +=
                0.5 * self.masses[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
            for j in 0..i {
                let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                value +=
                    self.gravity * self.masses[i] * self.masses[j] / (x * x + y * y + z * z).sqrt();
            }
        }
        value
    }
}

/// Days, and starts.
fn length() -> (usize, usize) {
    if is_thorough() {
        (100_000_000, 12)
    } else {
        (10_000_000, 6)
    }
}

#[test]
fn the_energy_of_the_outer_solar_system_walks() {
    let system = OuterSolarSystem {
        gravity: GRAVITY,
        masses: MASSES,
    };
    let (days, count) = length();
    // Other starts have slightly other velocities, so that their orbits are still those of the
    // planets.
    let scaled = |k: usize| {
        let State { q, p, .. } = start();
        let factor = 1.0 + 1e-6 * k as f64;
        State::new(q, p.map(|p| p.map(|p| factor * p)))
    };
    let starts: Vec<_> = (0..count).map(scaled).collect();
    let method = Integrator::new(&system, Gauss::<8>);
    let energy = |state: &State<_>| system.hamiltonian(state).unwrap();
    let size = energy(&starts[0]).abs();
    for days_a_step in [250, 400] {
        let steps = days / days_a_step;
        let h = days_a_step as f64;
        let name = format!("outer solar system, steps of {h} days");
        walks(&name, &errors(&method, &starts, (h, steps), (energy, size)));
    }
}
