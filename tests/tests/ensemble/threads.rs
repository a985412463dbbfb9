//! Threads change no bit.

use sve_models::models::Kubo;
use sve_runtime::prelude::*;

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let method = Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint);
    let run = |threads| {
        Ensemble::new(&method)
            .paths(1500)
            .seed(3)
            .steps(0.05, 40)
            .record_every(10)
            .start_with(|_, rng| State::new([rng.normal()], [rng.uniform()]))
            .observe("q", |_, state| state.q[0])
            .observe("energy", |system, state| system.hamiltonian(state))
            .histogram("q", -2.0..2.0, 10)
            .keep_final_states(true)
            .threads(threads)
            .run()
            .unwrap()
    };
    let one = run(1);
    for threads in [2, 3, 16] {
        assert_eq!(run(threads), one);
    }
    assert!(one["q"].variance()[4] > 0.1);
}
