//! Derivatives of explicit steps of many coordinates, which go by way of intermediate values: of
//! ten coordinates in two halves that do not interact, against the derivatives of five coordinates,
//! which have formulas.

use sve_runtime::prelude::*;

/// Some hundred operations on numbers up to 10.
const ROUNDING: f64 = 1e-13;

const H: f64 = 0.1;

macro_rules! halves {
    ($name:ident, $n:literal, $copies:literal) => {
        /// Sets of five points that attract one another, shaken together.
        struct $name {
            m: [f64; 5],
            k: f64,
            s: f64,
        }

        impl $name {
            const fn new() -> Self {
                Self {
                    m: [1.0, 1.3, 0.7, 0.9, 1.1],
                    k: 0.6,
                    s: 0.4,
                }
            }

            fn state() -> State<[f64; $n]> {
                let entry = |x: usize| (1.7 * (x % 5) as f64).sin();
                let momenta = |x: usize| 0.5 * (0.9 * (x % 5) as f64).cos();
                State::new(std::array::from_fn(entry), std::array::from_fn(momenta))
            }
        }

        #[variational(stormer_verlet)]
        impl $name {
            fn lagrangian(&self, t: f64, q: [f64; $n], v: [f64; $n]) -> f64 {
                let mut l = 0.0;
                for c in 0..$copies {
                    for i in 0..5 {
                        l += 0.5 * self.m[i] * v[5 * c + i].powi(2) + q[5 * c + i].cos() * t;
                        for j in 0..i {
                            l -= self.k / (1.0 + (q[5 * c + i] - q[5 * c + j]).powi(2)).sqrt();
                        }
                    }
                }
                l
            }

            #[gamma]
            fn shake(&self, q: [f64; $n]) -> f64 {
                let mut sum = 0.0;
                for i in 0..$n {
                    sum += self.s * q[i].sin();
                }
                sum
            }
        }
    };
}

halves!(Five, 5, 1);
halves!(Ten, 10, 2);

/// Returns whether two numbers are equal to rounding.
fn agree(a: f64, b: f64) -> bool {
    (a - b).abs() < ROUNDING
}

#[test]
fn tangents_and_sensitivities_are_those_of_the_halves() {
    let step = |dw| {
        let five = Integrator::new(Five::new(), StormerVerlet);
        let ten = Integrator::new(Ten::new(), StormerVerlet);
        let of_five = five.step_with_derivatives(&mut Five::state(), H, dw);
        let of_ten = ten.step_with_derivatives(&mut Ten::state(), H, dw);
        (of_five.unwrap(), of_ten.unwrap())
    };
    let ((five, five_by), (ten, ten_by)) = step(&[0.3]);
    for row in 0..20 {
        for column in 0..20 {
            let is_same_half = row % 10 / 5 == column % 10 / 5;
            // q of five, then p of five
            let in_five = |x: usize| x % 5 + 5 * (x / 10);
            let expected = if is_same_half {
                five[in_five(row)][in_five(column)]
            } else {
                0.0
            };
            assert!(agree(ten[row][column], expected), "{row} {column}");
        }
    }
    for ((name, five), (other, ten)) in five_by.iter().zip(ten_by.iter()) {
        assert_eq!(name, other);
        for i in 0..10 {
            assert!(agree(ten.q[i], five.q[i % 5]), "{name} {i}");
            assert!(agree(ten.p[i], five.p[i % 5]), "{name} {i}");
        }
    }
}

#[test]
fn gradients_are_those_of_the_halves() {
    let five = Integrator::new(Five::new(), StormerVerlet);
    let ten = Integrator::new(Ten::new(), StormerVerlet);
    let of_five = five
        .trajectory(Five::state(), H, Wiener::new(3))
        .gradient(10, |k, s| (k == 10).then(|| s.q[0] * s.p[1] + s.q[3]))
        .unwrap();
    let of_ten = ten
        .trajectory(Ten::state(), H, Wiener::new(3))
        .gradient(10, |k, s| (k == 10).then(|| s.q[5] * s.p[6] + s.q[8]))
        .unwrap();
    for i in 0..5 {
        assert!(agree(of_ten.start().q[5 + i], of_five.start().q[i]), "{i}");
        assert!(agree(of_ten.start().p[5 + i], of_five.start().p[i]), "{i}");
        assert!(agree(of_ten.start().q[i], 0.0) && agree(of_ten.start().p[i], 0.0));
    }
    for ((name, five), (_, ten)) in of_five.iter().zip(of_ten.iter()) {
        assert!(agree(ten, five), "{name}: {ten:e} for {five:e}");
    }
}

/// Steps keep the volume of phase space, so that all exponents together are zero.
#[test]
fn exponents_add_up_to_zero() {
    let ten = Integrator::new(Ten::new(), StormerVerlet);
    let mut path = ten.lyapunov(Ten::state(), H, Wiener::new(5), 20);
    path.advance(50).unwrap();
    let exponents = path.exponents();
    assert!(exponents[0] > 0.1, "{exponents:?}");
    let sum: f64 = exponents.iter().sum();
    assert!(agree(sum, 0.0), "{sum:e}");
}
