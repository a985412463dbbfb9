//! A constraint that depends on time: a particle on a sphere whose radius changes, against spherical coordinates.

use sve_models::models::Breathing;
use sve_runtime::Variational;
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

fn place(t: f64, angles: [f64; 2]) -> Vector3<f64> {
    let ([polar, azimuth], r) = (angles, 1.0 + D * t.sin());
    r * Vector3::new(
        polar.sin() * azimuth.cos(),
        polar.sin() * azimuth.sin(),
        polar.cos(),
    )
}

/// Root mean square error at time 1 over some paths, with 2ᵏ steps.
fn error<R>(rule: R, level: u32, s: f64) -> f64
where
    Breathing: Variational<R>,
{
    let integrator = Integrator::new(Breathing { g: 1.0, d: D, s }, rule);
    let angles = Integrator::new(Angles { g: 1.0, d: D, s }, Midpoint);
    let paths = if s == 0.0 { 1 } else { 40 };
    let mut squares = 0.0;
    for path in 0..paths {
        let fine = Recorded::record(Wiener::new(9).path(path), 1.0 / 4096.0, 1, 4096).unwrap();
        let start = State::new([1.2, 0.3], [0.4, 0.5]);
        let exact = angles
            .trajectory(start, fine.h(), &fine)
            .last()
            .unwrap()
            .unwrap();
        let coarse = fine.coarsen(4096 >> level).unwrap();
        // velocity of the angles 0.4 and 0.5/sin², and of the radius d cos 0
        let [polar, azimuth] = [1.2f64, 0.3f64];
        let along = Vector3::new(
            polar.cos() * azimuth.cos(),
            polar.cos() * azimuth.sin(),
            -polar.sin(),
        );
        let about = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
        let q = place(0.0, [polar, azimuth]);
        let p = 0.4 * along + 0.5 / polar.sin() * about + D * q;
        let end = integrator
            .trajectory(State::new(q, p), coarse.h(), &coarse)
            .last();
        let end = end.unwrap().unwrap();
        squares += (end.q - place(1.0, exact.q)).norm_squared();
    }
    (squares / paths as f64).sqrt()
}

#[test]
fn orders_without_noise() {
    fn order<R: Copy>(rule: R) -> f64
    where
        Breathing: Variational<R>,
    {
        (error(rule, 5, 0.0) / error(rule, 6, 0.0)).log2()
    }
    let found = [
        order(Midpoint),
        order(StormerVerlet),
        order(InitialPoint),
        order(Endpoint),
    ];
    println!("{found:?}");
    for (found, expected) in found.into_iter().zip([2.0, 2.0, 1.0, 1.0]) {
        assert!((found - expected).abs() < 0.1, "{found}");
    }
}

#[test]
fn orders_with_noise() {
    fn order<R: Copy>(rule: R) -> f64
    where
        Breathing: Variational<R>,
    {
        (error(rule, 5, 0.5) / error(rule, 9, 0.5)).log2() / 4.0
    }
    let found = [
        order(Midpoint),
        order(StormerVerlet),
        order(InitialPoint),
        order(Endpoint),
    ];
    println!("{found:?}");
    for found in found {
        assert!((found - 1.0).abs() < 0.12, "{found}");
    }
}
