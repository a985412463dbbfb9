//! Forces that depend on velocities of any site: pairwise friction, a magnetic force, drag that is
//! not linear.

use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;

use crate::common::spread;

/// Friction along the lines between all pairs of bodies, as in dissipative particle dynamics.
mod pairs {
    use sve_runtime::prelude::*;
    both! {
        struct { m: Vec<f64>, gamma: f64, sigma: f64 }
        [[f64; 2]] 8
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.m[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                for j in 0..i {
                    let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                    l -= (-(x * x + y * y)).exp();
                }
            }
            l
        }
        #[gamma]
        each push(&self, q) -> f64 |i| { self.sigma * (q[i][0] - q[i][1] * q[i][0]) }
        #[force]
        each drag(&self, q, v; t) -> [f64; 2] |i| {
            let mut f = [0.1 * (t + q[i][1]).sin(), -0.2 * v[i][1]];
            for j in 0..q.len() {
                if j == i {
                    continue;
                }
                let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                let r2 = x * x + y * y;
                let along = x * (v[i][0] - v[j][0]) + y * (v[i][1] - v[j][1]);
                let w = self.gamma * (-r2).exp() / (r2 + 0.1) * along;
                f[0] -= w * x;
                f[1] -= w * y;
            }
            f
        }
    }
}

/// Relativistic bodies in a magnetic field that depends on the place and the time, with a drag that
/// is not linear and a friction.
mod magnetic {
    use sve_runtime::prelude::*;
    both! {
        explicit struct { b: Vec<f64>, k: f64, nu: f64 }
        [[f64; 2]] 6
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l -= (1.0 - v[i][0] * v[i][0] - v[i][1] * v[i][1]).sqrt();
                l -= 0.5 * (q[i][0] - q[(i + 1) % q.len()][1]).powi(2);
            }
            l
        }
        #[force]
        each field(&self, q, v; t) -> [f64; 2] |i| {
            let b = self.b[i] * (q[i][0] + t).cos();
            let speed = (v[i][0] * v[i][0] + v[i][1] * v[i][1] + 0.01).sqrt();
            [
                b * v[i][1] - self.k * speed * v[i][0] - self.nu * v[i][0],
                -b * v[i][0] - self.k * speed * v[i][1] - self.nu * v[i][1] + q[i][0].sin(),
            ]
        }
    }
}

/// A chain that drags its neighbours, in a wind of the mean of all places.
mod wind {
    use sve_runtime::prelude::*;
    both! {
        struct { mu: f64, wind: f64 }
        [f64] 11
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.3 * q[i].powi(4);
            }
            l
        }
        #[force]
        each drag(&self, q, v) -> f64 where { let mean = q.iter().sum::<f64>() / 11.0; } |i| {
            let mut f = -0.1 * (v[i] - self.wind * mean.sin()).powi(3);
            if i > 0 {
                f -= self.mu * (v[i] - v[i - 1]);
            }
            if i + 1 < q.len() {
                f -= self.mu * (v[i] - v[i + 1]);
            }
            f
        }
    }
}

fn rows<const N: usize>(seed: u64) -> [[f64; 2]; N] {
    let x = spread(2 * N, seed);
    std::array::from_fn(|i| [x[2 * i], x[2 * i + 1]])
}

#[test]
fn forces_of_velocities_are_those_of_unrolled_systems() {
    let m: Vec<f64> = spread(8, 3).iter().map(|x| 2.0 + x).collect();
    let dw: [f64; 8] = std::array::from_fn(|i| 0.2 * spread(8, 4)[i]);
    compare!(
        pairs {
            m: m.clone(),
            gamma: 0.7,
            sigma: 0.3
        },
        rows::<8>(1),
        rows::<8>(2),
        dw
    );
    compare!(
        compositions pairs {
            m: m.clone(),
            gamma: 0.7,
            sigma: 0.3
        },
        rows::<8>(1),
        rows::<8>(2),
        dw
    );
    compare!(
        explicit magnetic {
            b: spread(6, 9),
            k: 0.4,
            nu: 0.3
        },
        rows::<6>(5),
        rows::<6>(6),
        []
    );
    let numbers = |seed| -> [f64; 11] { spread(11, seed).try_into().expect("eleven") };
    compare!(wind { mu: 0.5, wind: 0.8 }, numbers(1), numbers(2), []);
}

/// Friction between neighbours in a ring of any length.
struct Ring {
    mu: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Ring {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        (0..n)
            .map(|i| 0.5 * v[i] * v[i] - 0.5 * (q[(i + 1) % n] - q[i]).powi(2))
            .sum()
    }
    #[force]
    fn drag(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let n = q.len();
        (0..n)
            .map(|i| self.mu * (v[(i + 1) % n] + v[(i + n - 1) % n] - 2.0 * v[i]))
            .collect()
    }
}

/// Pairwise friction keeps the total momentum and takes energy, in blocks of steps as in single
/// ones, which have the same bits.
#[test]
fn pairwise_friction_keeps_the_momentum() {
    fn check<R>(rule: R)
    where
        R: sve_runtime::Rule<Ring, Increments = [f64]>,
    {
        let n = 1000;
        let ring = Integrator::new(Ring { mu: 0.4 }, rule);
        let start = State::new(spread(n, 1), spread(n, 2));
        let total: f64 = start.p.iter().sum();
        let before = ring.system().hamiltonian(&start).expect("an energy");
        let mut path = ring.trajectory(start.clone(), 0.1, NoNoise);
        let end = path.advance(100).expect("steps").clone();
        let mut single = ring.trajectory(start, 0.1, NoNoise);
        for _ in 0..100 {
            single.advance(1).expect("a step");
        }
        assert_eq!(&end, single.advance(0).expect("the state"));
        let change = end.p.iter().sum::<f64>() - total;
        assert!(change.abs() < 1e-11, "{change}");
        let after = ring.system().hamiltonian(&end).expect("an energy");
        assert!(after < 0.2 * before, "{before} {after}");
    }
    check(StormerVerlet);
    check(Midpoint);
}

/// Friction between free neighbours in a ring.
struct Free {
    mu: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Free {
    fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
        v.iter().map(|v| 0.5 * v * v).sum()
    }
    #[force]
    fn drag(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let n = q.len();
        (0..n)
            .map(|i| self.mu * (v[(i + 1) % n] + v[(i + n - 1) % n] - 2.0 * v[i]))
            .collect()
    }
}

/// A wave of the wave number k decays by (1 + hν/2)⁻¹ (1 − hν/2) in a step of Störmer and Verlet
/// and of the midpoint rule, with ν = 4 μ sin²(k/2), if nothing else acts. The places, far from 0,
/// have no part in it: in short steps they have no digits of the velocities.
#[test]
fn a_wave_decays_as_one_with_its_friction_does() {
    fn check<R>(rule: R, [h, mu]: [f64; 2], steps: u64)
    where
        R: sve_runtime::Rule<Free, Increments = [f64]>,
    {
        let (n, wave) = (64, 5.0);
        let k = wave * std::f64::consts::TAU / f64::from(n);
        let p: Vec<f64> = (0..n).map(|i| (k * f64::from(i)).cos()).collect();
        let free = Integrator::new(Free { mu }, rule);
        let mut path = free.trajectory(State::new(vec![1000.0; 64], p.clone()), h, NoNoise);
        let end = path.advance(steps).expect("steps");
        let half = 0.5 * h * 4.0 * mu * (0.5 * k).sin().powi(2);
        let factor = ((1.0 - half) / (1.0 + half)).powi(steps as i32);
        for (p, start) in end.p.iter().zip(&p) {
            assert!((p - factor * start).abs() < 1e-14, "{p} {}", factor * start);
        }
    }
    for of_step in [[0.1, 0.8], [1e-6, 8e4], [-1e-3, 0.8]] {
        check(StormerVerlet, of_step, 50);
        check(Midpoint, of_step, 50);
    }
}

/// The friction 2μ of each site is a part of f = h/(1 + hμ), and the rows of −2 ∂D/∂v have the
/// entry −2μ twice: the bounds are ±f μ.
#[test]
fn bounds_with_forces_of_velocities_are_their_spectrum() {
    let (h, mu) = (-1.0, 0.8);
    let mut state = State::new(spread(64, 1), spread(64, 2));
    let result = Integrator::new(Free { mu }, Midpoint).step(&mut state, h, &[]);
    let Err(StepError::Stiff { bounds, .. }) = result else {
        panic!("{result:?}");
    };
    let [low, high] = [bounds[0] + 4.0, bounds[1] - 4.0];
    assert!(low.abs() < 1e-13 && high.abs() < 1e-13, "{bounds:?}");
}

/// With forces `g (1 + q²) v − k q` at q = 0 the equation of a step of the length s h has the slope
/// 1 + s² k h²/4 − s g h/2. It is positive at s = 1, and with g = 2.9375 not in between: the
/// solution is then not the one of short steps, though it is unique.
#[test]
fn a_step_beyond_a_singular_one_is_refused() {
    struct Driven {
        k: f64,
        g: f64,
    }
    #[variational(midpoint)]
    impl Driven {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            (0..q.len())
                .map(|i| 0.5 * v[i] * v[i] - 0.5 * self.k * q[i] * q[i])
                .sum()
        }
        #[force]
        fn push(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
            (0..q.len())
                .map(|i| self.g * (1.0 + q[i] * q[i]) * v[i])
                .collect()
        }
    }
    let step = |g: f64| {
        let mut state = State::new(vec![0.0; 3], vec![0.0; 3]);
        Integrator::new(Driven { k: 2.0, g }, Midpoint).step(&mut state, 2.0, &[])
    };
    step(0.5).expect("a slope that stays positive");
    let Err(StepError::Stiff { bounds, .. }) = step(2.9375) else {
        panic!("a slope that vanishes between");
    };
    assert_eq!(bounds, [-2.9375, -0.9375]);
}

#[test]
fn the_plan_of_midpoint_has_the_forces_of_velocities() {
    let plan = Integrator::new(Free { mu: 0.8 }, Midpoint)
        .plan()
        .to_string();
    for line in [
        "solve: d = h (M + h N/2)⁻¹ (p₀ + (I(q₀ + d/2) + D(q₀ + d/2, d/h))/2), sweeps of Richardson's iteration",
        "end: q₁ = q₀ + d, p₁ = p₀ + I + D − N d",
    ] {
        assert!(plan.contains(line), "{plan}");
    }
}

/// If the iteration before a drift does not contract, the error names a step size at which it does,
/// and the endpoint rule makes the step.
#[test]
fn strong_forces_of_velocities_name_a_step_size() {
    let start = State::new(spread(30, 1), spread(30, 2));
    for h in [1.0, -3.0] {
        let ring = Integrator::new(Ring { mu: 20.0 }, StormerVerlet);
        let mut state = start.clone();
        let error = ring.step(&mut state, h, &[]).expect_err("a strong force");
        assert_eq!(state, start);
        // the first ratios may be smaller than the later ones
        let (mut short, mut error) = (h, Err(error));
        for _ in 0..4 {
            let Err(StepError::Contraction { wanted, .. }) = error else {
                break;
            };
            assert!(wanted > 0.0 && wanted < f64::abs(short), "{wanted}");
            short = wanted * h.signum();
            error = ring.step(&mut state, short, &[]);
        }
        assert_eq!(error, Ok(()), "{short}");
        assert!(short.abs() > 1e-3, "{short}");
        let explicit = Integrator::new(Ring { mu: 20.0 }, Endpoint);
        explicit.step(&mut state, h, &[]).expect("an explicit step");
        let kinds = [ring.plan().kind(), explicit.plan().kind()];
        assert_eq!(kinds, [BlockKind::FixedPoint, BlockKind::Explicit]);
    }
}

#[test]
fn an_index_of_a_velocity_is_checked() {
    struct Ahead;
    #[variational(endpoint)]
    impl Ahead {
        fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
            v.iter().map(|v| 0.5 * v * v).sum()
        }
        #[force]
        fn drag(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
            (0..q.len()).map(|i| v[i + 1] - v[i]).collect()
        }
    }
    let start = State::new(vec![0.0; 3], vec![1.0; 3]);
    let mut state = start.clone();
    let error = Integrator::new(Ahead, Endpoint).step(&mut state, 0.1, &[]);
    let error = error.expect_err("an index");
    let StepError::Index {
        text,
        index: 3,
        length: 3,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!(&**text, "`v[i + 1]` in `drag` (i = 2)");
    assert_eq!(state, start);
}
