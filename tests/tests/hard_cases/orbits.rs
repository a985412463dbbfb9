//! Orbits close to a singularity or to an unstable equilibrium.

use std::f64::consts::{PI, TAU};

use sve_models::models::{HenonHeiles, Kepler, PlanarDoublePendulum};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Returns the aphelion of an orbit of semi-major axis 1 around a unit mass.
fn aphelion(e: f64) -> State<[f64; 2]> {
    State::new([1.0 + e, 0.0], [0.0, ((1.0 - e) / (1.0 + e)).sqrt()])
}

/// Returns the largest error of the energy in both halves of a thousand periods, and the relative
/// change of the angular momentum.
fn thousand_periods<S, const M: usize>(
    system: S,
    start: State<[f64; 2]>,
    steps: u32,
    energy_error: impl Fn(&S, &State<[f64; 2]>) -> f64,
    angular: impl Fn(&S, &State<[f64; 2]>) -> f64,
) -> ([f64; 2], f64)
where
    S: Variational<Midpoint> + System<Dims = Dims<2, M>>,
{
    let integrator = Integrator::new(system, Midpoint);
    let (mut worst, mut state) = ([0.0_f64; 2], start);
    let path = integrator.trajectory(start, TAU / f64::from(steps), NoNoise);
    for (step, next) in (1..=1000 * steps).zip(path) {
        state = next.unwrap();
        let half = usize::from(step > 500 * steps);
        worst[half] = worst[half].max(energy_error(integrator.system(), &state).abs());
    }
    // no drift: the second five hundred periods are as good
    assert!((worst[1] / worst[0] - 1.0).abs() < 0.05, "{worst:?}");
    let [before, after] = [start, state].map(|state| angular(integrator.system(), &state));
    (worst, (after / before - 1.0).abs())
}

/// A thousand periods of e = 0.9 in steps of a five-thousandth: the energy error returns to what it
/// was in each period (its largest value belongs to the pericentre, where the step is a fifth of
/// the radian of the local orbit), angular momentum is conserved to the rounding of 5 10⁶ steps, a
/// random walk of 2000 times a few units in the last place; errors of one sign would give 10⁻⁹.
#[test]
fn kepler_of_eccentricity_0_9() {
    let (worst, change) = thousand_periods(
        Kepler { k: 1.0, sigma: 0.0 },
        aphelion(0.9),
        5000,
        |kepler, state| kepler.hamiltonian(state).unwrap() + 0.5,
        Kepler::rotation_momentum,
    );
    assert!(worst[0] < 4e-3, "{worst:?}");
    assert!(change < 1e-11, "{change:e}");
}

/// The same planet in the time s of dt = r ds (Poincaré), on the level of its energy E:
/// L = |q′|²/2r + 1 + Er.
struct Regular {
    energy: f64,
}

#[variational(midpoint)]
impl Regular {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r = q[0].hypot(q[1]);
        0.5 * (v[0] * v[0] + v[1] * v[1]) / r + 1.0 + self.energy * r
    }

    #[symmetry]
    fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

/// e = 0.99: the pericentre is passed within a ten-thousandth of a period, which equal steps of t
/// have to resolve; in a time that slows down there 2000 steps a period are enough for a thousand
/// periods.
#[test]
fn kepler_of_eccentricity_0_99() {
    let (worst, change) = thousand_periods(
        Regular { energy: -0.5 },
        aphelion(0.99),
        2000,
        |_, state| {
            let kinetic = 0.5 * (state.p[0].powi(2) + state.p[1].powi(2));
            kinetic - state.q[0].hypot(state.q[1]).recip() + 0.5
        },
        Regular::rotation_momentum,
    );
    assert!(worst[0] < 0.02, "{worst:?}");
    assert!(change < 1e-11, "{change:e}");
}

/// Equal steps that do not resolve the pericentre of e = 0.99 give a wrong orbit or an error: never
/// NaN, and never a wrong angular momentum, which the equations conserve on each of their branches.
#[test]
fn an_unresolved_pericentre_is_not_hidden() {
    let kepler = Integrator::new(Kepler { k: 1.0, sigma: 0.0 }, Midpoint);
    let start = aphelion(0.99);
    let angular = kepler.system().rotation_momentum(&start);
    for steps in [300, 1000, 3000] {
        let path = kepler.trajectory(start, TAU / f64::from(steps), NoNoise);
        for state in path.take(20_000).map_while(Result::ok) {
            let change = kepler.system().rotation_momentum(&state) / angular - 1.0;
            assert!(change.abs() < 1e-9, "{steps}: {change:e}");
        }
    }
}

/// Released a thousandth of a radian from upright, both arms: the fall is chaotic, the energy is
/// not. The error is of second order in h, with no drift: the second half is no worse than the
/// first by more than chaos explains.
#[test]
fn double_pendulum_from_upright() {
    let system = PlanarDoublePendulum {
        m: [1.0, 1.0],
        l: [1.0, 1.0],
        g: 9.8,
    };
    let pendulum = Integrator::new(system, Midpoint);
    let start = State::new([PI - 1e-3, PI + 1e-3], [0.0; 2]);
    let first = pendulum.system().hamiltonian(&start).unwrap();
    let worst = |steps: usize| {
        let h = 100.0 / steps as f64;
        let mut worst = [0.0_f64; 2];
        let path = pendulum.trajectory(start, h, NoNoise);
        for (step, state) in path.take(steps).enumerate() {
            let energy = pendulum.system().hamiltonian(&state.unwrap()).unwrap();
            let half = usize::from(step > steps / 2);
            worst[half] = worst[half].max((energy - first).abs() / first);
        }
        worst
    };
    let (coarse, fine) = (worst(25_000), worst(100_000));
    assert!(
        coarse[1] < 3.0 * coarse[0] && fine[1] < 3.0 * fine[0],
        "{coarse:?} {fine:?}"
    );
    assert!(coarse[1] < 2e-3, "{coarse:?}");
    let ratio = coarse[1] / fine[1];
    assert!((4.0..64.0).contains(&ratio), "{ratio}");
}

/// Hénon–Heiles just below the energy 1/6 of escape: the orbit wanders over nearly all of the
/// triangle and must not leave it, though a relative energy error of 10⁻³ upwards would let it.
#[test]
fn henon_heiles_at_the_edge_of_chaos() {
    let system = Integrator::new(HenonHeiles, Midpoint);
    let edge = 1.0 / 6.0;
    for below in [1e-3, 1e-2] {
        let energy = edge - below;
        let y = 0.1_f64;
        let potential = 0.5 * y * y - y.powi(3) / 3.0;
        let start = State::new([0.0, y], [(2.0 * (energy - potential)).sqrt(), 0.0]);
        let mut worst = [0.0_f64; 2];
        let steps = 200_000;
        for (step, state) in system
            .trajectory(start, 0.02, NoNoise)
            .take(steps)
            .enumerate()
        {
            let state = state.unwrap();
            let error = system.system().hamiltonian(&state).unwrap() - energy;
            let half = usize::from(step > steps / 2);
            worst[half] = worst[half].max(error.abs());
            assert!(state.q[0].hypot(state.q[1]) < 1.01, "{state:?}");
        }
        assert!(
            worst[1] < 0.5 * below && worst[1] < 2.0 * worst[0],
            "{worst:?}"
        );
    }
}
