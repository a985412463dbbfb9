//! Steps from a start that has none, by every function that steps.

use sve_runtime::__private::{Increments, LANES, StateLanes};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{OneStepMethod, Rule};

/// Makes steps from `bad`, which is no start, and from `good` by every function that steps. Returns
/// the error of a step.
pub(crate) fn refused<S, R, const N: usize, const M: usize>(
    system: S,
    rule: R,
    bad: State<[f64; N]>,
    good: State<[f64; N]>,
) -> StepError
where
    S: System<Dims = Dims<N, M>>,
    R: Rule<S::Itself, Increments: Increments + PartialEq>,
{
    let method = Integrator::new(system, rule);
    let what = core::any::type_name::<R>();
    let dw = R::Increments::NONE;
    let errors = [0.01, -0.01, 1e-6].map(|h| {
        let mut state = bad;
        let error = method.step(&mut state, h, &dw).expect_err(what);
        assert_eq!(state, bad, "{what}");
        let tangent = method.tangent(&bad, h, &dw).map(|_| ());
        assert_eq!(tangent, Err(error.clone()), "{what}");
        let mut prepared = OneStepMethod::prepare(&method, h).unwrap();
        // as trajectories step
        let next = method.next_step(&mut prepared, &mut state, h, &dw);
        assert_eq!(next, Err(error.clone()), "{what}");
        if method.has_compensated_step() {
            let low = &mut State::new([0.0; N], [0.0; N]);
            let next = method.compensated_step(&mut prepared, &mut state, low, h, &dw);
            assert_eq!(next, Err(error.clone()), "{what}");
        }
        assert_eq!(
            method.newton_iterations(&prepared, &bad, h, &dw),
            None,
            "{what}"
        );
        assert_eq!(state, bad, "{what}");
        error
    });
    let h = 0.01;
    let mut end = good;
    assert_eq!(method.step(&mut end, h, &dw), Ok(()), "{what}");
    // lanes with and without a start beside one another: those without are left to the scalar step
    let is_bad = |lane: usize| lane % 3 == 1;
    let mut states = StateLanes::splat(&good);
    for lane in (0..LANES).filter(|&lane| is_bad(lane)) {
        states.set(lane, &bad);
    }
    let (mut next, none) = (states, R::Increments::NO_LANES);
    let prepared = OneStepMethod::prepare(&method, h).unwrap();
    let unsolved = method.step_lanes(&prepared, &states, &mut next, h, &none);
    for lane in 0..LANES {
        let (is_left, found) = (unsolved >> lane & 1 == 1, next.get(lane));
        if is_bad(lane) {
            assert!(is_left, "{what}: lane {lane}");
        }
        if is_left {
            assert_eq!(
                (found.q, found.p),
                (states.get(lane).q, states.get(lane).p),
                "{what}"
            );
            continue;
        }
        for (x, y) in found
            .q
            .iter()
            .chain(&found.p)
            .zip(end.q.iter().chain(&end.p))
        {
            assert!(
                (x - y).abs() <= 1e-13 * (1.0 + y.abs()),
                "{what}: {x} for {y}"
            );
        }
    }
    let [error, ..] = errors;
    error
}
