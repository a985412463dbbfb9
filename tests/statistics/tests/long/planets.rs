//! The energy of the outer solar system over up to a hundred million days: its error is that of rounding, and grows like the square root of the time.
//!
//! Source of masses and start: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration* (2006), section I.2.4, for 5 September 1994 at 0h; here the centre of mass rests at the origin.

use sve_runtime::prelude::*;

use super::gauss::{errors, walks};

/// The Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto: astronomical units, days, solar masses.
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

const GRAVITY: f64 = 2.959_122_082_86e-4;

const MASSES: [f64; 6] = [
    1.000_005_976_82,
    0.000_954_786_104_043,
    0.000_285_583_733_151,
    0.000_043_727_316_454_6,
    0.000_051_775_913_844_9,
    1.0 / 1.3e8,
];

/// Days, and starts.
const LENGTH: (usize, usize) = if cfg!(feature = "thorough") {
    (100_000_000, 12)
} else {
    (10_000_000, 6)
};

fn start() -> State<[[f64; 3]; 6]> {
    let q = [
        [
            -0.000_204_709_829_878_910_5,
            0.006_550_139_855_052_495,
            0.002_824_833_990_245_127,
        ],
        [
            -3.502_570_009_829_879,
            -3.810_434_560_144_947,
            -1.547_971_466_009_755,
        ],
        [
            9.075_326_690_170_12,
            -3.039_285_160_144_947,
            -1.645_545_966_009_755,
        ],
        [
            8.309_937_290_170_122,
            -16.283_558_460_144_95,
            -7.249_302_966_009_755,
        ],
        [
            11.470_561_890_170_12,
            -25.722_932_760_144_95,
            -10.814_120_766_009_756,
        ],
        [
            -15.538_940_409_829_879,
            -25.216_009_260_144_95,
            -3.187_413_366_009_755,
        ],
    ];
    let p = [
        [
            -6.175_566_546_254_882e-6,
            2.435_040_255_532_255e-6,
            1.223_846_885_601_192_8e-6,
        ],
        [
            5.392_741_210_347_52e-6,
            -3.936_072_271_863_883e-6,
            -1.818_548_782_818_609e-6,
        ],
        [
            4.789_251_971_574_021e-7,
            1.381_564_149_448_617_8e-6,
            5.499_896_731_705_224e-7,
        ],
        [
            1.546_024_955_338_951_8e-7,
            6.005_750_254_502_434e-8,
            2.411_622_019_200_966e-8,
        ],
        [
            1.492_764_041_816_777_2e-7,
            5.942_347_653_009_628e-8,
            2.060_649_474_842_555e-8,
        ],
        [
            2.123_903_438_741_365e-11,
            -1.311_219_210_998_598_5e-11,
            -1.049_089_354_176_206e-11,
        ],
    ];
    State::new(q, p)
}

#[test]
fn the_energy_of_the_outer_solar_system_walks() {
    let system = OuterSolarSystem {
        gravity: GRAVITY,
        masses: MASSES,
    };
    let (days, count) = LENGTH;
    // Other starts have slightly other velocities, so that their orbits are still those of the planets.
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
