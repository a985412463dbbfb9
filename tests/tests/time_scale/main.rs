//! Systems with a time scale, dt = s(q) dτ: structure at equal steps of τ, orbits against their
//! exact solutions, times of steps and states at times, what depends on the energy of a path.

mod bodies;
mod failures;
mod kepler;
mod paths;
mod structure;
mod times;
mod tolerance;

use sve_models::models::Comet;
use sve_runtime::Tangent;
use sve_runtime::prelude::*;

/// A double pendulum with masses and lengths 1, whose mass matrix depends on the configuration.
struct DoublePendulum;

#[variational(gauss(4), gauss(8))]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mixed = v[0] * v[1] * (q[0] - q[1]).cos();
        v[0] * v[0] + 0.5 * v[1] * v[1] + mixed + 2.0 * q[0].cos() + q[1].cos()
    }

    #[time_scale]
    fn scale(&self, q: [f64; 2]) -> f64 {
        (4.0 + 2.0 * q[0].cos() + q[1].cos()).sqrt().recip()
    }
}

/// Returns the perihelion of an orbit with semi-axis and μ equal to 1.
fn perihelion(eccentricity: f64) -> TimedState<[f64; 2]> {
    let speed = ((1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
    let comet = Comet { mu: 1.0 };
    TimedState::new(&comet, [1.0 - eccentricity, 0.0], [0.0, speed]).expect("a time scale")
}

/// Returns the place on this orbit at a time, by Kepler's equation E − e sin E = t.
fn on_orbit(eccentricity: f64, t: f64) -> [f64; 2] {
    let mean = t - (t / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    // an anomaly from which Newton's method converges for all eccentricities
    let mut anomaly = std::f64::consts::PI.copysign(mean);
    for _ in 0..60 {
        let residual = anomaly - eccentricity * anomaly.sin() - mean;
        anomaly -= residual / (1.0 - eccentricity * anomaly.cos());
    }
    let minor = (1.0 - eccentricity * eccentricity).sqrt();
    [anomaly.cos() - eccentricity, minor * anomaly.sin()]
}

/// Returns the largest entry of `MᵀΩM − Ω`.
fn symplecticity(m: &Tangent<2>) -> f64 {
    let mut most = 0.0_f64;
    for i in 0..4 {
        for j in 0..4 {
            let bracket: f64 = (0..2)
                .map(|k| m[k][i] * m[2 + k][j] - m[2 + k][i] * m[k][j])
                .sum();
            let canonical = f64::from(u8::from(j == i + 2)) - f64::from(u8::from(i == j + 2));
            most = most.max((bracket - canonical).abs());
        }
    }
    most
}

/// Returns the largest difference of two states in q and p.
fn distance(a: &State<[f64; 2]>, b: &State<[f64; 2]>) -> f64 {
    let pairs = a.q.iter().chain(&a.p).zip(b.q.iter().chain(&b.p));
    pairs.fold(0.0, |most, (x, y)| most.max((x - y).abs()))
}
