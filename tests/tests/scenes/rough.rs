//! Conditions on numbers, and rounded numbers: L is smooth between their steps only.

use sve_runtime::Plan;
use sve_runtime::prelude::*;

use crate::common::spread;

/// Bodies in a periodic box, each near the nearest image of the others.
struct Periodic {
    side: f64,
    cut2: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Periodic {
    fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * (v[i][0].powi(2) + v[i][1].powi(2));
            // a field of the period of the box; L is smooth enough for differences of fourth order
            let x = q[i][0] - self.side * (q[i][0] / self.side).round();
            l -= 0.1 * (1.0 - 4.0 * (x / self.side).powi(2)).powi(6);
            for j in 0..i {
                let mut r2 = 0.0;
                for axis in 0..2 {
                    let d = q[j][axis] - q[i][axis];
                    r2 += (d - self.side * (d / self.side).round()).powi(2);
                }
                if r2 < self.cut2 {
                    l -= (1.0 - r2 / self.cut2).powi(6) / (0.5 + r2);
                }
            }
        }
        l
    }
}

/// The plan says it of scenes whose conditions or rounded numbers depend on the state, and of no
/// others.
#[test]
fn plans_say_what_is_only_piecewise_smooth() {
    struct Parameters {
        side: f64,
        cut: f64,
    }
    #[variational(endpoint)]
    impl Parameters {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - self.side.round() * q[i] * q[i];
                if i % 2 == 0 && self.side < self.cut {
                    l -= q[i].powi(4);
                }
            }
            l
        }
    }
    let [side, cut] = [3.0, 4.0];
    let smooth = Integrator::new(Parameters { side, cut }, Endpoint).plan();
    let rough = Periodic { side, cut2: 1.2 };
    let rough = Integrator::new(rough, StormerVerlet).plan();
    let says = |plan: &Plan| plan.to_string().contains("only piecewise smooth");
    assert_eq!([says(smooth), says(rough)], [false, true]);
}

#[test]
fn rounded_numbers_are_constants_for_derivatives() {
    let (n, h) = (40, 0.01);
    let system = Periodic {
        side: 3.0,
        cut2: 1.2,
    };
    let numbers = spread(2 * n, 8);
    // within two periods in each direction
    let q: Vec<[f64; 2]> = numbers
        .chunks(2)
        .map(|x| [6.0 * x[0], 6.0 * x[1]])
        .collect();
    let found = impulses!(&system, q, [0.0; 2], h, &[]);
    let zero = vec![[0.0; 2]; n];
    for i in 0..n {
        for axis in 0..2 {
            let at = |by: f64| {
                let mut moved = q.clone();
                moved[i][axis] += by;
                system.lagrangian(&moved, &zero)
            };
            let step = 1e-3;
            let difference = |step: f64| (at(step) - at(-step)) / (2.0 * step);
            let slope = (4.0 * difference(step) - difference(2.0 * step)) / 3.0;
            let expected = h * slope;
            assert!((found[i][axis] - expected).abs() < 1e-9, "{i} {axis}");
        }
    }
    // images are the same place
    let images: Vec<[f64; 2]> = q.iter().map(|q| [q[0] + 3.0, q[1] - 6.0]).collect();
    let of_images = impulses!(&system, images, [0.0; 2], h, &[]);
    for (a, b) in found.iter().flatten().zip(of_images.iter().flatten()) {
        assert!((a - b).abs() < 1e-12);
    }
    let energy = system.hamiltonian(&State::new(q.clone(), zero.clone()));
    let expected = -system.lagrangian(&q, &zero);
    assert!((energy.expect("an energy") - expected).abs() < 1e-12 * expected.abs());
}

/// Times stand in conditions, and in numbers that are rounded, without standing in a derivative.
#[test]
fn conditions_and_rounded_numbers_read_the_time() {
    struct Switched {
        from: f64,
    }
    #[variational(endpoint)]
    impl Switched {
        fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i];
                if t > self.from {
                    l -= 0.5 * q[i] * q[i];
                }
            }
            l
        }
    }
    struct Moved;
    #[variational(endpoint)]
    impl Moved {
        fn lagrangian(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] - 0.5 * (q[i] - t.round()).powi(2);
            }
            l
        }
    }
    for (t, switched, moved) in [(0.0, 0.0, -0.25), (5.0, -0.25, 1.0)] {
        let start = State::at(t, vec![1.0; 3], vec![0.0; 3]);
        let mut state = start.clone();
        let step = Integrator::new(Switched { from: 1.0 }, Endpoint).step(&mut state, 0.25, &[]);
        assert_eq!((step, state.p), (Ok(()), vec![switched; 3]), "{t}");
        let mut state = start;
        let step = Integrator::new(Moved, Endpoint).step(&mut state, 0.25, &[]);
        assert_eq!((step, state.p), (Ok(()), vec![moved; 3]), "{t}");
    }
}
