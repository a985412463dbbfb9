//! Each function, or function of a system, has a mistake that its types show.

use sve_runtime::baseline::Heun;
use sve_runtime::noise::Noise;
use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint, gauss(3, stage_noise))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        q
    }
}

/// Without noise.
struct Quiet {
    g: f64,
}

#[variational(midpoint)]
impl Quiet {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// With a motor.
struct Driven {
    g: f64,
}

#[variational(midpoint)]
impl Driven {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + self.g * q.cos() + u * q
    }
}

/// With a second input that nothing reads.
struct Unread;

#[variational(midpoint)]
impl Unread {
    fn lagrangian(&self, q: f64, v: f64, u: [f64; 2]) -> f64 {
        0.5 * v * v + u[0] * q
    }
}

type Noisy = Integrator<Pendulum, Midpoint>;
type Staged = Integrator<Pendulum, StageNoise<Gauss<3>>>;
type Start = State<[f64; 1]>;

fn unlisted_rule() {
    let _ = Integrator::new(Quiet { g: 1.0 }, Endpoint);
}

fn increment_as_a_number(pendulum: Noisy, mut state: Start) {
    let _ = pendulum.step(&mut state, 0.1, 0.5);
}

fn too_few_increments(pendulum: Noisy, mut state: Start) {
    let _ = pendulum.step(&mut state, 0.1, &[]);
}

fn too_many_increments(quiet: Integrator<Quiet, Midpoint>, mut state: Start) {
    let _ = quiet.step(&mut state, 0.1, &[0.5]);
}

fn too_many_coordinates(pendulum: Noisy) {
    let mut state = State::new([1.0, 2.0], [0.0, 0.0]);
    let _ = pendulum.step(&mut state, 0.1, &[0.5]);
}

fn step_without_inputs(driven: Integrator<Driven, Midpoint>, mut state: Start) {
    let _ = driven.step(&mut state, 0.1, &[]);
}

fn path_without_inputs(driven: Integrator<Driven, Midpoint>, start: Start) {
    let _ = driven.trajectory(start, 0.1, Wiener::new(1)).last();
    for _ in driven.trajectory(start, 0.1, Wiener::new(1)) {}
}

fn ensemble_without_inputs(driven: Integrator<Driven, Midpoint>, start: Start) {
    let _ = Ensemble::new(&driven).start(start).steps(0.1, 10).paths(10).run();
}

fn lengths_of_a_state_differ() {
    let _ = State::new([1.0], [0.0, 0.0]);
}

fn seed_as_noise(pendulum: Noisy, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, 42);
}

fn change_without_a_state(pendulum: Noisy, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).change_at(|_, state| state.q[0], |_| ());
}

fn direction_without_a_function(pendulum: Noisy, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).rising();
}

fn section_at_a_condition(pendulum: Noisy, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).stop_at(|_, state| state.q[0] > 1.5);
}

fn section_of_a_recorded_path(pendulum: Noisy, start: Start, recorded: Recorded) {
    let _ = pendulum.trajectory(start, 0.1, recorded).crossings(|_, state| state.q[0]);
}

fn section_of_a_weak_path(pendulum: Noisy, start: Start) {
    let bounce = |_: &Pendulum, state: &mut Start| state.p[0] = -state.p[0];
    let _ = pendulum.trajectory(start, 0.1, ThreePoint::new(1)).change_at(|_, state| state.q[0], bounce);
}

fn section_with_stage_noise(pendulum: Staged, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).crossings(|_, state| state.q[0]);
}

fn refined_stage_noise(pendulum: Staged, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).refine(3);
}

fn section_of_a_refined_path(pendulum: Noisy, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Wiener::new(1)).refine(3).crossings(|_, state| state.q[0]);
}

fn gradient_of_a_baseline(start: Start) {
    let heun = Heun::new(Pendulum { g: 9.8 });
    let _ = heun.trajectory(start, 0.1, Wiener::new(1)).gradient(10, |_, state| Some(state.q[0]));
}

fn gradient_of_a_jump(pendulum: Noisy, start: Start) {
    let path = pendulum.trajectory(start, 0.1, Wiener::new(1));
    let _ = path.gradient(10, |_, state| (state.q[0] > 1.0).then(|| state.p[0].abs()));
}

/// A source whose increments follow one another.
struct Draws(f64);

impl Noise for Draws {
    fn increments(&mut self, _: u64, _: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0 = -self.0;
        dw.fill(self.0);
        Ok(())
    }
}

fn gradient_with_draws_in_a_row(pendulum: Noisy, start: Start) {
    let _ = pendulum.trajectory(start, 0.1, Draws(0.1)).gradient(10, |_, state| Some(state.q[0]));
}

struct UnknownField;

#[variational(midpoint)]
impl UnknownField {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[1] * v[1] - self.gravity * (q[0] - q[1]).cos()
    }
}

struct Oscillator {
    stiffness: Matrix2<f64>,
}

#[variational(midpoint, endpoint)]
impl Oscillator {
    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        0.5 * v.norm_squared() - (self.stiffness * q).norm_squared()
    }

    #[gamma]
    fn push(&self, q: Vector2<f64>) -> f64 {
        (self.stiffness * q).x
    }
}

struct NotASystem;

fn not_a_system() {
    let _ = Integrator::new(NotASystem, Midpoint);
}

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

fn splitting_of_another_lagrangian() {
    let _ = Integrator::new(Bead, Split::new(BlanesMoan4));
    let _ = Integrator::new(Relativistic, Split::new(BlanesMoanRkn6));
    let _ = Integrator::new(Spring, Split::new(BlanesMoan4));
    let _ = Composed::new(InitialPoint, KahanLi8);
}

/// A planet at the pace of its distance.
struct Planet;

#[variational(midpoint)]
impl Planet {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / q[0].hypot(q[1])
    }

    #[time_scale]
    fn scale(&self, q: [f64; 2]) -> f64 {
        q[0].hypot(q[1])
    }
}

fn noise_without_numbered_paths(pendulum: Noisy, noise: FromRng<u64>) {
    let _ = Ensemble::new(&pendulum).noise(noise);
}

fn ensemble_with_a_time_scale(planet: Integrator<Planet, Midpoint>) {
    let _ = Ensemble::new(&planet);
}

fn main() {}
