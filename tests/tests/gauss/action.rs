//! The step against the equations that the symbolic pipeline derives from the rule's unrolled
//! action, solved by Newton's method without any structure.

use sve_models::checks::assert_relative;
use sve_models::random::Random;
use sve_runtime::__private::Unstructured;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::systems::{everything, wells};

/// Compares steps, tangent maps and sensitivities at random states.
fn check<S, R, const M: usize>(system: &S, rule: R)
where
    R: Copy,
    S: Variational<R> + Variational<Unstructured<R>> + System<Dims = Dims<2, M>>,
{
    let step = Integrator::new(system, rule);
    let unrolled = Integrator::new(system, Unstructured(rule));
    let mut random = Random::new(5);
    for _ in 0..40 {
        let start = State::at(
            random.uniform(0.0, 1.0),
            random.array(-0.5, 0.5),
            random.array(-0.5, 0.5),
        );
        let dw = random.array(-0.3, 0.3);
        let (found, expected) = (numbers(&step, &start, &dw), numbers(&unrolled, &start, &dw));
        assert_relative(&found, &expected, 2e-14, "with derivatives");
        assert_relative(&found[..4], &expected[..4], 2e-15, "the state itself");
    }
}

/// The state after a step, its tangent map, and its sensitivities.
fn numbers<S, R, const M: usize>(
    integrator: &Integrator<&S, R>,
    start: &State<[f64; 2]>,
    dw: &[f64; M],
) -> Vec<f64>
where
    S: Variational<R> + System<Dims = Dims<2, M>>,
{
    let mut state = *start;
    let derivatives = integrator.step_with_derivatives(&mut state, 0.15, dw);
    let (tangent, sensitivity) = derivatives.unwrap();
    let mut numbers = [state.q, state.p].concat();
    numbers.extend((0..4).flat_map(|row| tangent[row].to_vec()));
    for (_, field) in sensitivity.iter() {
        numbers.extend(field.q);
        numbers.extend(field.p);
    }
    numbers
}

#[test]
fn newton_solves_the_equations_of_the_unrolled_action() {
    check(&everything(), Gauss::<2>);
}

#[test]
fn partitioned_fixed_points_solve_the_equations_of_the_unrolled_action() {
    check(&everything(), Gauss::<4>);
}

#[test]
fn fixed_points_of_second_order_solve_the_equations_of_the_unrolled_action() {
    check(&wells(), Gauss::<4>);
}
