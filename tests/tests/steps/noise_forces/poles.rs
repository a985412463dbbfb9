//! Poles of steps with noise forces: eigenvalues that pass a pole together, constraints, lanes.

use sve_runtime::ensemble::Cause;
use sve_runtime::noise::ThreePoint;
use sve_runtime::prelude::*;

use super::{Gusts, Rubbing};

/// Three bodies in a plane with the same friction noise: six coupled unknowns, whose eigenvalues
/// pass the pole together, so that no determinant changes its sign.
struct Three;

#[variational(midpoint, stormer_verlet)]
impl Three {
    fn lagrangian(&self, q: [Vector2<f64>; 3], v: [Vector2<f64>; 3]) -> f64 {
        let mut l = 0.0;
        for i in 0..3 {
            l += 0.5 * v[i].norm_squared();
            for j in 0..i {
                l -= 0.5 * ((q[i] - q[j]).norm_squared() + 1.0).sqrt();
            }
        }
        l
    }
    #[force(noise)]
    fn rub(&self, _q: [Vector2<f64>; 3], v: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        v
    }
}

/// Masses that are all coupled.
struct Dense;

#[variational(midpoint, stormer_verlet)]
impl Dense {
    fn lagrangian(&self, q: [f64; 6], v: [f64; 6]) -> f64 {
        let sum: f64 = v.iter().sum();
        let squares: f64 = v.iter().map(|v| 0.5 * v * v).sum();
        squares + 0.1 * sum * sum - q.iter().map(|q| 0.5 * q * q).sum::<f64>()
    }
    #[force(noise)]
    fn rub(&self, _q: [f64; 6], v: [f64; 6]) -> [f64; 6] {
        let sum: f64 = v.iter().sum();
        v.map(|v| v + 0.2 * sum)
    }
}

/// A bead on a sphere.
struct Bead {
    sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Bead {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) - q[2]
    }
    #[force(noise)]
    fn rub(&self, _q: [f64; 3], v: [f64; 3]) -> [f64; 3] {
        v.map(|v| self.sigma * v)
    }
    #[constraint]
    fn sphere(&self, q: [f64; 3]) -> f64 {
        0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0)
    }
}

/// A force that turns the velocity, with a pole of the initial-point rule at y = 1 ± i.
struct Turning;

#[variational(initial_point, endpoint)]
impl Turning {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * q[0] * q[0]
    }
    #[force(noise)]
    fn turn(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [v[0] - v[1], v[0] + v[1]]
    }
}

#[test]
fn poles_of_several_eigenvalues_are_errors_too() {
    let plane = [0.3, -0.2, 0.9].map(|x| Vector2::new(x, 0.4 - x));
    let row = [0.3, -0.2, 0.9, 0.1, -0.5, 0.6];
    macro_rules! check {
        ($system:expr, $rule:expr, $start:expr, $pole:expr) => {
            let integrator = Integrator::new($system, $rule);
            let rule = integrator.plan().to_string();
            for dw in [2.1, 2.5, 4.0, 6.0, 100.0, 1e4, 1e6] {
                let mut state = $start;
                let result = integrator.step(&mut state, 0.01, &[dw]);
                let is_pole = matches!(result, Err(StepError::NoisePole { .. }));
                assert_eq!(is_pole, dw > $pole, "{dw}: {result:?} {rule}");
                assert_eq!(integrator.tangent(&$start, 0.01, &[dw]).is_err(), is_pole);
            }
            for dw in [-30.0, -0.5, 0.9] {
                integrator.step(&mut { $start }, 0.01, &[dw]).unwrap();
            }
        };
    }
    check!(Three, Midpoint, State::new(plane, plane), 2.0);
    check!(Three, StormerVerlet, State::new(plane, plane), 2.0);
    check!(Dense, Midpoint, State::new(row, row), 2.0);
    check!(Dense, StormerVerlet, State::new(row, row), 2.0);
    check!(
        Turning,
        InitialPoint,
        State::new([0.3, 0.1], [0.2, 0.5]),
        1.0
    );
    check!(
        Turning,
        Endpoint,
        State::new([0.3, 0.1], [0.2, 0.5]),
        f64::INFINITY
    );
    for dw in [2.1, 3.0, 4.0, 5.0, 6.0, 100.0, 1e4] {
        let mut state = State::new([1.0, 0.0, 0.0], [0.0, 0.4, 0.3]);
        let bead = Integrator::new(Bead { sigma: 1.0 }, Midpoint);
        assert!(bead.step(&mut state, 0.01, &[dw]).is_err(), "{dw}");
        let bead = Integrator::new(Bead { sigma: 1.0 }, StormerVerlet);
        assert!(bead.step(&mut state, 0.01, &[dw]).is_err(), "{dw}");
    }
}

/// A lost branch of another noise is none of a force.
#[test]
fn a_weak_noise_force_is_not_blamed() {
    struct Both;
    #[variational(gauss(2))]
    impl Both {
        fn lagrangian(&self, q: f64, v: f64) -> f64 {
            0.5 * v * v + q.cos()
        }
        #[gamma]
        fn shake(&self, q: f64) -> f64 {
            q.cos()
        }
        #[force(noise)]
        fn rub(&self, _q: f64, v: f64) -> f64 {
            1e-9 * v
        }
    }
    let integrator = Integrator::new(Both, Gauss::<2>);
    let mut lost = 0;
    for k in 0..60 {
        let mut state = State::new([0.1 * f64::from(k)], [0.3]);
        if let Err(error) = integrator.step(&mut state, 0.5, &[-59.5, 0.0]) {
            assert!(!matches!(error, StepError::NoisePole { .. }), "{error}");
            lost += 1;
        }
    }
    assert!(lost > 0);
}

/// Increments of three values are 0 or ±√(3h), so that these beads meet `σΔW` = 0 or ±y. The step
/// has a pole at 2, and from 3.5 on Newton's method contracts beyond it.
#[test]
fn a_path_of_an_ensemble_fails_at_the_pole_of_the_single_step() {
    let (h, paths) = (0.01_f64, 64);
    let start = State::new([1.0, 0.0, 0.0], [0.0, 0.4, 0.3]);
    macro_rules! check {
        ($rule:expr, $y:expr) => {
            let sigma = $y / (3.0 * h).sqrt();
            let integrator = Integrator::new(Bead { sigma }, $rule);
            let summary = Ensemble::new(&integrator)
                .paths(paths)
                .noise(ThreePoint::new(1))
                .steps(h, 1)
                .start(start)
                .run()
                .unwrap();
            let mut poles = 0;
            for path in 0..paths {
                let dw = ThreePoint::new(1).path(path).increment(0, 0, h);
                let expected = integrator.step(&mut { start }, h, &[dw]);
                let failure = summary.failures().iter().find(|f| f.path == path);
                match (&expected, failure.map(|f| &f.cause)) {
                    (Ok(()), None) => {}
                    (Err(error), Some(Cause::Step(found))) => {
                        assert!(matches!(error, StepError::NoisePole { .. }), "{error:?}");
                        assert_eq!(found, error);
                        poles += 1;
                    }
                    pair => panic!("path {path}, ΔW = {dw}: {pair:?}"),
                }
            }
            assert!(poles > 0);
        };
    }
    for y in [2.5, 5.0] {
        check!(Midpoint, y);
        check!(StormerVerlet, y);
    }
}

/// A bead whose noise force has the strength of its input.
pub(crate) struct Driven;

#[variational(midpoint, stormer_verlet)]
impl Driven {
    fn lagrangian(&self, _q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * v.iter().map(|v| v * v).sum::<f64>()
    }
    #[constraint]
    fn sphere(&self, q: [f64; 3]) -> f64 {
        q.iter().map(|q| q * q).sum::<f64>() - 1.0
    }
    #[force(noise)]
    fn rub(&self, _q: [f64; 3], v: [f64; 3], u: f64) -> [f64; 3] {
        v.map(|v| u * v)
    }
}

/// Each path of an ensemble meets the pole of its own inputs.
#[test]
fn poles_of_paths_with_inputs() {
    let (h, paths) = (0.01_f64, 64);
    let start = State::new([1.0, 0.0, 0.0], [0.0, 0.4, 0.3]);
    let strength = |path: u64| [0.5, 1.5, 2.5, 5.0][path as usize % 4] / (3.0 * h).sqrt();
    macro_rules! check {
        ($rule:expr) => {
            let integrator = Integrator::new(Driven, $rule);
            let summary = Ensemble::new(&integrator)
                .inputs("strength", |path, _, _| strength(path))
                .paths(paths)
                .noise(ThreePoint::new(1))
                .steps(h, 2)
                .start(start)
                .run()
                .unwrap();
            for path in 0..paths {
                let noise = ThreePoint::new(1).path(path);
                let mut alone = integrator
                    .trajectory(start, h, noise)
                    .inputs(|_, _| strength(path));
                let failure = summary.failures().iter().find(|f| f.path == path);
                match (alone.advance(2).err(), failure.map(|f| &f.cause)) {
                    (None, None) => {}
                    (Some(error), Some(Cause::Step(found))) => {
                        assert!(matches!(error, StepError::NoisePole { .. }), "{error}");
                        assert_eq!(*found, error);
                    }
                    pair => panic!("path {path}: {pair:?}"),
                }
            }
            // half of the paths have a pole at √(3h), which a sixth of the increments is: 9.8 ± 2.6
            assert!((2..=18).contains(&summary.failed()), "{}", summary.failed());
        };
    }
    check!(Midpoint);
    check!(StormerVerlet);
}

/// A force of positions has no pole, and an infinite increment shows in the state.
#[test]
fn an_infinite_increment_of_a_noise_force_is_an_error() {
    for dw in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let gusts = Integrator::new(Gusts, Midpoint);
        let rubbing = Integrator::new(Rubbing { sigma: 0.8 }, Midpoint);
        for q in [0.0, 0.3] {
            let start = State::new([q], [1.0]);
            assert!(gusts.step(&mut { start }, 0.1, &[dw]).is_err(), "{q} {dw}");
            assert!(
                rubbing.step(&mut { start }, 0.1, &[dw]).is_err(),
                "{q} {dw}"
            );
        }
    }
}
