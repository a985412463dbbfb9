//! The systems and ensembles of the tests.

use std::path::PathBuf;

use sve_runtime::prelude::*;

/// A circle with noise in its speed.
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - 0.5 * self.a * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

/// A pendulum with a shaken support: its steps are iterated.
pub(crate) struct Pendulum {
    pub(crate) g: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

pub(crate) type Method = Integrator<Kubo, Midpoint>;

pub(crate) fn kubo() -> Method {
    Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint)
}

pub(crate) fn pendulum() -> Integrator<Pendulum, Midpoint> {
    Integrator::new(Pendulum { g: 9.8, sigma: 0.7 }, Midpoint)
}

/// Returns an ensemble with one result of each kind, in which some paths fail.
pub(crate) fn with_all(method: &Method, paths: u64) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(paths)
        .seed(3)
        .steps(0.05, 30)
        .every(7)
        .start(Starts::each(|_, rng| {
            State::new([rng.normal()], [rng.uniform()])
        }))
        .observe("q", |_, s| if s.q[0] > 2.5 { f64::NAN } else { s.q[0] })
        .observe("energy", |system, s| system.hamiltonian(s))
        .histogram("q", -2.0..2.0, 9)
        .histogram("energy", 0.0..3.0, Bins::at_end(5))
        .keep_final_states(true)
}

/// Returns the path of a file that tests write.
pub(crate) fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Returns all bits of a summary.
pub(crate) fn bits(summary: &Summary) -> Vec<u8> {
    postcard::to_stdvec(summary).expect("the stored form of a summary")
}
