//! The step against the equations that the symbolic pipeline derives from the rule's unrolled action, without any structure.

use sve_models::random::Random;
use sve_runtime::__private::Unstructured;
use sve_runtime::Variational;
use sve_runtime::prelude::*;

use crate::systems::{Everything, everything};

/// Compares steps, tangent maps and sensitivities at random states.
fn check<R>(rule: R)
where
    R: Copy,
    Everything: Variational<R> + Variational<Unstructured<R>>,
{
    let system = everything();
    let [step, unrolled] = [
        &Integrator::new(&system, rule) as &dyn Stepped,
        &Integrator::new(&system, Unstructured(rule)),
    ];
    let mut random = Random::new(5);
    for _ in 0..40 {
        let start = State::at(
            random.uniform(0.0, 1.0),
            random.array(-0.5, 0.5),
            random.array(-0.5, 0.5),
        );
        let dw = random.array(-0.3, 0.3);
        let [state, expected] = [step, unrolled].map(|s| s.numbers(&start, &dw));
        for (x, y) in state.iter().zip(&expected) {
            assert!((x - y).abs() < 2e-14 * (1.0 + y.abs()), "{x} for {y}");
        }
        assert_eq!(state.len(), expected.len());
    }
}

/// A step of either form.
trait Stepped {
    /// The state after a step, its tangent map, and its sensitivities.
    fn numbers(&self, start: &State<[f64; 2]>, dw: &[f64; 2]) -> Vec<f64>;
}

impl<R> Stepped for Integrator<&Everything, R>
where
    Everything: Variational<R>,
{
    fn numbers(&self, start: &State<[f64; 2]>, dw: &[f64; 2]) -> Vec<f64> {
        let mut state = *start;
        let (tangent, sensitivity) = self.step_with_derivatives(&mut state, 0.15, dw).unwrap();
        let mut numbers = [state.q, state.p].concat();
        numbers.extend((0..4).flat_map(|row| tangent[row].to_vec()));
        for (_, field) in sensitivity.iter() {
            numbers.extend(field.q);
            numbers.extend(field.p);
        }
        numbers
    }
}

#[test]
fn steps_are_those_of_the_unrolled_action() {
    check(Gauss::<2>);
    check(Gauss::<4>);
}
