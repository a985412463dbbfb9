//! The midpoint rule in scenes: its equations join all sites.

use sve_runtime::prelude::*;

use crate::bounds::Springs;
use crate::common::spread;

/// Pendula with springs between them.
mod pendula {
    use sve_runtime::prelude::*;
    both! {
        struct { mass: Vec<f64>, beta: f64, g: f64 }
        [f64] 5
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.mass[i] * v[i] * v[i] + self.g * q[i].cos();
            }
            for i in 1..q.len() {
                let d = q[i] - q[i - 1];
                l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
            }
            l
        }
    }
}

pub(crate) fn pendula(n: usize, beta: f64, g: f64) -> pendula::scene::System {
    let mass = (0..n).map(|i| 1.0 + 0.25 * (i % 5) as f64).collect();
    pendula::scene::System { mass, beta, g }
}

/// Independent of this project: fixed-point iteration of the equations with 60 digits.
#[test]
fn steps_have_the_digits_of_exact_arithmetic() {
    let q: Vec<f64> = (0..5)
        .map(|i| [0.125, -0.25, 0.375, -0.5, 0.625][i])
        .collect();
    let p: Vec<f64> = (0..5).map(|i| (f64::from(i) + 1.0) / 8.0 - 0.25).collect();
    let cases = [
        (
            0.015_625,
            [
                0.122_989_213_007_364_05,
                -0.249_870_020_262_005_92,
                0.376_113_090_909_233_5,
                -0.497_509_519_407_864,
                0.627_782_267_711_095_6,
            ],
            [
                -0.132_380_735_057_399_78,
                0.020_796_758_079_052_333,
                0.088_713_454_572_833_58,
                0.307_867_652_638_475_5,
                0.337_260_534_040_478_23,
            ],
        ),
        (
            0.5,
            [
                0.022_012_396_328_341_767,
                -0.148_880_946_611_205_02,
                0.274_416_845_600_257_5,
                -0.233_157_068_608_664_95,
                0.598_672_329_884_004_7,
            ],
            [
                -0.286_950_414_686_632_9,
                0.505_595_266_943_974_9,
                -0.728_498_926_398_455_1,
                1.617_900_519_739_345_2,
                -0.585_621_360_927_963,
            ],
        ),
    ];
    for (h, expected_q, expected_p) in cases {
        let mut state = State::new(q.clone(), p.clone());
        let integrator = Integrator::new(pendula(5, 0.7, 0.5), Midpoint);
        integrator.step(&mut state, h, &[]).expect("a step");
        let found = state.q.iter().chain(&state.p);
        for (x, y) in found.zip(expected_q.iter().chain(&expected_p)) {
            assert!((x - y).abs() < 3e-16, "{h}: {x} {y}");
        }
    }
}

/// Random pendula with longer and longer steps: the solution is that of the unrolled step, which
/// follows it from h = 0, or the step is refused and the state unchanged.
#[test]
fn the_root_is_the_one_that_is_connected_with_a_short_step() {
    let [mut same, mut refused] = [0, 0];
    for seed in 0..400 {
        let numbers = spread(13, 700 + seed);
        let (beta, g) = (2.0 * numbers[0].abs(), 8.0 * numbers[1]);
        let h = 0.1 + 1.2 * numbers[2].abs();
        let scene = pendula(5, beta, g);
        let unrolled = pendula::unrolled::System {
            mass: scene.mass.clone(),
            beta,
            g,
        };
        let q: [f64; 5] = std::array::from_fn(|i| 3.0 * numbers[3 + i]);
        let p: [f64; 5] = std::array::from_fn(|i| numbers[8 + i]);
        let start = State::new(q.to_vec(), p.to_vec());
        let mut state = start.clone();
        let made = Integrator::new(&scene, Midpoint).step(&mut state, h, &[]);
        let mut expected = State::new(q, p);
        let found = Integrator::new(&unrolled, Midpoint).step(&mut expected, h, &[]);
        match made {
            Ok(()) => {
                found.expect("the unrolled step has the solution");
                same += 1;
                for (x, y) in
                    (state.q.iter().zip(&expected.q)).chain(state.p.iter().zip(&expected.p))
                {
                    assert!((x - y).abs() < 1e-12 * (1.0 + y.abs()), "{seed}: {x} {y}");
                }
            }
            Err(StepError::Stiff { bounds, .. }) => {
                refused += 1;
                let [lower, upper] = bounds.map(|bound| 1.0 + bound);
                assert!(lower <= 0.0 || upper > 100.0 * lower, "{bounds:?}");
                assert_eq!(state, start);
            }
            // the solution is far from the boxes, for which the bounds hold
            Err(StepError::NotContracting { .. }) => {
                refused += 1;
                assert_eq!(state, start);
            }
            Err(error) => panic!("{seed}: {error}"),
        }
    }
    assert!(same > 80 && refused > 80, "{same} {refused}");
}

/// A step back undoes a step, at any size, with masses and friction of the sites and with noise.
#[test]
fn steps_back_undo_steps() {
    struct Bath {
        mass: Vec<f64>,
        nu: Vec<f64>,
    }
    #[variational(midpoint)]
    impl Bath {
        fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.mass[i] * (v[i][0].powi(2) + v[i][1].powi(2)) + q[i][0].cos();
                let next = q[(i + 1) % q.len()];
                for axis in 0..2 {
                    l -= 0.5 * (next[axis] - q[i][axis]).powi(2);
                }
            }
            l
        }
        #[gamma]
        fn bath(&self, q: &[[f64; 2]]) -> Vec<f64> {
            q.iter()
                .map(|q| 0.2 * q[0] * q[1] + 0.3 * q[1].sin())
                .collect()
        }
        #[force]
        fn friction(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> Vec<[f64; 2]> {
            (0..q.len())
                .map(|i| [-self.nu[i] * v[i][0], -self.nu[i] * v[i][1] + 0.1 * q[i][0]])
                .collect()
        }
    }
    let n = 3000;
    let positive = |seed| -> Vec<f64> { spread(n, seed).iter().map(|x| 1.2 + x).collect() };
    let system = Bath {
        mass: positive(1),
        nu: positive(2).into_iter().map(|x| 0.1 * x).collect(),
    };
    let rows = |seed| -> Vec<[f64; 2]> { spread(2 * n, seed).as_chunks().0.to_vec() };
    let start = State::new(rows(3), rows(4));
    let dw: Vec<f64> = spread(n, 5).iter().map(|x| 0.3 * x).collect();
    let back: Vec<f64> = dw.iter().map(|dw| -dw).collect();
    let integrator = Integrator::new(&system, Midpoint);
    let mut state = start.clone();
    integrator.step(&mut state, 0.2, &dw).expect("a step");
    assert!((state.q[7][0] - start.q[7][0]).abs() > 1e-3);
    integrator
        .step(&mut state, -0.2, &back)
        .expect("a step back");
    let numbers = |state: &State<Vec<[f64; 2]>>| {
        let all = state.q.iter().chain(&state.p).flatten();
        all.copied().collect::<Vec<f64>>()
    };
    for (x, y) in numbers(&state).into_iter().zip(numbers(&start)) {
        assert!((x - y).abs() < 1e-14, "{x} {y}");
    }
}

/// Pairs within a cut-off, lists, nearest images and pushes that depend on other sites: the
/// solution is that of a fixed-point iteration with the impulses of the endpoint rule.
#[test]
fn any_scene_has_the_solution_of_its_impulses() {
    struct Gas {
        side: f64,
        cut2: f64,
        pairs: Vec<[usize; 2]>,
    }
    #[variational(midpoint, endpoint)]
    impl Gas {
        fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * (v[i][0].powi(2) + v[i][1].powi(2));
                for j in 0..i {
                    let mut r2 = 0.0;
                    for axis in 0..2 {
                        let d = q[j][axis] - q[i][axis];
                        r2 += (d - self.side * (d / self.side).round()).powi(2);
                    }
                    if r2 < self.cut2 {
                        l -= (1.0 - r2 / self.cut2).powi(4) / (0.5 + r2).sqrt();
                    }
                }
            }
            for pair in &self.pairs {
                let [a, b] = [q[pair[0]], q[pair[1]]];
                l -= 0.1 * ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).powi(2);
            }
            l
        }
        #[force]
        fn push(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> Vec<[f64; 2]> {
            (0..q.len())
                .map(|i| [0.4 * q[(i + 1) % q.len()][1].sin(), 0.0 * v[i][0]])
                .collect()
        }
    }
    let n = 40;
    let system = Gas {
        side: 3.0,
        cut2: 1.2,
        pairs: (0..n).map(|i| [i, (i * i + 3) % n]).collect(),
    };
    let rows = |seed| -> Vec<[f64; 2]> { spread(2 * n, seed).as_chunks().0.to_vec() };
    let (q, p, h) = (rows(1), rows(2), 0.04);
    let mut state = State::new(q.clone(), p.clone());
    Integrator::new(&system, Midpoint)
        .step(&mut state, h, &[])
        .expect("a step");
    let mut d = vec![[0.0; 2]; n];
    let mut impulse = Vec::new();
    for _ in 0..60 {
        let node: Vec<[f64; 2]> = (0..n)
            .map(|i| [0, 1].map(|k| q[i][k] + 0.5 * d[i][k]))
            .collect();
        impulse = impulses!(&system, node, [0.0; 2], h, &[]);
        d = (0..n)
            .map(|i| [0, 1].map(|k| h * (p[i][k] + 0.5 * impulse[i][k])))
            .collect();
    }
    for i in 0..n {
        for k in 0..2 {
            let (x, y) = (state.q[i][k], q[i][k] + d[i][k]);
            assert!((x - y).abs() < 2e-15, "{i} {k}: {x} {y}");
            let (x, y) = (state.p[i][k], p[i][k] + impulse[i][k]);
            assert!((x - y).abs() < 2e-15, "{i} {k}: {x} {y}");
        }
    }
}

/// A trajectory is the repeated step, bit for bit, also in compositions and with noise.
#[test]
fn trajectories_are_repeated_steps() {
    fn check<R>(rule: R)
    where
        R: sve_runtime::Rule<pendula::scene::System, Increments = [f64]>,
    {
        let integrator = Integrator::new(pendula(300, 0.7, 0.5), rule);
        let start = State::new(spread(300, 1), spread(300, 2));
        let mut path = integrator.trajectory(start.clone(), 0.2, NoNoise);
        let end = path.advance(150).expect("steps");
        let mut state = start;
        for _ in 0..150 {
            integrator.step(&mut state, 0.2, &[]).expect("a step");
        }
        assert_eq!((&end.q, &end.p), (&state.q, &state.p));
    }
    check(Midpoint);
    check(Composed::new(Midpoint, KahanLi8));
}

/// Springs between the sites from `from` to `to`; the others are free.
struct Partly {
    from: usize,
    to: usize,
    nu: f64,
}

#[variational(midpoint)]
impl Partly {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in self.from + 1..self.to {
            l -= 0.5 * (q[i] - q[i - 1]).powi(2);
        }
        l
    }

    #[force]
    fn friction(&self, _q: &[f64], v: &[f64]) -> Vec<f64> {
        v.iter().map(|v| -self.nu * v).collect()
    }
}

/// Sites without terms, before and behind those with terms, move as alone: p₁ = r p₀ with
/// r = (1 − hν/2)/(1 + hν/2), and q₁ = q₀ + h (p₀ + p₁)/2.
#[test]
fn sites_without_terms_move_alone() {
    let (n, h) = (3000, 0.25);
    for [from, to] in [[0, 0], [5, 40], [1100, 2500], [0, 2999]] {
        for nu in [0.0, 0.5] {
            let integrator = Integrator::new(Partly { from, to, nu }, Midpoint);
            let mut state = State::new(spread(n, 3), spread(n, 4));
            for _ in 0..3 {
                let before = state.clone();
                integrator.step(&mut state, h, &[]).expect("a step");
                let ratio = (1.0 - 0.5 * h * nu) / (1.0 + 0.5 * h * nu);
                for i in (0..from).chain(to..n) {
                    let p = ratio * before.p[i];
                    let q = before.q[i] + 0.5 * h * (before.p[i] + p);
                    let error = (state.p[i] - p).abs().max((state.q[i] - q).abs());
                    assert!(error < 1e-15, "{from} {to} {nu} {i}: {error:e}");
                }
            }
        }
    }
}

/// A cusp: the impulse jumps at 0, and no node has the impulse of its side.
struct Cusp;

#[variational(midpoint)]
impl Cusp {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i];
            if q[i] > 0.0 {
                l -= q[i];
            } else {
                l += q[i];
            }
        }
        l
    }
}

/// Without a solution there is no step, though the bounds see no slope; the next step is as alone.
#[test]
fn a_step_without_a_solution_is_refused() {
    let (n, h) = (40, 0.1);
    // the impulse moves a node by h²/4
    let nodes = |part: f64| (0..n).map(move |i| if i == 17 { part * h * h } else { 1.0 });
    let integrator = Integrator::new(Cusp, Midpoint);
    for part in [-0.2, 0.2] {
        let mut start = State::new(nodes(part).collect::<Vec<f64>>(), vec![0.0; n]);
        // boxes are as wide as the largest displacement is long
        start.p[0] = 1.0;
        let mut state = start.clone();
        let made = integrator.step(&mut state, h, &[]);
        let Err(StepError::NotContracting { change, .. }) = made else {
            panic!("{made:?}");
        };
        assert!(change > 0.01, "{change}");
        assert_eq!(state, start);
    }
    for part in [-0.3, 0.3] {
        let mut state = State::new(nodes(part).collect::<Vec<f64>>(), vec![0.0; n]);
        integrator.step(&mut state, h, &[]).expect("a step");
        assert!((state.p[17] + h * f64::signum(part)).abs() < 1e-15);
    }
}

/// A step that overflowed leaves nothing behind for the next one.
#[test]
fn a_step_after_one_that_failed_is_as_alone() {
    let (h, springs) = (0.5, Springs { k: 1.0, own: 0.5 });
    let integrator = Integrator::new(&springs, Midpoint);
    let mut far = State::new(vec![1e308, -1e308, 1e308], vec![0.0; 3]);
    let made = integrator.step(&mut far, h, &[]);
    assert!(
        matches!(made, Err(StepError::NonFiniteCoordinate { .. })),
        "{made:?}"
    );
    let mut state = State::new(spread(3, 1), spread(3, 2));
    let mut expected = state.clone();
    integrator.step(&mut state, h, &[]).expect("a step");
    let alone = Integrator::new(&springs, Midpoint);
    alone.step(&mut expected, h, &[]).expect("a step");
    assert_eq!(state, expected);
}

/// Displacements have the digits that nodes lack: steps by one last digit of the places, of springs
/// that move together without impulses, and of free sites.
#[test]
fn small_displacements_keep_their_digits() {
    let (n, h, digit) = (40, 2.0f64.powi(-10), f64::EPSILON);
    for k in [0.0, 1.0] {
        let integrator = Integrator::new(Springs { k, own: 0.0 }, Midpoint);
        let start = State::new(vec![1.0; n], vec![digit / h; n]);
        let mut path = integrator.trajectory(start, h, NoNoise);
        let end = path.advance(1000).expect("steps");
        let expected = 1.0 + 1000.0 * digit;
        assert!(end.q.iter().all(|&q| q == expected), "{k}: {:?}", end.q);
    }
}
