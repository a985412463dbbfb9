//! Small steps keep their digits: a step computes the increment of the state, in whatever form the Lagrangian is written.

use sve_runtime::prelude::*;
use sve_runtime::{BlockSolver, Dims, Memory, StepEquations, System};

/// The same weak magnetic field, its strength a literal of L in one system and a parameter in the other: a literal is a
/// numeric coefficient, which elimination looks for.
macro_rules! charges {
    ($($module:ident, $q:ident, $v:ident, $lagrangian:expr, $strength:expr;)*) => {$(
        mod $module {
            use sve_runtime::prelude::*;
            #[derive(Debug)]
            pub(super) struct Literal;
            #[variational(initial_point, endpoint, midpoint, taylor2)]
            impl Literal {
                const B: f64 = $strength;
                fn lagrangian(&self, $q: [f64; 2], $v: [f64; 2]) -> f64 {
                    let field = Self::B;
                    0.5 * ($v[0] * $v[0] + $v[1] * $v[1]) - (1.0 + $q[0] * $q[0] + $q[1] * $q[1]).ln()
                        + field * $lagrangian
                }
            }
            #[derive(Debug)]
            pub(super) struct Parameter { pub(super) b: f64 }
            #[variational(initial_point, endpoint, midpoint, taylor2)]
            impl Parameter {
                fn lagrangian(&self, $q: [f64; 2], $v: [f64; 2]) -> f64 {
                    0.5 * ($v[0] * $v[0] + $v[1] * $v[1]) - (1.0 + $q[0] * $q[0] + $q[1] * $q[1]).ln()
                        + self.b * $lagrangian
                }
            }
        }
    )*};
}

charges! {
    symmetric_weak, q, v, (q[0] * v[1] - q[1] * v[0]), 1e-9;
    landau_weak, q, v, (q[0] * v[1]), 1e-9;
    landau_strong, q, v, (q[0] * v[1]), 1.0;
}

/// Returns the increments of position and momentum, from a state whose numbers are far larger than the increments.
fn increment<S, R>(system: &S, _rule: R, h: f64) -> [f64; 4]
where
    S: StepEquations<R, Increments = [f64; 0]> + System<Dims = Dims<2, 0>>,
{
    let start = State::new([0.0, 0.0], [1.0, 1000.0]);
    let prepared = system.prepare(h);
    let newton = Newton::default();
    let (dq, dp, _) = system
        .increment(
            &prepared,
            &mut S::Memory::none(),
            &start,
            h,
            &[],
            &BlockSolver::new(&newton),
        )
        .unwrap();
    [dq[0], dq[1], dp[0], dp[1]]
}

fn check<A, B, R: Copy>(literal: &A, parameter: &B, rule: R)
where
    A: StepEquations<R, Increments = [f64; 0]> + System<Dims = Dims<2, 0>>,
    B: StepEquations<R, Increments = [f64; 0]> + System<Dims = Dims<2, 0>>,
{
    // the longest crosses a tenth of the well: beyond, the fast path leaves steps to continuation
    for h in [1e-9, 1e-5, 1e-4] {
        let (a, b) = (increment(literal, rule, h), increment(parameter, rule, h));
        for i in 0..2 {
            // a few roundings of each displacement, not of the state
            let error = (a[i] - b[i]).abs() / b[i].abs();
            assert!(
                error < 20.0 * f64::EPSILON,
                "h = {h:e}: {a:?} against {b:?}"
            );
        }
        let explicit = [h * (1.0 - 0.0), h * 1000.0];
        assert!(
            (a[1] / explicit[1] - 1.0).abs() < 2.0 * h.max(1e-8),
            "{a:?}"
        );
    }
}

macro_rules! all_rules {
    ($module:ident, $b:expr) => {
        let (literal, parameter) = (&$module::Literal, &$module::Parameter { b: $b });
        check(literal, parameter, InitialPoint);
        check(literal, parameter, Endpoint);
        check(literal, parameter, Midpoint);
        check(literal, parameter, Taylor2);
    };
}

#[test]
fn a_literal_coefficient_is_no_worse_than_a_parameter() {
    all_rules!(symmetric_weak, 1e-9);
    all_rules!(landau_weak, 1e-9);
    all_rules!(landau_strong, 1.0);
}
