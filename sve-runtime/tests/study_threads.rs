//! A study has the same bits for any number of threads.
#![cfg(feature = "study")]

use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;
use sve_runtime::study::{Report, Study};

#[derive(Clone, Copy)]
struct Pendulum {
    g: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[gamma]
    fn shake(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

#[test]
fn threads_change_no_bit() {
    let system = Pendulum { g: 9.8, sigma: 0.3 };
    let (midpoint, heun) = (Integrator::new(system, Midpoint), Heun::new(system));
    let on = |threads: usize| -> Report {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let run = || {
            Study::new("pendulum")
                .start(State::new([1.0], [0.0]))
                .horizon(1.0)
                .steps([8, 32])
                .paths(97)
                .method("midpoint", &midpoint)
                .method("Heun", &heun)
                .fine(&midpoint, 4)
                .observe("energy", Mechanics::hamiltonian)
                .repeats(0)
                .run()
                .unwrap()
        };
        pool.build().unwrap().install(run)
    };
    let one = on(1);
    assert!(one.rows()[0].error.unwrap().value > 0.0);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}
