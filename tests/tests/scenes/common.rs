//! One block as a scene and as an unrolled system, and what is compared.

use sve_runtime::nalgebra::SVector;
use sve_runtime::prelude::*;

/// Defines a system twice from one body, as `scene::System` and as `unrolled::System`. The second
/// γ, force and generator of each pair are those of the unrolled system. `explicit` leaves the
/// midpoint rule out.
macro_rules! both {
    (explicit $($block:tt)*) => {
        both! { @rules (initial_point, endpoint, stormer_verlet) $($block)* }
    };
    (struct $($block:tt)*) => {
        both! { @rules (initial_point, endpoint, midpoint, stormer_verlet) struct $($block)* }
    };
    (
        @rules $rules:tt
        struct { $($field:ident: $ty:ty),* $(,)? }
        [$($row:tt)*] $n:tt
        |$this:ident, $q:ident, $v:ident| { $($body:tt)* }
        $(gamma { $($scene:tt)* } or { $($unrolled:tt)* })?
        $(force { $($scene_force:tt)* } or { $($unrolled_force:tt)* })?
        $(symmetry { $($scene_symmetry:tt)* } or { $($unrolled_symmetry:tt)* })*
    ) => {
        pub(crate) mod scene {
            use super::*;

            #[derive(Clone, Debug)]
            pub(crate) struct System { $(pub(crate) $field: $ty),* }

            #[variational $rules]
            impl System {
                pub(crate) fn lagrangian(&$this, $q: &[$($row)*], $v: &[$($row)*]) -> f64 { $($body)* }
                $(#[gamma] $($scene)*)?
                $(#[force] $($scene_force)*)?
                $(#[symmetry] pub(crate) $($scene_symmetry)*)*
            }
        }
        pub(crate) mod unrolled {
            #[allow(unused_imports)] // types of some systems
            use super::*;

            #[derive(Clone, Debug)]
            pub(crate) struct System { $(pub(crate) $field: $ty),* }

            #[sve_comparison::stepped $rules]
            impl System {
                pub(crate) fn lagrangian(&$this, $q: [$($row)*; $n], $v: [$($row)*; $n]) -> f64 { $($body)* }
                $(#[gamma] $($unrolled)*)?
                $(#[force] $($unrolled_force)*)?
                $(#[symmetry] pub(crate) $($unrolled_symmetry)*)*
            }
        }
    };
}

/// Compares both systems of [`both`] with these fields, for all rules; `explicit` for systems
/// without the midpoint rule. Compositions are lists of the same substeps for all scenes, so
/// `compositions` compares them for some.
macro_rules! compare {
    (explicit $($given:tt)*) => {
        compare!(@of [InitialPoint, Endpoint, StormerVerlet] $($given)*)
    };
    (compositions $($given:tt)*) => {
        compare!(@of [
            Composed::new(StormerVerlet, KahanLi8), Split::new(BlanesMoan4),
            Split::new(BlanesMoanRkn6), Composed::new(Midpoint, KahanLi8)
        ] $($given)*)
    };
    (@of [$($rule:expr),*] $module:ident { $($field:ident: $value:expr),* $(,)? }, $q:expr, $p:expr, $dw:expr) => {{
        let scene = $module::scene::System { $($field: $value),* };
        let unrolled = $module::unrolled::System { $($field: $value),* };
        let (q, p, dw) = ($q, $p, $dw);
        compare!(@each scene, unrolled, q, p, dw, $($rule),*);
    }};
    (@each $scene:ident, $unrolled:ident, $q:ident, $p:ident, $dw:ident, $($rule:expr),*) => {$(
        let mut state = State::at(0.3, $q.to_vec(), $p.to_vec());
        Integrator::new(&$scene, $rule).step(&mut state, 0.05, &$dw).expect("a step of the scene");
        let mut expected = State::at(0.3, $q, $p);
        Integrator::new(&$unrolled, $rule).step(&mut expected, 0.05, &$dw).expect("an unrolled step");
        $crate::common::assert_same(&state, &expected.q, &expected.p, stringify!($rule));
        assert_eq!(state.t, expected.t);
    )*};
    ($($given:tt)*) => {
        compare!(@of [InitialPoint, Endpoint, Midpoint, StormerVerlet] $($given)*)
    };
}

/// A site as its numbers.
pub(crate) trait Numbers: Copy {
    fn numbers(self) -> Vec<f64>;
}

impl Numbers for f64 {
    fn numbers(self) -> Vec<f64> {
        vec![self]
    }
}

impl<const D: usize> Numbers for [f64; D] {
    fn numbers(self) -> Vec<f64> {
        self.to_vec()
    }
}

impl<const D: usize> Numbers for SVector<f64, D> {
    fn numbers(self) -> Vec<f64> {
        self.as_slice().to_vec()
    }
}

/// The numbers of sites.
pub(crate) fn numbers<Q: Numbers>(sites: &[Q]) -> Vec<f64> {
    sites.iter().flat_map(|site| site.numbers()).collect()
}

/// Checks that a state is another one to 1e-14 of the largest coordinate.
pub(crate) fn assert_same<Q: Numbers>(state: &State<Vec<Q>>, q: &[Q], p: &[Q], what: &str)
where
    Vec<Q>: sve_runtime::Configuration<Momentum = Vec<Q>>,
{
    let found = [numbers(&state.q), numbers(&state.p)].concat();
    let expected = [numbers(q), numbers(p)].concat();
    let size = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for (at, (x, y)) in found.iter().zip(&expected).enumerate() {
        assert!((x - y).abs() <= 1e-14 * size, "{what} {at}: {x} {y}");
    }
    assert_eq!(found.len(), expected.len());
}

/// Returns different numbers between −1 and 1.
pub(crate) fn spread(n: usize, seed: u64) -> Vec<f64> {
    let mut x = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let next = |_| {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(next).collect()
}

/// The impulses `h ∂L/∂q + Σ ΔW ∂γ/∂q` at a configuration: the momenta after a step of the endpoint
/// rule from rest, in which nothing moves.
macro_rules! impulses {
    ($system:expr, $q:expr, $zero:expr, $h:expr, $dw:expr) => {{
        let q = $q.to_vec();
        let mut state = State::new(q.clone(), vec![$zero; q.len()]);
        let integrator = Integrator::new($system, Endpoint);
        integrator.step(&mut state, $h, $dw).expect("a step");
        assert_eq!(state.q, q);
        state.p
    }};
}
