//! One block as a scene and as an unrolled system, and what is compared.

use sve_runtime::nalgebra::SVector;
use sve_runtime::prelude::*;

/// Defines a system twice from one body, as `scene::System` and as `unrolled::System`. `explicit`
/// leaves the midpoint rule out.
///
/// | written | function |
/// | --- | --- |
/// | `each bath(&self, q) -> f64 \|i\| { … }` | returns an entry for each site |
/// | `each … where { let … } \|i\| { … }` | begins with statements |
/// | `fn total(&self, q, v; t) -> f64 { … }` | has one body; its first argument is the time `t` |
/// | `{ fn … } or { fn … }` | has a body for each system |
///
/// The functions of the first rows have a role, and return a `Vec` or an array. The unrolled system
/// has those with one body first, since their processes come first in scenes.
macro_rules! both {
    (explicit $($block:tt)*) => {
        both! { @rules (initial_point, endpoint, stormer_verlet) $($block)* }
    };
    (struct $($block:tt)*) => {
        both! { @rules (initial_point, endpoint, midpoint, stormer_verlet) struct $($block)* }
    };
    (
        @rules $rules:tt
        struct $fields:tt
        [$($row:tt)*] $n:tt
        |$this:ident, $q:ident, $v:ident| $body:tt
        $($functions:tt)*
    ) => {
        both! {
            @sites [$($row)*] [$($row)*; $n] $n
            @systems $rules $fields
            [pub(crate) fn lagrangian(&$this, $q: &[$($row)*], $v: &[$($row)*]) -> f64 $body]
            [pub(crate) fn lagrangian(&$this, $q: [$($row)*; $n], $v: [$($row)*; $n]) -> f64 $body]
            []
            $($functions)*
        }
    };
    (
        @sites $slice:tt $array:tt $n:tt
        @systems $rules:tt $fields:tt [$($scene:tt)*] [$($whole:tt)*] [$($each:tt)*]
        #[$($role:tt)*]
        each $name:ident(&$this:ident, $q:ident $(, $v:ident)? $(; $t:ident)?) -> $of:ty
            $(where { $($before:tt)* })? |$i:ident| $body:tt
        $($functions:tt)*
    ) => {
        both! {
            @sites $slice $array $n
            @systems $rules $fields
            [
                $($scene)*
                #[$($role)*]
                pub(crate) fn $name(&$this, $($t: f64,)? $q: &$slice $(, $v: &$slice)?) -> Vec<$of> {
                    $($($before)*)?
                    (0..$q.len()).map(|$i| $body).collect()
                }
            ]
            [$($whole)*]
            [
                $($each)*
                #[$($role)*]
                pub(crate) fn $name(&$this, $($t: f64,)? $q: $array $(, $v: $array)?) -> [$of; $n] {
                    $($($before)*)?
                    std::array::from_fn::<_, $n, _>(|$i| $body)
                }
            ]
            $($functions)*
        }
    };
    (
        @sites $slice:tt $array:tt $n:tt
        @systems $rules:tt $fields:tt [$($scene:tt)*] [$($whole:tt)*] $each:tt
        #[$($role:tt)*]
        fn $name:ident(&$this:ident, $q:ident $(, $v:ident)? $(; $t:ident)?) -> $of:ty { $($body:tt)* }
        $($functions:tt)*
    ) => {
        both! {
            @sites $slice $array $n
            @systems $rules $fields
            [
                $($scene)*
                #[$($role)*]
                pub(crate) fn $name(&$this, $($t: f64,)? $q: &$slice $(, $v: &$slice)?) -> $of { $($body)* }
            ]
            [
                $($whole)*
                #[$($role)*]
                pub(crate) fn $name(&$this, $($t: f64,)? $q: $array $(, $v: $array)?) -> $of { $($body)* }
            ]
            $each
            $($functions)*
        }
    };
    (
        @sites $slice:tt $array:tt $n:tt
        @systems $rules:tt $fields:tt [$($scene:tt)*] $whole:tt [$($each:tt)*]
        { $($of_scene:tt)* } or { $($unrolled:tt)* }
        $($functions:tt)*
    ) => {
        both! {
            @sites $slice $array $n
            @systems $rules $fields [$($scene)* $($of_scene)*] $whole [$($each)* $($unrolled)*]
            $($functions)*
        }
    };
    (
        @sites $slice:tt $array:tt $n:tt
        @systems $rules:tt { $($field:ident: $ty:ty),* $(,)? }
        [$($scene:tt)*] [$($whole:tt)*] [$($each:tt)*]
    ) => {
        pub(crate) mod scene {
            use super::*;

            #[derive(Clone, Debug)]
            pub(crate) struct System { $(pub(crate) $field: $ty),* }

            #[variational $rules]
            impl System { $($scene)* }
        }
        #[allow(unused_variables)] // sites, where an entry is the same for each
        pub(crate) mod unrolled {
            #[allow(unused_imports)] // types of some systems
            use super::*;

            #[derive(Clone, Debug)]
            pub(crate) struct System { $(pub(crate) $field: $ty),* }

            #[sve_comparison::stepped $rules]
            impl System { $($whole)* $($each)* }
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
