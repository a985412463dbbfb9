//! Noether's theorem of the discrete step: if the generator of a symmetry is affine, steps of any
//! size conserve its momentum to rounding, with noise too.
//!
//! Bound: a step rounds each p once in its last addition, and its equations hold to a few units of
//! rounding (Newton's tolerance is two), so the momentum changes by about 4ε times the size of its
//! terms. The changes are practically independent from step to step and add up to 4ε√n times this
//! size after n steps; the bound is four times as large. A wrong term has an effect of order h².

use sve_models::models::{Central, Chain, Charges, Mixed, Stretched};
use sve_models::oracle::{central, chain, charges, mixed, stretched};
use sve_models::stepper::Stepper;
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

const STEPS: u32 = 5000;

/// Largest product of a coordinate, or 1, with a momentum.
fn size_of<Q: VectorCoordinates<N>, const N: usize>(state: &State<Q>) -> f64 {
    let largest = |x: [f64; N]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    largest(state.q.coordinates()).max(1.0) * largest(Q::components(&state.p))
}

/// Returns the largest drift of `momentum` in units of the bound.
fn drift<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    momentum: impl Fn(&S, &State<Q>) -> f64,
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let expected = momentum(integrator.system(), &start);
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    let path = integrator.trajectory(start, 0.05, Wiener::new(8));
    for (n, state) in (1..=STEPS).zip(path) {
        let state = state.unwrap();
        size = size.max(size_of(&state));
        let bound = 16.0 * f64::EPSILON * f64::from(n).sqrt() * size;
        let change = momentum(integrator.system(), &state) - expected;
        worst = worst.max(change.abs() / bound);
    }
    println!(
        "{}: {worst} of the bound",
        sve_models::oracle::name(integrator)
    );
    worst
}

/// Central and translated potentials, and two momenta of six coordinates with noise of every kind:
/// the momentum at the start, and its drift by each rule.
#[test]
fn momenta_of_affine_symmetries_are_conserved() {
    macro_rules! conserved {
        ($($system:expr, $start:expr, $momentum:expr, $value:expr, $bound:expr;)*) => {$(
            let (system, start) = ($system, $start);
            let found = $momentum(&system, &start);
            assert!((found - $value).abs() <= $bound, "{}: {found}", stringify!($momentum));
            let drifts = [
                drift(&Integrator::new(&system, InitialPoint), start, |s, z| $momentum(s, z)),
                drift(&Integrator::new(&system, Endpoint), start, |s, z| $momentum(s, z)),
                drift(&Integrator::new(&system, Midpoint), start, |s, z| $momentum(s, z)),
            ];
            assert!(drifts.iter().all(|x| *x < 1.0), "{}: {drifts:?}", stringify!($momentum));
        )*};
    }
    let plane = State::new([1.0, 0.2], [-0.3, 0.8]);
    let row = State::new(
        [0.1, -0.2, 0.3, 0.0, 0.2, -0.1],
        [0.3, 0.1, -0.5, 0.7, 0.2, -0.4],
    );
    let space = State::new(
        [[0.7, 0.1, -0.2], [-0.6, 0.2, 0.3]],
        [[0.1, 0.5, 0.2], [-0.2, -0.4, -0.1]],
    );
    let pairs = space.q.iter().zip(&space.p);
    let rotation = pairs.map(|(q, p)| q[0] * p[1] - q[1] * p[0]).sum::<f64>();
    let shift = charges().0.shift_momentum(&space);
    conserved! {
        central(), plane, Central::rotation_momentum, 1.0 * 0.8 - 0.2 * -0.3, 0.0;
        chain(), row, Chain::shift_momentum, 0.4, 1e-15;
        charges().0, space, Charges::rotation_momentum, rotation, 1e-15;
        charges().0, space, Charges::shift_momentum, shift, 0.0;
    }
}

/// Order in h with which steps of the midpoint rule conserve a momentum over unit time.
fn order_of_conservation<S>(system: S, momentum: impl Fn(&S, &State<[f64; 1]>) -> f64) -> f64
where
    S: Variational<Midpoint> + System<Dims = Dims<1, 0>>,
{
    let start = State::new([0.1], [0.8]);
    let midpoint = Integrator::new(&system, Midpoint);
    let [coarse, fine] = [32, 64].map(|steps| {
        let end = midpoint.after(start, 1.0 / f64::from(steps), &[], steps);
        (momentum(&system, &end) - momentum(&system, &start)).abs()
    });
    (coarse / fine).log2()
}

/// A free particle seen in a frame that expands, x = eᵗ q: its symmetry depends on time.
struct Expanding;

#[variational(midpoint)]
impl Expanding {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * (t.exp() * (v + q)).powi(2)
    }

    #[symmetry]
    fn shift(&self, t: f64, _q: f64) -> f64 {
        (-t).exp()
    }
}

/// If a generator is not affine, or depends on time, the motion conserves its momentum, but steps
/// conserve it only to their order of accuracy, 2.
#[test]
fn other_symmetries_are_conserved_to_the_order_of_the_rule() {
    let plan = Integrator::new(Expanding, Midpoint).plan();
    assert!(plan.conserved.is_empty());
    for order in [
        order_of_conservation(stretched(), Stretched::shift_momentum),
        order_of_conservation(Expanding, Expanding::shift_momentum),
    ] {
        // the next term of the error is of relative size h
        assert!((order - 2.0).abs() < 0.05, "{order}");
    }
}

/// A quantity that is not conserved exceeds the bound by far, so the test can fail.
#[test]
fn without_the_symmetry() {
    let start = State::new([0.2, -0.1], [0.1, 0.3]);
    let quiet = Mixed {
        s: [0.0; 3],
        ..mixed()
    };
    let angular =
        |_: &Mixed, state: &State<[f64; 2]>| state.q[0] * state.p[1] - state.q[1] * state.p[0];
    assert!(drift(&Integrator::new(quiet, Midpoint), start, angular) > 1e6);
}
