//! Paths that have no tolerance.

use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint, gauss(3), gauss(8), gauss(8, stage_noise), gauss(8, weak2))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        q
    }
}

/// A particle whose kinetic energy is not quadratic.
struct Relativistic;

#[variational(gauss(8))]
impl Relativistic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        -(1.0 - v * v).sqrt() - 0.5 * q * q
    }
}

/// With a motor.
struct Driven;

#[variational(gauss(8))]
impl Driven {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + q.cos() + u * q
    }
}

type Rule<R> = Integrator<Pendulum, R>;
type Start = State<[f64; 1]>;

fn noise(pendulum: Rule<Gauss<8>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).tolerance(1e-8);
}

fn other_rule(pendulum: Rule<Midpoint>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
}

fn few_stages(pendulum: Rule<Gauss<3>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
}

fn stage_noise(pendulum: Rule<StageNoise<Gauss<8>>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
}

fn weak_order(pendulum: Rule<Weak2<Gauss<8>>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
}

fn composition(pendulum: Rule<Composed<Gauss<8>, KahanLi8>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
}

fn no_iteration(particle: Integrator<Relativistic, Gauss<8>>, start: Start) {
    let _ = particle.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
}

fn inputs(driven: Integrator<Driven, Gauss<8>>, start: Start) {
    let _ = driven.trajectory(start, 0.1, NoNoise).inputs(|_, _| 1.0).tolerance(1e-8);
}

fn refined_behind(pendulum: Rule<Gauss<8>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8).refine(3);
}

fn refined_before(pendulum: Rule<Gauss<8>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).refine(3).tolerance(1e-8);
}

fn compensated(pendulum: Rule<Gauss<8>>, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8).compensated();
}

fn changed_before(pendulum: Rule<Gauss<8>>, start: Start) {
    let path = pendulum.trajectory(start, 0.1, NoNoise);
    let _ = path.change_at(|_, state| state.q[0], |_, _| ()).tolerance(1e-8);
}

/// With steps of τ.
struct Scaled;

#[variational(gauss(8))]
impl Scaled {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[time_scale]
    fn scale(&self, q: f64) -> f64 {
        1.0 + q * q
    }
}

fn compensated_in_tau(scaled: Integrator<Scaled, Gauss<8>>, start: TimedState<[f64; 1]>) {
    let _ = scaled.trajectory(start, 0.1, NoNoise).compensated();
}

fn main() {}
