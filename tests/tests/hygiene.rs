//! Expansions compile in every place where the attribute is allowed: without the prelude, under
//! denied lints, inside functions, and with user names that equal names in generated code.

use sve_runtime::prelude::*;

/// The prelude is not in scope, so that the expansion needs full paths.
mod without_prelude {
    #![no_implicit_prelude]
    #![allow(unreachable_pub)]

    pub struct Bare {
        pub m: f64,
    }

    #[::sve_runtime::variational(initial_point, endpoint, midpoint)]
    impl Bare {
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
            let mut kinetic = 0.0;
            for i in 0..2 {
                kinetic += 0.5 * self.m * (1.0 + q[0] * q[0]) * v[i] * v[i];
            }
            kinetic - q[0].cosh().ln() - q[1].powi(2)
        }

        #[gamma]
        fn push(&self, q: [f64; 2]) -> [f64; 2] {
            [q[0].sin(), q[1].cos() * q[0]]
        }

        #[h1]
        fn turn(&self, t: f64, q: [f64; 2], p: [f64; 2]) -> f64 {
            t.cos() * q[0] * p[1]
        }

        #[force]
        fn drag(&self, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
            [-v[0] * q[1].exp(), -v[1]]
        }
    }

    #[::sve_runtime::variational(taylor2)]
    impl Free {
        fn lagrangian(&self, q: f64, v: f64) -> f64 {
            0.5 * v * v - q * q * q * q
        }
    }

    pub struct Free;
}

/// All lints that can be denied are denied.
mod under_denied_lints {
    #![deny(warnings, missing_docs, unused, nonstandard_style)]
    #![deny(
        rust_2018_idioms,
        unused_qualifications,
        single_use_lifetimes,
        trivial_casts
    )]
    #![deny(
        trivial_numeric_casts,
        unused_results,
        unused_lifetimes,
        unreachable_pub
    )]
    #![deny(clippy::all, clippy::pedantic, clippy::nursery)]
    // contradicts `unreachable_pub`
    #![allow(clippy::redundant_pub_crate)]
    #![forbid(unsafe_code)]

    /// A system.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Strict {
        /// Mass.
        pub(super) mass: f64,
    }

    #[sve_runtime::variational(initial_point, endpoint, midpoint)]
    impl Strict {
        /// L.
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
            let [x, y] = q;
            self.mass.mul_add(v[0] * v[0], v[1] * v[1]) - (x * y).sin()
        }

        /// γ.
        #[gamma]
        fn push(&self, q: [f64; 2]) -> f64 {
            self.mass * q[0]
        }

        /// F.
        #[force]
        fn drag(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
            [-self.mass * v[0], 0.0]
        }
    }

    /// A system with neither parameters nor positions: most arguments are unused.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Empty;

    #[sve_runtime::variational(initial_point, endpoint, midpoint, taylor2)]
    impl Empty {
        /// L.
        const fn lagrangian(&self, _q: f64, v: f64) -> f64 {
            0.5 * v * v
        }

        /// ξ.
        #[symmetry]
        const fn shift(&self, _q: f64) -> f64 {
            1.0
        }
    }
}

/// Fields with the names of variables in generated code.
#[allow(non_snake_case)]
struct Names {
    q: f64,
    v: [f64; 2],
    p: f64,
    h: f64,
    t: f64,
    dw: [f64; 2],
    state: f64,
    newton: f64,
    prepared: f64,
    time: f64,
    sum_12: f64,
    product_3: f64,
    self_q: f64,
    value: f64,
    guess: f64,
    solution: f64,
    dq: f64,
    d_0: f64,
    v_0: f64,
    p0_0: f64,
    q0_0: f64,
    r#type: f64,
    S: f64,
}

impl Names {
    fn new() -> Self {
        Self {
            q: 0.1,
            v: [1.0, 1.2],
            p: 0.2,
            h: 0.3,
            t: 0.4,
            dw: [0.5, 0.6],
            state: 0.7,
            newton: 0.8,
            prepared: 0.9,
            time: 1.0,
            sum_12: 1.1,
            product_3: 1.2,
            self_q: 1.3,
            value: 1.4,
            guess: 1.5,
            solution: 1.6,
            dq: 1.7,
            d_0: 1.8,
            v_0: 1.9,
            p0_0: 2.0,
            q0_0: 2.1,
            r#type: 2.2,
            S: 2.3,
        }
    }
}

#[variational(initial_point, endpoint, midpoint)]
impl Names {
    fn lagrangian(&self, time: f64, state: [f64; 2], prepared: [f64; 2]) -> f64 {
        let h = self.q + self.p + self.h + self.t + self.state + self.newton + self.prepared;
        let dw = self.time + self.sum_12 + self.product_3 + self.self_q + self.value + self.guess;
        let newton = self.solution + self.dq + self.d_0 + self.v_0 + self.p0_0 + self.q0_0;
        let r#fn = self.r#type * self.S;
        self.v[0] * prepared[0] * prepared[0] + self.v[1] * prepared[1].powi(2)
            - h * (state[0] * dw).cos()
            - newton * state[0] * state[1] * time.sin()
            - r#fn * state[1].cosh()
    }

    #[gamma]
    fn r#loop(&self, self_q: [f64; 2]) -> [f64; 2] {
        [self.dw[0] * self_q[0].sin(), self.dw[1] * self_q[1]]
    }

    #[h1]
    fn sum_1(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.q * q[0] * p[1] - self.h * q[1] * p[0]
    }
}

#[test]
fn fields_with_generated_names() {
    let system = Names::new();
    let (q, v, t) = ([0.3, -0.4], [0.5, 0.7], 0.9);
    let jet = sve_runtime::system::System::lagrangian_jet(&system, t, &q, &v);
    assert!((jet.value - system.lagrangian(t, q, v)).abs() < 1e-13 * jet.value.abs());
    let jets = sve_runtime::system::System::noise_jets(&system, t, &q, &v);
    assert_eq!(jets[2].dp, [-system.h * q[1], system.q * q[0]]);
    assert_eq!(system.r#loop(q)[1], system.dw[1] * q[1]);
    assert_eq!(system.sum_1([1.0, 0.0], [0.0, 1.0]), system.q);

    let integrator = Integrator::new(Names::new(), Midpoint);
    let mut state = State::new(q, v);
    integrator.step(&mut state, 0.01, &[0.1, 0.1, 0.1]).unwrap();
}

#[test]
fn without_prelude_and_under_denied_lints() {
    let bare = Integrator::new(without_prelude::Bare { m: 1.0 }, Endpoint);
    let mut state = State::new([0.1, 0.2], [0.3, 0.4]);
    bare.step(&mut state, 0.01, &[0.0, 0.1, 0.1]).unwrap();
    let free = Integrator::new(without_prelude::Free, Taylor2);
    let mut state = State::new([0.1], [0.2]);
    free.step(&mut state, 0.01, &[]).unwrap();
    let strict = Integrator::new(under_denied_lints::Strict { mass: 1.0 }, InitialPoint);
    let mut state = State::new([0.1, 0.2], [0.3, 0.4]);
    strict.step(&mut state, 0.01, &[0.1]).unwrap();
    let empty = Integrator::new(under_denied_lints::Empty, Midpoint);
    let mut state = State::new([0.1], [0.2]);
    empty.step(&mut state, 0.5, &[]).unwrap();
    assert!((state.q[0] - 0.2).abs() < 1e-15);
}

#[test]
fn inside_a_function() {
    struct Local {
        k: f64,
    }

    #[variational(midpoint)]
    impl Local {
        fn lagrangian(&self, q: f64, v: f64) -> f64 {
            0.5 * v * v - self.k * q * q
        }
    }

    let local = Integrator::new(Local { k: 2.0 }, Midpoint);
    let mut state = State::new([1.0], [0.0]);
    local.step(&mut state, 0.01, &[]).unwrap();
}

/// Types of the standard library are shadowed by the user's.
mod shadowed_types {
    #![allow(dead_code, non_camel_case_types, unreachable_pub)]

    pub struct Option;
    pub struct Result;
    pub struct Some;
    pub struct Ok;
    pub struct Err;
    pub mod core {}
    pub mod std {}
    pub mod sve_runtime {}
    pub trait System {}
    pub trait Variational {}

    pub struct Shadowed;

    #[::sve_runtime::variational(initial_point, midpoint)]
    impl Shadowed {
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
            0.5 * (1.0 + q[1] * q[1]) * v[0] * v[0] + v[1] * v[1] - q[0].cos()
        }

        fn value(&self) -> f64 {
            1.0
        }
    }

    #[allow(clippy::unused_self)] // only the names matter
    impl Shadowed {
        /// Called like methods of the derived traits.
        pub fn prepare(&self) {}
        pub fn increment(&self) {}
        pub fn lagrangian_jet(&self) {}
    }
}

#[test]
fn beside_shadowed_types() {
    let shadowed = Integrator::new(shadowed_types::Shadowed, Midpoint);
    let mut state = State::new([0.1, 0.2], [0.3, 0.4]);
    shadowed.step(&mut state, 0.01, &[]).unwrap();
}

/// Systems with the names that generic parameters usually have.
mod single_letters {
    #![allow(non_snake_case, unreachable_pub)]

    macro_rules! systems {
        ($($name:ident)*) => {
            $(
                pub struct $name {
                    pub $name: f64,
                }

                #[sve_runtime::variational(midpoint, gauss(2))]
                impl $name {
                    const F: f64 = 0.5;

                    fn lagrangian(&self, q: f64, v: f64) -> f64 {
                        Self::F * (1.0 + q * q) * v * v - self.$name * self.T(q)
                    }

                    fn T(&self, q: f64) -> f64 {
                        q.powi(4)
                    }

                    #[gamma]
                    fn S(&self, q: f64) -> f64 {
                        0.1 * q
                    }
                }
            )*

            /// The states of all systems after the same steps.
            pub fn ends() -> Vec<[f64; 2]> {
                vec![$({
                    use sve_runtime::prelude::{Composed, Gauss, Integrator, KahanLi8, Midpoint, State};
                    let mut state = State::new([0.3], [0.5]);
                    let system = || $name { $name: 2.0 };
                    let gauss = Integrator::new(system(), Gauss::<2>);
                    gauss.step(&mut state, 0.01, &[0.1]).unwrap();
                    let tangent = gauss.tangent(&state, 0.01, &[0.1]).unwrap();
                    assert!((tangent.to_dmatrix().determinant() - 1.0).abs() < 1e-12);
                    let composed = Integrator::new(system(), Composed::new(Midpoint, KahanLi8));
                    composed.step(&mut state, 0.01, &[0.1]).unwrap();
                    [state.q[0], state.p[0]]
                }),*]
            }
        };
    }

    systems! { A B C D E F G H I J K L M N O P Q R S T U V W X Y Z }
}

#[test]
fn systems_of_one_letter() {
    let ends = single_letters::ends();
    assert_eq!(ends.len(), 26);
    assert!(ends.iter().all(|end| *end == ends[0]), "{ends:?}");
}

/// A system with lifetimes, and with helper functions that have names of generated code.
mod lifetimes {
    #![allow(unreachable_pub)]

    pub struct Borrowed<'a, 's> {
        pub name: &'a str,
        pub note: &'s str,
        pub k: f64,
    }

    #[sve_runtime::variational(initial_point, endpoint, midpoint, gauss(2))]
    impl Borrowed<'_, '_> {
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
            0.5 * (v[0] * v[0] + v[1] * v[1])
                - self.increment(self.rounding(q[0]), self.state(q[1]))
        }

        fn increment(&self, state: f64, newton: f64) -> f64 {
            self.k * state * newton
        }

        fn rounding(&self, fallback: f64) -> f64 {
            fallback.sin()
        }

        fn state(&self, memory: f64) -> f64 {
            memory.cos()
        }
    }
}

#[test]
fn a_system_with_lifetimes() {
    let (name, note) = (String::from("a"), String::from("b"));
    let system = lifetimes::Borrowed {
        name: &name,
        note: &note,
        k: 1.0,
    };
    assert_eq!([system.name, system.note], ["a", "b"]);
    let integrator = Integrator::new(system, Split::new(BlanesMoan4));
    let mut state = State::new([0.3, 0.1], [0.5, 0.0]);
    integrator.step(&mut state, 0.01, &[]).unwrap();
}
