//! Small numbers in the formulas: lengths as in SI units, weak couplings, frictions and fields. The
//! macro evaluates expressions at random points near 1, where functions of such lengths are
//! constant to the last digit, and elimination looks for numeric coefficients, by which it must not
//! divide. A step with the literal in the formulas is as accurate as that of the same system with a
//! parameter in its place.

use sve_models::checks::assert_close;
use sve_models::stepper::{Steppers, with_taylor2};
use sve_runtime::__private::{BlockSolver, Memory, StepEquations};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// A system of two coordinates with two parameters, whose small number is a literal in the type
/// `Written` and a parameter in the type `Given`.
macro_rules! pair {
    ($module:ident [$($rule:ident),*] $small:ident = $value:expr, $m:ident $q:ident $v:ident: $lagrangian:expr $(; $force:expr)?) => {
        mod $module {
            use sve_runtime::prelude::*;

            pub(super) struct Written {
                pub(super) m: [f64; 2],
            }

            #[variational($($rule),*)]
            impl Written {
                fn lagrangian(&self, $q: [f64; 2], $v: [f64; 2]) -> f64 {
                    let ($m, $small) = (self.m, $value);
                    $lagrangian
                }

                $(#[force]
                fn friction(&self, _q: [f64; 2], $v: [f64; 2]) -> [f64; 2] {
                    let $small = $value;
                    $force
                })?
            }

            pub(super) struct Given {
                pub(super) m: [f64; 2],
                pub(super) small: f64,
            }

            #[variational($($rule),*)]
            impl Given {
                fn lagrangian(&self, $q: [f64; 2], $v: [f64; 2]) -> f64 {
                    let ($m, $small) = (self.m, self.small);
                    $lagrangian
                }

                $(#[force]
                fn friction(&self, _q: [f64; 2], $v: [f64; 2]) -> [f64; 2] {
                    let $small = self.small;
                    $force
                })?
            }
        }
    };
}

pair! { trap [initial_point, endpoint, midpoint, taylor2] w = 1e-6, m q v:
0.5 * m[0] * (v[0] * v[0] + v[1] * v[1])
    + m[1] * ((-(q[0] / w).powi(2)).exp() + (q[1] / w).tanh() - (q[0] / w).exp().ln_1p()) }

pair! { coupling [initial_point, endpoint, midpoint, taylor2] small = 1e-6, m q v:
0.5 * (m[0] * v[0] * v[0] + m[1] * v[1] * v[1]) + small * v[0] * v[1]
    - 0.25 * q[0].powi(4) - q[1].cosh() }

pair! { friction [taylor2] small = 1e-6, m q v:
0.5 * m[0] * (v[0] * v[0] + v[1] * v[1]) + small * (q[0] * v[1] - q[1] * v[0])
    - 0.25 * q[0].powi(4) - q[1].cosh();
[-small * v[0], -small * v[1]] }

pair! { weak_field [initial_point, endpoint, midpoint, taylor2] b = 1e-9, _m q v:
0.5 * (v[0] * v[0] + v[1] * v[1]) - (1.0 + q[0] * q[0] + q[1] * q[1]).ln()
    + b * (q[0] * v[1] - q[1] * v[0]) }

pair! { weak_landau [initial_point, endpoint, midpoint, taylor2] b = 1e-9, _m q v:
0.5 * (v[0] * v[0] + v[1] * v[1]) - (1.0 + q[0] * q[0] + q[1] * q[1]).ln() + b * (q[0] * v[1]) }

pair! { strong_landau [initial_point, endpoint, midpoint, taylor2] b = 1.0, _m q v:
0.5 * (v[0] * v[0] + v[1] * v[1]) - (1.0 + q[0] * q[0] + q[1] * q[1]).ln() + b * (q[0] * v[1]) }

/// Compares steps of both systems by each rule.
fn compare(
    [written, given]: [Steppers<'_, [f64; 2], 0>; 2],
    start: State<[f64; 2]>,
    sizes: [f64; 3],
    [of_q, of_p]: [f64; 2],
) {
    for (written, given) in written.iter().zip(&given) {
        for h in sizes {
            let row = format!("{}, h = {h}", written.name());
            let [a, b] = [written, given].map(|rule| rule.after(start, h, &[], 1));
            assert_close(&a.q, &b.q, of_q, &row);
            assert_close(&a.p, &b.p, of_p, &row);
        }
    }
}

#[test]
fn a_trap_and_a_wall_of_a_micrometre() {
    let (m, small) = ([1e-18, 1e-20], 1e-6);
    let (written, given) = (trap::Written { m }, trap::Given { m, small });
    let start = State::new([0.5e-6, -0.2e-6], [1e-19, 0.5e-19]);
    let rules = [with_taylor2(&written), with_taylor2(&given)];
    compare(
        rules,
        start,
        [1e-7, 1e-6, 1e-5],
        [1e-14 * 1e-6, 1e-14 * 1e-19],
    );
}

#[test]
fn weak_couplings_and_frictions() {
    let (m, small) = ([1.3, 0.7], 1e-6);
    let start = State::new([0.7, 0.3], [0.5, -0.4]);
    let (sizes, bounds) = ([0.1, 0.03, 1e-3], [8.0 * f64::EPSILON; 2]);
    let (written, given) = (coupling::Written { m }, coupling::Given { m, small });
    let rules = [with_taylor2(&written), with_taylor2(&given)];
    compare(rules, start, sizes, bounds);
    let written = Integrator::new(friction::Written { m }, Taylor2);
    let given = Integrator::new(friction::Given { m, small }, Taylor2);
    let rules: [Steppers<'_, _, 0>; 2] = [vec![Box::new(written)], vec![Box::new(given)]];
    compare(rules, start, sizes, bounds);
}

/// Returns the increments of position and momentum, from a state whose numbers are far larger than
/// the increments.
fn increment<S, R>(system: &S, _rule: R, h: f64) -> [f64; 4]
where
    S: StepEquations<R, Increments = [f64; 0]> + System<Dims = Dims<2, 0>>,
{
    let start = State::new([0.0, 0.0], [1.0, 1000.0]);
    let (prepared, newton) = (system.prepare(h), Newton::default());
    let (memory, solver) = (&mut S::Memory::none(), BlockSolver::new(&newton));
    let increment = system.increment(&prepared, memory, &start, h, &[], &solver);
    let ([dx, dy], [dp, dr], _) = increment.unwrap();
    [dx, dy, dp, dr]
}

/// Compares increments, which a step computes and adds, in whatever form the Lagrangian is written.
fn compare_increments<A, B, R: Copy>(literal: &A, parameter: &B, rule: R)
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
            assert!(error < 20.0 * f64::EPSILON, "h = {h:e}: {a:?} for {b:?}");
        }
        let explicit = h * 1000.0;
        assert!((a[1] / explicit - 1.0).abs() < 2.0 * h.max(1e-8), "{a:?}");
    }
}

#[test]
fn increments_of_small_steps_keep_their_digits() {
    macro_rules! check {
        ($($module:ident $small:expr, [$($rule:ident)*];)*) => {$($(
            let (m, small) = ([1.0; 2], $small);
            compare_increments(&$module::Written { m }, &$module::Given { m, small }, $rule);
        )*)*};
    }
    check! {
        weak_field 1e-9, [InitialPoint Endpoint Midpoint Taylor2];
        weak_landau 1e-9, [InitialPoint Endpoint Midpoint Taylor2];
        strong_landau 1.0, [InitialPoint Endpoint Midpoint Taylor2];
    }
}
