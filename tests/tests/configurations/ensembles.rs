//! Ensembles and studies.

use sve_models::configured::Configured;
use sve_models::models::Charges;
use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;
use sve_runtime::study::Study;

use crate::{H, START, Six, flat, state, system};

#[test]
fn ensembles_have_the_bits_of_the_coordinates() {
    fn summary<Q: Six>(method: &Integrator<Configured<Charges, Q>, Midpoint>) -> Vec<Vec<f64>> {
        let ensemble = Ensemble::new(method)
            .paths(70)
            .seed(2)
            .steps(H, 12)
            .start(Starts::each(|_, rng| {
                let mut start = START;
                start.q[0] += 0.1 * rng.normal();
                state::<Q, 6>(&start)
            }))
            .observe("energy", Mechanics::hamiltonian)
            .observe("last", |_, state: &State<Q>| flat(state).p[5])
            .keep_final_states(true);
        let summary = ensemble.run().unwrap();
        let mut numbers = Vec::new();
        for statistics in summary.statistics() {
            numbers.push([statistics.mean(), &statistics.variance()].concat());
        }
        for (path, end) in summary.final_states() {
            numbers.push([end.q, end.p].concat());
            let state: State<Q> = end.state().unwrap();
            assert_eq!(state, end);
            assert_eq!(end.state::<Vector2<f64>>(), None);
            if path % 23 == 0 {
                let last = ensemble.replay(path).unwrap().last();
                assert_eq!(last.unwrap().unwrap(), state);
            }
        }
        numbers
    }
    let expected = summary(&Integrator::new(system::<[f64; 6]>(), Midpoint));
    assert_eq!(expected.len(), 72);
    let nested = Integrator::new(system::<[[f64; 3]; 2]>(), Midpoint);
    assert_eq!(summary(&nested), expected);
    let vectors = Integrator::new(system::<[Vector3<f64>; 2]>(), Midpoint);
    assert_eq!(summary(&vectors), expected);
}

#[test]
fn studies_have_the_bits_of_the_coordinates() {
    fn errors<Q: Six>() -> Vec<f64> {
        let integrator = Integrator::new(system::<Q>(), Midpoint);
        let heun = Heun::new(system::<Q>());
        let report = Study::new("charges")
            .start(state::<Q, 6>(&START))
            .horizon(0.4)
            .step_counts([4, 8])
            .paths(3)
            .method("midpoint", &integrator)
            .method("Heun", &heun)
            .fine(&integrator, 4)
            .observe("energy", Mechanics::hamiltonian)
            .repeats(0)
            .run()
            .unwrap();
        let rows = report.rows().iter();
        rows.map(|row| row.error.unwrap().value).collect()
    }
    let expected = errors::<[f64; 6]>();
    assert_eq!(expected.len(), 4);
    assert!(expected.iter().all(|&error| error > 0.0));
    assert_eq!(errors::<[Vector3<f64>; 2]>(), expected);
}
