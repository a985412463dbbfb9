use sve_runtime::prelude::*;

/// Its mass depends on its place.
struct Bead;

#[variational(initial_point, endpoint)]
impl Bead {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (1.0 + q * q) * v * v - 0.5 * q * q
    }
}

/// Its kinetic energy is not quadratic.
struct Relativistic;

#[variational(initial_point, endpoint)]
impl Relativistic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        -(1.0 - v * v).sqrt() - 0.5 * q * q
    }
}

/// It lacks a rule.
struct Spring;

#[variational(initial_point)]
impl Spring {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
}

fn main() {
    let _ = Integrator::new(Bead, Split::new(BlanesMoan4));
    let _ = Integrator::new(Relativistic, Split::new(BlanesMoanRkn6));
    let _ = Integrator::new(Spring, Split::new(BlanesMoan4));
    let _ = Composed::new(InitialPoint, KahanLi8);
}
