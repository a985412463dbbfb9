//! A study has the same bits for any number of threads.

use sve_models::oracle::synchrotron;
use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;
use sve_runtime::study::{Report, Study};

#[test]
fn the_number_of_threads_changes_no_bit() {
    let system = synchrotron();
    let (midpoint, heun) = (Integrator::new(system.clone(), Midpoint), Heun::new(system));
    let on = |threads: usize| -> Report {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let run = || {
            Study::new("synchrotron")
                .start(State::new([1.0], [0.0]))
                .horizon(1.0)
                .step_counts([8, 32])
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
