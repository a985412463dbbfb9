//! Derived steps against steps without structure: the results are the same, and the operations of
//! both are counted. A term in the Lagrangian adds its own operations and no others.

#[path = "../../../examples/examples/structure/scenes.rs"]
mod scenes;

/// The step without structure has the same result.
mod unstructured {
    use sve_models::case::Case;
    use sve_models::oracle::{Nodes, cases};
    use sve_models::random::Random;
    use sve_runtime::plan::BlockKind;

    const H: f64 = 0.05;

    /// Both are solved to a few units of rounding of the terms of their equations, which the
    /// Jacobians of the models pass on: up to 4.3 units of the state here.
    const UNITS: f64 = 20.0;

    fn same_without_structure(case: &dyn Case, random: &mut Random) {
        let what = case.name();
        let plan = case.plan_without_structure();
        let [block] = plan.blocks else {
            panic!("{what}: {plan}");
        };
        let (n, m) = case.dimensions();
        let each = if case.nodes() == Nodes::Predicted {
            5
        } else {
            3
        };
        assert_eq!(block.unknowns.len(), each * n, "{what}");
        assert_eq!(
            (block.kind, block.band),
            (BlockKind::Newton, None),
            "{what}"
        );
        for _ in 0..20 {
            let start = case.model().point(random);
            let dw = random.vector(m, -0.1, 0.1);
            let expected = case.stepped(&start, H, &dw);
            let mut got = start;
            case.step_without_structure(&mut got, H, &dw)
                .unwrap_or_else(|e| panic!("{what}: {e}"));
            for (a, b) in expected.entries().zip(got.entries()) {
                let error = (a - b).abs() / (f64::EPSILON * expected.size());
                assert!(error <= UNITS, "{what}: {expected:?}, {got:?}");
            }
            assert_eq!(got.t, expected.t);
        }
    }

    #[test]
    fn every_step_is_the_same_without_structure() {
        let (mut random, cases) = (Random::new(31), cases());
        for case in &cases {
            same_without_structure(&**case, &mut random);
        }
        assert_eq!(cases.len(), 117);
    }
}

/// The table of `examples/structure`, as far as it is the same on every machine.
mod table {
    use super::scenes::{Facts, Scene, Visitor, every_scene};
    use sve_runtime::__private::Unstructured;
    use sve_runtime::__private::VectorCoordinates;
    use sve_runtime::Variational;
    use sve_runtime::prelude::*;
    use sve_runtime::system::{Dims, System};

    /// Scene and rule; then without structure and with it: blocks, operations, calls, additions,
    /// bytes beside the state.
    const TABLE: &str = "\
pendulum, endpoint | Newton 3; 33 + 41 n; 1; 0; 104 | explicit; 4; 1; 0; 16
pendulum, midpoint | Newton 3; 40 + 51 n; 2 + 1 n; 0; 104 | Newton 1; 5 + 13 n; 1; 1 n; 48
pendulum, taylor2 | Newton 5; 141 + 182 n; 3 + 2 n; 0; 248 | Newton 1; 22 + 25 n; 1; 1 + 1 n; 64
linear oscillator, endpoint | Newton 3; 33 + 41 n; 0; 0; 104 | explicit; 5; 0; 0; 8
linear oscillator, midpoint | Newton 3; 41 + 54 n; 0; 0; 104 | linear 1; 12; 0; 0; 48
Kubo, midpoint | Newton 3; 45 + 60 n; 0; 0; 104 | linear 1; 26; 0; 0; 48
synchrotron, endpoint | Newton 3; 38 + 41 n; 1; 0; 104 | explicit; 8; 1; 0; 16
synchrotron, midpoint | Newton 3; 55 + 63 n; 2 + 1 n; 0; 104 | Newton 1; 30 + 23 n; 1; 1 n; 104
Langevin, midpoint | Newton 3; 63 + 68 n; 2 + 1 n; 0; 104 | Newton 1; 50 + 20 n; 0; 0; 144
double pendulum, midpoint | Newton 6; 262 + 305 n; 5 + 3 n; 0; 344 | Newton 2; 138 + 98 n; 2; 1 + 2 n; 232
Kepler, midpoint | Newton 12; 1433 + 1472 n; 2 + 1 n; 0; 1256 | Newton 4; 176 + 129 n; 1 + 1 n; 0; 448
chain of 12, endpoint | Newton 36; 33100 + 33163 n; 0; 0; 10664 | explicit; 106; 0; 0; 16
chain of 12, midpoint | Newton 36; 33299 + 33410 n; 0; 0; 10664 | Newton 12 banded; 188 + 411 n; 0; 0; 432";

    #[derive(Default)]
    struct Rows(Vec<String>);

    impl Visitor for Rows {
        fn visit<S, R, Q, const N: usize, const M: usize>(&mut self, scene: &Scene<S, R>)
        where
            S: System<Dims = Dims<N, M, Q>> + Variational<R> + Variational<Unstructured<R>> + Copy,
            Q: VectorCoordinates<N>,
            R: Copy,
        {
            let words = |facts: Facts| {
                let Facts {
                    blocks,
                    operations,
                    calls,
                    additions,
                    state,
                    beside,
                } = facts;
                assert_eq!(state, 8 * (2 * N + 1));
                format!("{blocks}; {operations}; {calls}; {additions}; {beside}")
            };
            let rule = scene.derived.plan().rule;
            let without = words(Facts::of::<S, Unstructured<R>>());
            let with = words(Facts::of::<S, R>());
            self.0
                .push(format!("{}, {rule} | {without} | {with}", scene.name));
            same_path(scene);
        }
    }

    /// Both sides of the table go the same way: errors of rounding, which the motion makes grow.
    fn same_path<S, R, Q, const N: usize, const M: usize>(scene: &Scene<S, R>)
    where
        S: System<Dims = Dims<N, M, Q>> + Variational<R> + Variational<Unstructured<R>>,
        Q: VectorCoordinates<N>,
    {
        let (mut a, mut b) = (scene.start, scene.start);
        for k in 0..50 {
            let wiener = Wiener::new(7);
            let dw = core::array::from_fn(|i| wiener.increment(k, i, scene.h));
            scene.derived.step(&mut a, scene.h, &dw).unwrap();
            scene.unstructured.step(&mut b, scene.h, &dw).unwrap();
        }
        let numbers = |state: &State<Q>| [state.q.coordinates(), Q::components(&state.p)];
        let ([aq, ap], [bq, bp]) = (numbers(&a), numbers(&b));
        for i in 0..N {
            let error = (aq[i] - bq[i]).abs().max((ap[i] - bp[i]).abs());
            assert!(error < 1e-12, "{}: {a:?}, {b:?}", scene.name);
        }
    }

    #[test]
    fn what_the_steps_take() {
        let mut rows = Rows::default();
        every_scene(&mut rows);
        let found = rows.0.join("\n");
        assert_eq!(rows.0.len(), TABLE.lines().count(), "{found}");
        for (found, expected) in rows.0.iter().zip(TABLE.lines()) {
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn the_plan_distinguishes_angle_additions_from_calls() {
        let plan = Integrator::new(sve_models::oracle::pendulum(), Midpoint).plan();
        let text = plan.to_string();
        let last = "\n  operations an iteration: 13 arithmetic, 0 transcendental, 1 angle addition";
        assert!(text.ends_with(last), "{text}");
        let two = plan.operations(2);
        assert_eq!(two.arithmetic, plan.step.arithmetic + 2 * 13);
        assert_eq!((two.transcendental, two.angle_additions), (1, 2));
    }
}

/// The contribution of a term to a step.
mod terms {
    use sve_runtime::plan::Operations;
    use sve_runtime::prelude::*;
    use sve_runtime::{Plan, Variational};

    macro_rules! systems {
        ($($name:ident { $($members:tt)* })*) => {$(
            struct $name {
                g: f64,
                #[allow(dead_code)] // only some have the term
                s: f64,
            }

            #[variational(initial_point, endpoint, midpoint)]
            impl $name {
                fn lagrangian(&self, q: f64, v: f64) -> f64 {
                    0.5 * v * v + self.g * q.cos()
                }
                $($members)*
            }
        )*};
    }

    systems! {
        Bare {}
        Pushed {
            #[gamma]
            fn push(&self, q: f64) -> f64 {
                self.s * q
            }
        }
        Shaken {
            #[gamma]
            fn shake(&self, q: f64) -> f64 {
                self.s * q.exp()
            }
        }
        Forced {
            #[force]
            fn pull(&self, _q: f64, _v: f64) -> f64 {
                self.s
            }
        }
    }

    /// Arithmetic and calls that a system has more than the bare one: before the steps, once a
    /// step, in an iteration.
    fn more<S: Variational<R>, R>() -> [[i64; 2]; 3]
    where
        Bare: Variational<R>,
    {
        let of = |o: Operations| [o.arithmetic, o.transcendental].map(|n| n as i64);
        let parts = |plan: &Plan| [plan.prepare, plan.step, plan.iteration].map(of);
        let (a, b) = (
            parts(<R as sve_runtime::Rule<S::Itself>>::PLAN),
            parts(<R as sve_runtime::Rule<Bare>>::PLAN),
        );
        core::array::from_fn(|i| [0, 1].map(|j| a[i][j] - b[i][j]))
    }

    const NOTHING: [i64; 2] = [0, 0];

    #[test]
    fn a_term_adds_its_own_operations() {
        // σΔW and its sum; where the bare step ends with a change of sign, the sum takes that in
        let pushed = more::<Pushed, InitialPoint>();
        assert_eq!(pushed, [NOTHING, [2, 0], NOTHING]);
        let pushed = more::<Pushed, Endpoint>();
        assert_eq!(pushed, [NOTHING, [2 - 1, 0], NOTHING]);
        // the kick in the equation and in the first guess, which is then the one of the linearly
        // implicit step; and the limit, which is solved for by itself
        let pushed = more::<Pushed, Midpoint>();
        assert_eq!(pushed, [[1, 0], [7, 0], NOTHING]);
        // one function, whatever is differentiated
        let shaken = more::<Shaken, InitialPoint>();
        assert_eq!(shaken, [NOTHING, [2 - 1, 1], NOTHING]);
        let shaken = more::<Shaken, Endpoint>();
        assert_eq!(shaken, [NOTHING, [3 - 1, 1], NOTHING]);
        let shaken = more::<Shaken, Midpoint>();
        // and what bounds it in the judge of the root
        assert_eq!(shaken, [[7, 0], [35, 1], [12, 1]]);
        // a constant force is known before the step
        let forced = more::<Forced, InitialPoint>();
        assert_eq!(forced, [[1, 0], [1 - 2, 0], NOTHING]);
        let forced = more::<Forced, Endpoint>();
        assert_eq!(forced, [[1, 0], [1 - 1, 0], NOTHING]);
        let forced = more::<Forced, Midpoint>();
        assert_eq!(forced, [[2, 0], [2, 0], NOTHING]);
    }
}
