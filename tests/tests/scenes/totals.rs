//! Sums that enter other formulas, such as a mean field.

use sve_runtime::prelude::*;

use crate::common::spread;

/// Rotors in the field of their mean, which the first one changes, with noise by another sum.
mod rotors {
    use sve_runtime::prelude::*;
    both! {
        struct { j: f64, sigma: f64, mass: Vec<f64> }
        [f64] 11
        |self, q, v| {
            let n = q.len() as f64;
            let x = q.iter().map(|q| q.cos()).sum::<f64>() / n;
            let y = q.iter().map(|q| q.sin()).sum::<f64>() / n;
            let mut l = 0.5 * self.j * n * (x * x + y * y).sqrt() + 0.3 * q[0] * x * x;
            for i in 0..q.len() {
                l += 0.5 * self.mass[i] * v[i] * v[i] - 0.1 * q[i] * q[i];
            }
            l
        }
        #[gamma]
        fn bath(&self, q) -> f64 {
            let s = q.iter().map(|q| q * q).sum::<f64>();
            self.sigma * s.sqrt()
        }
    }
}

/// The squared distances of neighbours and from the centre.
mod cloud {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        struct { g: f64 }
        [Vector3<f64>] 5
        |self, q, v| {
            let mut l = 0.0;
            let mut spread = 0.0;
            let mut stretch = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i].norm_squared();
                spread += q[i].norm_squared();
                for j in 0..i {
                    stretch += (q[i] - q[j]).norm_squared();
                }
            }
            l - self.g * (spread * stretch) / (1.0 + spread) - 0.1 * stretch
        }
    }
}

#[test]
fn mean_fields_step_like_unrolled_ones() {
    let mass: Vec<f64> = (1..=11).map(|i| 0.5 + 0.1 * f64::from(i)).collect();
    let q: [f64; 11] = spread(11, 3).try_into().expect("11 numbers");
    let p: [f64; 11] = spread(11, 4).try_into().expect("11 numbers");
    compare!(
        rotors {
            j: 0.8,
            sigma: 0.3,
            mass: mass.clone()
        },
        q,
        p,
        [0.2]
    );
    compare!(
        compositions rotors {
            j: 0.8,
            sigma: 0.3,
            mass: mass.clone()
        },
        q,
        p,
        [0.2]
    );
}

#[test]
fn sums_in_formulas_of_bodies_step_like_unrolled_ones() {
    use sve_runtime::nalgebra::Vector3;
    let row = |x: &[f64]| Vector3::new(x[0], x[1], x[2]);
    let rows = |seed| -> [Vector3<f64>; 5] {
        let numbers = spread(15, seed);
        std::array::from_fn(|i| row(&numbers[3 * i..]))
    };
    compare!(cloud { g: 0.7 }, rows(5), rows(6), []);
}

/// The energy is that of the user's function, and blocks of steps have the bits of single steps.
#[test]
fn mean_fields_have_energies_and_trajectories() {
    let n = 3000;
    let system = rotors::scene::System {
        j: 0.8,
        sigma: 0.0,
        mass: vec![1.0; n],
    };
    let rotors = Integrator::new(system, StormerVerlet);
    let start = State::new(spread(n, 1), spread(n, 2));
    let energy = |state: &State<Vec<f64>>| {
        let expected = -rotors.system().lagrangian(&state.q, &vec![0.0; n])
            + state.p.iter().map(|p| 0.5 * p * p).sum::<f64>();
        let found = rotors.system().hamiltonian(state).expect("an energy");
        assert!((found - expected).abs() < 1e-12 * expected.abs());
        found
    };
    let first = energy(&start);
    let mut path = rotors.trajectory(start.clone(), 0.02, NoNoise);
    let end = path.advance(200).expect("steps").clone();
    // of order h²: 7.5e-7 here
    assert!((energy(&end) / first - 1.0).abs() < 2e-6);
    let mut single = rotors.trajectory(start, 0.02, NoNoise);
    for _ in 0..200 {
        single.advance(1).expect("a step");
    }
    assert_eq!(&end, single.advance(0).expect("the state"));
}

#[test]
fn the_plan_lists_totals() {
    let system = rotors::scene::System {
        j: 0.8,
        sigma: 0.0,
        mass: vec![],
    };
    let plan = Integrator::new(system, Endpoint).plan().to_string();
    assert!(
        plan.contains("S[0] += cos(q[i]) for i in 0..q.len()"),
        "{plan}"
    );
}

/// A mean field that turns, nearest images in L, γ and F, and friction, against a step by hand.
#[test]
fn totals_read_the_time_and_rounded_numbers_stand_in_all_functions() {
    struct Ring {
        j: f64,
        side: f64,
        sigma: f64,
    }
    #[variational(stormer_verlet)]
    impl Ring {
        fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
            let n = q.len() as f64;
            let x = q.iter().map(|q| (q - t).cos()).sum::<f64>() / n;
            let mut l = 0.5 * self.j * n * x * x;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i];
                if i > 0 {
                    let d = q[i] - q[i - 1];
                    l -= 0.5 * (d - self.side * (d / self.side).round()).powi(2);
                }
            }
            l
        }
        #[gamma]
        fn bath(&self, q: &[f64]) -> Vec<f64> {
            q.iter()
                .map(|q| self.sigma * (q - self.side * (q / self.side).round()).powi(2))
                .collect()
        }
        #[force]
        fn drag(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
            (0..q.len())
                .map(|i| -0.1 * v[i] + 0.01 * (q[i] - q[i].round()))
                .collect()
        }
    }
    let (h, a) = (1e-3, 0.5e-3 * 0.1);
    for n in [1, 2, 7, 300] {
        let (j, side, sigma) = (0.7, 2.0, 0.05);
        let ring = Integrator::new(Ring { j, side, sigma }, StormerVerlet);
        let q: Vec<f64> = spread(n, 7).iter().map(|x| 5.0 * x).collect();
        let (p, dw) = (spread(n, 8), spread(n, 9));
        let image = |d: f64| d - side * (d / side).round();
        let impulse = |t: f64, q: &[f64], i: usize| {
            let x = q.iter().map(|q| (q - t).cos()).sum::<f64>() / n as f64;
            let mut f = 0.01 * (q[i] - q[i].round()) - j * x * (q[i] - t).sin();
            if i > 0 {
                f -= image(q[i] - q[i - 1]);
            }
            if i + 1 < n {
                f += image(q[i + 1] - q[i]);
            }
            h * f + dw[i] * sigma * 2.0 * image(q[i])
        };
        let half = (0..n).map(|i| (p[i] + 0.5 * impulse(0.2, &q, i)) / (1.0 + a));
        let half: Vec<f64> = half.collect();
        let q1: Vec<f64> = (0..n).map(|i| q[i] + h * half[i]).collect();
        let p1 = (0..n).map(|i| half[i] * (1.0 - a) + 0.5 * impulse(0.2 + h, &q1, i));
        let p1: Vec<f64> = p1.collect();
        let mut state = State::at(0.2, q, p);
        ring.step(&mut state, h, &dw).expect("a step");
        crate::common::assert_same(&state, &q1, &p1, "ring");
    }
}

/// Sites in a potential and in the field of their mean.
struct Mean {
    own: f64,
    mean: f64,
}

#[variational(midpoint)]
impl Mean {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len() as f64;
        let sum = q.iter().sum::<f64>();
        let mut l = -0.5 * self.mean * sum * sum / n;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i] - 0.5 * self.own * q[i] * q[i];
        }
        l
    }
}

/// The eigenvalues of `own + mean 11ᵀ/n` are `own` and `own + mean`, for any n, and so are the
/// bounds of the row sums, `own ± mean`.
#[test]
fn bounds_with_a_mean_field_do_not_grow_with_the_number_of_sites() {
    for n in [2, 20, 3000] {
        let step = |h: f64| {
            let (own, mean) = (-1.0, 0.5);
            let mut state = State::new(spread(n, 3), spread(n, 4));
            Integrator::new(Mean { own, mean }, Midpoint).step(&mut state, h, &[])
        };
        step(1.6).expect("a step");
        let Err(StepError::Stiff { bounds, .. }) = step(2.0) else {
            panic!("a lower bound below −1");
        };
        assert!(
            (bounds[0] + 1.5).abs() < 1e-12 && (bounds[1] + 0.5).abs() < 1e-12,
            "{bounds:?}"
        );
    }
}
