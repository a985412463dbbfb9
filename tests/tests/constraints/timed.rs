//! A constraint that depends on time: a particle on a sphere whose radius changes, against
//! spherical coordinates.

use sve_models::models::Breathing;
use sve_models::orders::{Paths, Row, Tolerance, numbers};
use sve_runtime::prelude::*;

/// The same in polar angle and azimuth, where the radius is a function of time.
struct Angles {
    g: f64,
    d: f64,
    s: f64,
}

#[variational(midpoint)]
impl Angles {
    fn radius(&self, t: f64) -> f64 {
        1.0 + self.d * t.sin()
    }

    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r = self.radius(t);
        0.5 * r * r * (v[0].powi(2) + (q[0].sin() * v[1]).powi(2)) - self.g * r * q[0].cos()
    }

    #[gamma]
    fn shake(&self, t: f64, q: [f64; 2]) -> f64 {
        self.s * self.radius(t).powi(2) * q[0].sin() * q[1].cos() * q[0].cos()
    }
}

const D: f64 = 0.2;

/// Paths with twice the steps again and again, up to 512, against the midpoint rule in angles with
/// 4096 steps.
const PATHS: Paths = Paths {
    seed: 9,
    batches: 8,
    count: 20,
    coarsest: 5,
    levels: 5,
    finest: 12,
    tolerance: Tolerance {
        bias: 0.0,
        error: 0.03,
    },
};

/// The state of the particle for angles and their momenta, at time t.
fn particle(t: f64, [polar, azimuth]: [f64; 2], p: [f64; 2]) -> State<Vector3<f64>> {
    let r = 1.0 + D * t.sin();
    let along = Vector3::new(
        polar.cos() * azimuth.cos(),
        polar.cos() * azimuth.sin(),
        -polar.sin(),
    );
    let about = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
    let out = Vector3::new(
        polar.sin() * azimuth.cos(),
        polar.sin() * azimuth.sin(),
        polar.cos(),
    );
    let momentum = p[0] / r * along + p[1] / (r * polar.sin()) * about + D * t.cos() * out;
    State::at(t, r * out, momentum)
}

/// Checks the orders of all rules with noise of the strength s.
fn check(paths: Paths, s: f64, orders: [f64; 4]) {
    let system = Breathing { g: 1.0, d: D, s };
    let angles = Integrator::new(Angles { g: 1.0, d: D, s }, Midpoint);
    let start = State::new([1.2, 0.3], [0.4, 0.5]);
    let path = paths.against(1, |path| {
        let end = angles.trajectory(start, path.h(), path).last();
        let end = end.unwrap().unwrap();
        numbers(&particle(1.0, end.q, end.p))
    });
    let rows = Row::rules(&system, particle(0.0, start.q, start.p));
    let rows: Vec<_> = rows
        .into_iter()
        .zip(orders)
        .map(|(row, order)| row.of_order(order))
        .collect();
    paths.check("γ on a sphere of time", &rows, path);
}

#[test]
fn orders_without_noise() {
    let paths = Paths {
        batches: 2,
        count: 1,
        levels: 2,
        tolerance: Tolerance {
            bias: 0.1,
            error: 1e-9,
        },
        ..PATHS
    };
    check(paths, 0.0, [1.0, 2.0, 2.0, 1.0]);
}

#[test]
fn orders_with_noise() {
    check(PATHS, 0.5, [1.0; 4]);
}
