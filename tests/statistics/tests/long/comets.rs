//! The energy of a comet with a time scale over a hundred thousand periods.

use std::f64::consts::TAU;

use sve_models::models::Comet;
use sve_runtime::prelude::*;

/// The orbit has the eccentricity 0.9, and 8.4 steps a period. Each step rounds the kinetic energy
/// at the perihelion, 9.5, so the energy wanders by about 9.5 ε√n/2: its mean over the first tenth
/// of the steps is compared with that over the last one.
#[test]
fn the_energy_of_a_comet_has_no_drift_in_a_hundred_thousand_periods() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    let start = TimedState::new(comet.system(), [0.1, 0.0], [0.0, 19.0_f64.sqrt()]).unwrap();
    let mut path = comet.trajectory(start, 1.0, NoNoise).until(1e5 * TAU);
    let (mut end, mut sums) = (*start, [[0.0; 2]; 10]);
    for (step, state) in path.by_ref().enumerate() {
        end = state.unwrap();
        let error = comet.system().hamiltonian(&end).unwrap() - start.energy();
        assert!(error.abs() < 1e-11, "{}: {error:e}", end.t);
        let [sum, count] = &mut sums[(step / 83_700).min(9)];
        (*sum, *count) = (*sum + error, *count + 1.0);
    }
    let means = sums.map(|[sum, count]| sum / count);
    let walk = 9.5 * 0.5 * f64::EPSILON * (path.step() as f64).sqrt();
    assert!(
        (means[9] - means[0]).abs() < 3.0 * walk,
        "{means:?} {walk:e}"
    );
    let error = (end.q[0] - start.q[0]).hypot(end.q[1]);
    assert!(error < 1e-7 && path.step() < 850_000, "{error:e}");
}
