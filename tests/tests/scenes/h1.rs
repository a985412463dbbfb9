//! Noises that move positions, `#[h1]`: of each site, and of neighbours.

use sve_runtime::plan::{BlockKind, StrongOrder};
use sve_runtime::prelude::*;

use crate::common::spread;

/// Kubo oscillators in a chain.
mod kubo {
    use sve_runtime::prelude::*;
    both! {
        @rules (stormer_verlet, midpoint)
        struct { omega: Vec<f64>, spring: f64, sigma: f64 }
        [f64] 8
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.5 * self.omega[i] * q[i] * q[i];
            }
            for i in 1..q.len() {
                l -= 0.5 * self.spring * (q[i] - q[i - 1]).powi(2);
            }
            l
        }
        #[h1]
        each phase(&self, q, p) -> f64 |i| { 0.5 * self.sigma * (p[i] * p[i] + q[i] * q[i]) }
    }
}

/// Relativistic bodies with two listed noises, one of a mean, a noise of each body that reads the
/// next one, a γ, friction, and a magnetic force.
mod bodies {
    use sve_runtime::prelude::*;
    both! {
        @rules (stormer_verlet)
        struct { k: f64, sigma: [f64; 3], nu: f64 }
        [[f64; 2]] 6
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l -= (1.0 - v[i][0] * v[i][0] - v[i][1] * v[i][1]).sqrt();
                l -= 0.5 * self.k * (q[i][0] - q[(i + 1) % q.len()][1]).powi(2);
            }
            l
        }
        #[gamma]
        each push(&self, q) -> f64 |i| { self.sigma[0] * q[i][0].sin() * q[i][1] }
        #[h1]
        fn turn(&self, q, p; t) -> [f64; 2] {
            let mean = q.iter().map(|q| q[0]).sum::<f64>() / 6.0;
            let mut turn = 0.0;
            let mut stretch = self.sigma[1] * mean * mean;
            for i in 0..q.len() {
                turn += self.sigma[1] * t.cos() * (q[i][0] * p[i][1] - q[i][1] * p[i][0]);
                stretch += self.sigma[2] * q[i][0] * p[i][0];
            }
            [turn, stretch]
        }
        #[h1]
        each swap(&self, q, p) -> f64 |i| {
            self.sigma[2] * (q[i][0] * p[(i + 1) % q.len()][1] + p[i][0].sin())
        }
        #[force]
        each drag(&self, q, v) -> [f64; 2] |i| {
            [
                v[i][1] * q[i][0] - self.nu * v[i][0],
                -v[i][0] * q[i][0] - self.nu * v[i][1],
            ]
        }
    }
}

/// The same with masses, the friction of each component, and a drag that is not linear.
mod heavy {
    use sve_runtime::prelude::*;
    both! {
        @rules (stormer_verlet, midpoint)
        struct { m: Vec<f64>, k: f64, sigma: [f64; 3], nu: f64 }
        [[f64; 2]] 6
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * self.m[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                l -= 0.5 * self.k * (q[i][0] - q[(i + 1) % q.len()][1]).powi(2);
            }
            l
        }
        #[gamma]
        each push(&self, q) -> f64 |i| { self.sigma[0] * q[i][0].sin() * q[i][1] }
        #[h1]
        fn turn(&self, q, p; t) -> [f64; 2] {
            let mean = q.iter().map(|q| q[0]).sum::<f64>() / 6.0;
            let mut turn = 0.0;
            let mut stretch = self.sigma[1] * mean * mean;
            for i in 0..q.len() {
                turn += self.sigma[1] * t.cos() * (q[i][0] * p[i][1] - q[i][1] * p[i][0]);
                stretch += self.sigma[2] * q[i][0] * p[i][0];
            }
            [turn, stretch]
        }
        #[h1]
        each swap(&self, q, p) -> f64 |i| {
            self.sigma[2] * (q[i][0] * p[(i + 1) % q.len()][1] + p[i][0].sin())
        }
        #[force]
        each drag(&self, q, v) -> [f64; 2] |i| {
            [
                (v[i][1] * q[i][0]).sin() - self.nu * v[i][0],
                -v[i][0] * q[i][0] - 0.3 * v[i][1],
            ]
        }
    }
}

#[test]
fn steps_with_h1_are_those_of_unrolled_systems() {
    let scene = kubo::scene::System {
        omega: spread(8, 7),
        spring: 0.8,
        sigma: 0.5,
    };
    let unrolled = kubo::unrolled::System {
        omega: scene.omega.clone(),
        spring: 0.8,
        sigma: 0.5,
    };
    let numbers = |seed| -> [f64; 8] { spread(8, seed).try_into().expect("eight") };
    let (q, p, dw) = (numbers(1), numbers(2), numbers(4).map(|x| 0.3 * x));
    compare!(@each scene, unrolled, q, p, dw, StormerVerlet, Composed::new(StormerVerlet, KahanLi8), Midpoint, Composed::new(Midpoint, KahanLi8));
    let (k, sigma, nu) = (0.7, [0.3, 0.2, 0.25], 0.4);
    let scene = bodies::scene::System { k, sigma, nu };
    let unrolled = bodies::unrolled::System { k, sigma, nu };
    let rows = |seed| -> [[f64; 2]; 6] {
        let x = spread(12, seed);
        std::array::from_fn(|i| [x[2 * i], x[2 * i + 1]])
    };
    let dw: [f64; 14] = std::array::from_fn(|i| 0.3 * spread(14, 9)[i]);
    let (q, p) = (rows(5), rows(6));
    compare!(@each scene, unrolled, q, p, dw, StormerVerlet, Composed::new(StormerVerlet, KahanLi8));
    let m: Vec<f64> = spread(6, 8).iter().map(|m| 1.5 + m).collect();
    let scene = heavy::scene::System {
        m: m.clone(),
        k,
        sigma,
        nu,
    };
    let unrolled = heavy::unrolled::System { m, k, sigma, nu };
    compare!(@each scene, unrolled, q, p, dw, StormerVerlet, Midpoint, Composed::new(Midpoint, KahanLi8));
}

#[test]
fn plans_tell_whether_h1_commute() {
    let kubo = kubo::scene::System {
        omega: Vec::new(),
        spring: 0.0,
        sigma: 1.0,
    };
    let plan = Integrator::new(kubo, StormerVerlet).plan();
    assert_eq!(plan.strong_order, StrongOrder::One);
    assert_eq!(plan.kind(), BlockKind::FixedPoint, "{plan}");
    let (k, sigma, nu) = (0.7, [0.3; 3], 0.4);
    let plan = Integrator::new(bodies::scene::System { k, sigma, nu }, StormerVerlet).plan();
    assert_eq!(
        plan.strong_order,
        StrongOrder::Half {
            pair: ("turn", "push")
        }
    );
}

/// Two numbers with the normal distribution from two uniform ones.
fn normals(n: usize, seed: u64) -> Vec<f64> {
    let uniform = spread(2 * n, seed);
    let pairs = uniform.chunks_exact(2);
    let normal = pairs.map(|u| {
        let (x, y) = (0.5 + 0.5 * u[0], std::f64::consts::PI * u[1]);
        (-2.0 * (1.0 - x).ln()).sqrt() * y.cos()
    });
    normal.collect()
}

/// A Kubo oscillator turns by the angle t + σW: the error of a step at a time is of order 1 in h.
#[test]
fn kubo_oscillators_have_strong_order_one() {
    assert_strong_order_one(StormerVerlet);
    assert_strong_order_one(Midpoint);
}

fn assert_strong_order_one<R>(rule: R)
where
    R: sve_runtime::Rule<kubo::scene::System, Increments = [f64]> + Copy + std::fmt::Debug,
{
    let (n, finest, sigma) = (600, 256, 0.5);
    let fine: f64 = 1.0 / finest as f64;
    let paths: Vec<Vec<f64>> = (0..finest)
        .map(|step| {
            normals(n, 100 + step as u64)
                .iter()
                .map(|x| fine.sqrt() * x)
                .collect()
        })
        .collect();
    let total = |site: usize| paths.iter().map(|dw| dw[site]).sum::<f64>();
    let error = |steps: usize| {
        let system = kubo::scene::System {
            omega: vec![1.0; n],
            spring: 0.0,
            sigma,
        };
        let chain = Integrator::new(system, rule);
        let mut state = State::new(vec![1.0; n], vec![0.0; n]);
        for part in paths.chunks(finest / steps) {
            let dw: Vec<f64> = (0..n).map(|i| part.iter().map(|dw| dw[i]).sum()).collect();
            chain
                .step(&mut state, 1.0 / steps as f64, &dw)
                .expect("a step");
        }
        let squares = (0..n).map(|i| {
            let angle = 1.0 + sigma * total(i);
            (state.q[i] - angle.cos()).powi(2) + (state.p[i] + angle.sin()).powi(2)
        });
        (squares.sum::<f64>() / n as f64).sqrt()
    };
    let order = (error(32) / error(256)).log2() / 3.0;
    // the standard error of the order is about 1/(3 √n)
    assert!((order - 1.0).abs() < 0.1, "{order} {rule:?}");
}

/// H₁ = σ q p multiplies places by exp(σW): the iteration of a step with a large increment does not
/// contract, and the error says so. A trajectory makes single steps with the same bits as blocks.
#[test]
fn large_increments_are_refused() {
    struct Stretch {
        sigma: f64,
    }
    #[variational(stormer_verlet)]
    impl Stretch {
        fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
            v.iter().map(|v| 0.5 * v * v).sum()
        }
        #[h1]
        fn stretch(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
            q.iter().zip(p).map(|(q, p)| self.sigma * q * p).collect()
        }
    }
    let stretch = Integrator::new(Stretch { sigma: 1.0 }, StormerVerlet);
    let start = State::new(vec![1.0; 3], vec![0.5; 3]);
    let mut state = start.clone();
    let error = stretch
        .step(&mut state, 0.1, &[0.1, 3.0, 0.0])
        .expect_err("a large increment");
    let StepError::Contraction { wanted, .. } = error else {
        panic!("{error}");
    };
    assert_eq!(state, start);
    // increments are in proportion to the square root of the step size
    let scale = (wanted / 0.1).sqrt();
    let shorter = [0.1, 3.0, 0.0].map(|dw| scale * dw);
    let mut moved = start.clone();
    stretch.step(&mut moved, wanted, &shorter).expect("a step");
    let error = stretch
        .step(&mut state, 0.1, &[0.1, f64::NAN, 0.0])
        .expect_err("no number");
    assert!(matches!(error, StepError::NonFiniteInput { .. }), "{error}");
    stretch
        .step(&mut state, 0.1, &[0.1, 0.3, 0.0])
        .expect("a step");
    // p = p₀/(1 + ½σΔW), q₁ = (q₀ + h p + ½σΔW q₀)/(1 − ½σΔW)
    let p = 0.5 / 1.15;
    let q = (1.0 + 0.1 * p + 0.15) / 0.85;
    assert!((state.q[1] - q).abs() < 1e-15 * q, "{} {q}", state.q[1]);
    assert!((state.p[1] - p * 0.85).abs() < 1e-15, "{}", state.p[1]);
    let mut path = stretch.trajectory(start.clone(), 0.01, Wiener::new(3));
    let end = path.advance(90).expect("steps").clone();
    let mut single = stretch.trajectory(start, 0.01, Wiener::new(3));
    for _ in 0..90 {
        single.advance(1).expect("a step");
    }
    assert_eq!(&end, single.advance(0).expect("the state"));
}
