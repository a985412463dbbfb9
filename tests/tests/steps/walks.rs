//! A step is a walk over substeps: sequences within sequences have all modes of a step.

use sve_runtime::prelude::*;
use sve_runtime::{Composition, Dims, LANES, OneStepMethod, Rule, StateLanes, System, Variational};

/// A pendulum whose pivot swings, so that the times of substeps matter.
struct Driven {
    g: f64,
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Driven {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * (1.0 + 0.3 * (2.0 * t).sin()) * q.cos()
    }

    #[gamma]
    fn shake(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

const H: f64 = 0.2;
const DW: f64 = 0.3;

/// A composition of a composition, which has 289 substeps.
type Nested<R> = Composed<Composed<R, KahanLi8>, KahanLi8>;

fn nested<R>(rule: R) -> Integrator<Driven, Nested<R>>
where
    Nested<R>: Rule<Driven>,
    Composed<R, KahanLi8>: Rule<Driven>,
    R: sve_runtime::Symmetric,
{
    let system = Driven { g: 1.7, sigma: 0.4 };
    Integrator::new(
        system,
        Composed::new(Composed::new(rule, KahanLi8), KahanLi8),
    )
}

fn start() -> State<[f64; 1]> {
    State::at(0.4, [0.8], [-0.3])
}

/// The outer step is 17 steps by the inner composition, bit for bit.
fn is_made_of_its_parts<R: Copy + sve_runtime::Symmetric>(rule: R)
where
    Driven: Variational<Composed<R, KahanLi8>> + Variational<Nested<R>>,
{
    let whole = nested(rule);
    let part = Integrator::new(whole.system(), Composed::new(rule, KahanLi8));
    let (mut state, mut expected) = (start(), start());
    whole.step(&mut state, H, &[DW]).unwrap();
    for &fraction in KahanLi8::FRACTIONS {
        part.step(&mut expected, fraction * H, &[fraction * DW])
            .unwrap();
    }
    assert_eq!((state.q, state.p), (expected.q, expected.p));
    assert_eq!(state.t, 0.4 + H);
}

#[test]
fn a_composition_of_a_composition_is_made_of_its_parts() {
    is_made_of_its_parts(StormerVerlet);
    is_made_of_its_parts(Midpoint);
}

/// The walk back through the substeps gives the row of the tangent map and the sensitivities that the walk forward gives.
fn goes_back<R: Copy + sve_runtime::Symmetric>(rule: R)
where
    Driven: Variational<Composed<R, KahanLi8>> + Variational<Nested<R>>,
{
    let method = nested(rule);
    let path = Recorded::new(H, [[DW]]).unwrap();
    let (tangent, sensitivity) = method
        .step_with_derivatives(&mut start(), H, &[DW])
        .unwrap();
    let gradient = method
        .trajectory(start(), H, &path)
        .gradient(1, |step, state| (step == 1).then(|| state.q[0]))
        .unwrap();
    let forward = [
        tangent[0][0],
        tangent[0][1],
        sensitivity.get("g").unwrap().q[0],
        sensitivity.get("sigma").unwrap().q[0],
    ];
    let backward = [
        gradient.start().q[0],
        gradient.start().p[0],
        gradient.get("g").unwrap(),
        gradient.get("sigma").unwrap(),
    ];
    for (x, y) in forward.into_iter().zip(backward) {
        assert!((x - y).abs() < 1e-12 * (1.0 + x.abs()), "{x} {y}");
    }
    assert!(tangent.symplectic_defect() < 1e-12);
}

#[test]
fn a_composition_of_a_composition_is_differentiated_forwards_and_backwards() {
    goes_back(StormerVerlet);
    goes_back(Midpoint);
}

#[test]
fn a_composition_of_a_composition_steps_in_lanes() {
    let method = nested(StormerVerlet);
    let mut lanes = StateLanes::splat(&start());
    for lane in 0..LANES {
        lanes.q[0][lane] += 0.01 * lane as f64;
    }
    let prepared = method.prepare(H).unwrap();
    let mut next = lanes;
    let unsolved = method.step_lanes(&prepared, &lanes, &mut next, H, &[[DW; LANES]]);
    assert_eq!(unsolved, 0);
    for lane in 0..LANES {
        let (mut state, found) = (lanes.get(lane), next.get(lane));
        method.step(&mut state, H, &[DW]).unwrap();
        assert!((found.q[0] - state.q[0]).abs() < 1e-13);
        assert!((found.p[0] - state.p[0]).abs() < 1e-13);
    }
}

/// One bound is enough for code over the rules of a system, and a bound of the system holds for references to it.
#[test]
fn one_bound_is_enough() {
    fn by_rule<R: Rule<Driven, Increments = [f64; 1]>>(system: Driven, rule: R) -> f64 {
        let mut state = start();
        let method = Integrator::new(system, rule);
        method.step(&mut state, H, &[DW]).unwrap();
        state.q[0]
    }
    fn by_system<S, R, const N: usize, const M: usize>(
        method: &Integrator<S, R>,
        start: &State<[f64; N]>,
    ) -> State<[f64; N]>
    where
        S: Variational<R, Prepared: Sync, Memory: Sync> + System<Dims = Dims<N, M>> + Sync,
        R: Sync,
    {
        let mut state = *start;
        method.step(&mut state, H, &[DW; M]).unwrap();
        let ensemble = Ensemble::new(method).paths(2).seed(1).steps(H, 1);
        assert!(ensemble.start(*start).run().unwrap().failures().is_empty());
        state
    }
    /// The same by the system, by a reference to it, and by a reference to that.
    fn by_references<S, R, const N: usize, const M: usize>(system: S, rule: R)
    where
        S: Variational<R, Prepared: Sync, Memory: Sync> + System<Dims = Dims<N, M>> + Sync,
        R: Copy + Sync,
    {
        let start = State::new([0.1; N], [0.2; N]);
        let once = by_system(&Integrator::new(&system, rule), &start);
        let twice = by_system(&Integrator::new(&&system, rule), &start);
        let owned = by_system(&Integrator::new(system, rule), &start);
        assert_ne!(owned, start);
        assert_eq!([once, twice], [owned, owned]);
    }
    let system = || Driven { g: 1.7, sigma: 0.4 };
    let composed = Composed::new(StormerVerlet, KahanLi8);
    assert!(by_rule(system(), StormerVerlet) != by_rule(system(), composed));
    by_references(system(), Midpoint);
    by_references(system(), composed);
    by_references(system(), Split::new(BlanesMoan4));
}
