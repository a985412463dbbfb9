//! Comparison of a derived Lagrangian with the user's own function: values, and derivatives by
//! differences.

use sve_runtime::__private::VectorCoordinates;
use sve_runtime::system::{Dims, System};

use crate::functions::{Lagrangian, array, lagrangian};
use crate::random::Random;

/// Number of random points at which a feature is tried.
const POINTS: usize = 24;

/// L as a function of (t, q, v).
type Plain<'a> = &'a dyn Fn(f64, &[f64], &[f64]) -> f64;

/// The derivatives of L as a function of (t, q, v).
type Derived<'a> = &'a dyn Fn(f64, &[f64], &[f64]) -> Lagrangian;

/// Compares `L`, `∂L/∂q`, `∂L/∂v` and the second derivatives at random points; `plain` is the
/// user's function.
///
/// # Panics
/// If they differ.
pub fn check<S, Q, const N: usize, const M: usize>(
    system: &S,
    plain: impl Fn(f64, &[f64; N], &[f64; N]) -> f64,
) where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let derived = |t: f64, q: &[f64], v: &[f64]| lagrangian::<S, Q, N, M>(system, t, q, v);
    let plain = |t: f64, q: &[f64], v: &[f64]| plain(t, &array(q), &array(v));
    // The functions are passed by pointer, so that the code is compiled once for all systems.
    check_all(N, &derived, &plain);
}

fn check_all(n: usize, derived: Derived<'_>, plain: Plain<'_>) {
    let mut random = Random::new(1);
    for _ in 0..POINTS {
        let (q, v) = (random.vector(n, 0.1, 0.9), random.vector(n, 0.1, 0.9));
        check_at(derived, plain, random.uniform(0.1, 0.9), &q, &v);
    }
}

fn check_at(derived: Derived<'_>, plain: Plain<'_>, t: f64, q: &[f64], v: &[f64]) {
    let jet = derived(t, q, v);
    close("L", jet.value, plain(t, q, v), 1e-13);
    for i in 0..q.len() {
        let along_q = |x: f64| plain(t, &with(q, i, x), v);
        let along_v = |x: f64| plain(t, q, &with(v, i, x));
        close("dL/dq", jet.dq[i], slope(&along_q, q[i]), 1e-7);
        close("dL/dv", jet.dv[i], slope(&along_v, v[i]), 1e-7);
        for j in 0..q.len() {
            let along_q = |x: f64| derived(t, &with(q, j, x), v);
            let along_v = |x: f64| derived(t, q, &with(v, j, x));
            let second = [
                ("dqq", jet.dqq[i][j], slope(&|x| along_q(x).dq[i], q[j])),
                ("dqv", jet.dqv[i][j], slope(&|x| along_v(x).dq[i], v[j])),
                ("dvv", jet.dvv[i][j], slope(&|x| along_v(x).dv[i], v[j])),
            ];
            for (what, derived, expected) in second {
                close(what, derived, expected, 1e-6);
            }
        }
        let in_time = |x: f64| derived(x, q, v);
        close("dqt", jet.dqt[i], slope(&|x| in_time(x).dq[i], t), 1e-6);
        close("dvt", jet.dvt[i], slope(&|x| in_time(x).dv[i], t), 1e-6);
    }
}

/// Returns `vector` with `x` as entry `i`.
pub fn with(vector: &[f64], i: usize, x: f64) -> Vec<f64> {
    let mut vector = vector.to_vec();
    vector[i] = x;
    vector
}

/// Returns the derivative by central differences of sixth order.
pub fn slope(f: &dyn Fn(f64) -> f64, x: f64) -> f64 {
    let h = 1e-3;
    let odd = |k: f64| f(x + k * h) - f(x - k * h);
    (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h)
}

/// Asserts that two numbers agree.
///
/// # Panics
/// If they do not agree.
pub fn close(what: &str, derived: f64, expected: f64, tolerance: f64) {
    assert!(
        (derived - expected).abs() <= tolerance * (1.0 + expected.abs()),
        "{what}: derived {derived}, expected {expected}"
    );
}

/// Declares a system with fields and a block, and tests it against its own `lagrangian`.
#[macro_export]
macro_rules! feature {
    ($(#[$doc:meta])* $test:ident, $name:ident { $($field:ident: $ty:ty = $value:expr),* $(,)? }, $($members:tt)*) => {
        #[derive(Debug)]
        struct $name { $($field: $ty),* }

        #[sve_runtime::variational(midpoint)]
        impl $name { $($members)* }

        $(#[$doc])*
        #[test]
        fn $test() {
            let system = $name { $($field: $value),* };
            $crate::language::check(&system, |_, q, v| system.lagrangian(*q, *v));
        }
    };
}
