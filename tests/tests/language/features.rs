//! The language of a body, feature by feature. The derived value equals the user's function, and
//! the derived derivatives equal its difference quotients.

use sve_models::feature;
use sve_models::language::{check, close, slope, with};
use sve_runtime::prelude::*;
use sve_runtime::system::System;

feature! {
    let_patterns, LetPatterns { m: [f64; 2] = [1.5, 0.5] },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m1, m2] = self.m;
        let [x, y] = q;
        let ((a, _), [b, c]) = ((x.sin(), 2.0), [y, x]);
        let Self { m } = self;
        let d: f64 = a * b + c;
        m1 * v[0] * v[0] + m2 * v[1] * v[1] - d * m[0] + v[0] * d
    }
}

feature! {
    shadowing, Shadowing { k: f64 = 2.0 },
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        let q = q[0];
        let v = v[0];
        let x = q * q;
        let x = {
            let x = x + 1.0;
            x.ln() * self.k
        } + x;
        {
            let x = 0.0;
            let _ = x;
        }
        v * v - x
    }
}

feature! {
    mutation, Mutation { k: f64 = 2.0 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut x = q[0];
        x += self.k;
        x *= v[0];
        x -= q[1] * v[1];
        x /= 1.0 + q[0] * q[0];
        let mut a = [q[0], q[1]];
        a[1] += a[0];
        a[0] *= a[1];
        let mut pair = (x, [v[0], 1.0]);
        pair.1[0] += pair.0;
        pair.0 = a[0];
        x = pair.1[0] * pair.0;
        x * x + v[0] * v[0] + v[1] * v[1]
    }
}

feature! {
    nested_loops, NestedLoops { k: [f64; 3] = [0.5, 1.5, 2.5] },
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        for i in 0..q.len() {
            sum += 0.5 * v[i] * v[i];
            for j in i + 1..3 {
                sum -= self.k[i] * self.k[j] * (q[i] - q[j]).cos();
            }
            for j in 0..=i {
                let next = q[(i + j + 1) % 3];
                sum += (j as f64 + 1.0) * next * q[i];
            }
        }
        for x in q {
            sum += x.powi(3);
        }
        sum
    }
}

feature! {
    arrays_of_arrays, ArraysOfArrays { m: [[f64; 2]; 2] = [[2.0, 0.3], [0.3, 1.0]] },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mut w = [[0.0; 2]; 2];
        for i in 0..2 {
            for j in 0..2 {
                w[i][j] = self.m[i][j] + q[i] * q[j];
            }
        }
        let row = w[1];
        let mut sum = row[0] * v[0];
        for i in 0..2 {
            for j in 0..2 {
                sum += w[i][j] * v[i] * v[j];
            }
        }
        sum
    }
}

feature! {
    helpers, Helpers { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let tip = self.tip(q);
        let (kinetic, potential) = Self::energies(v, tip);
        kinetic - self.k * potential - Helpers::square(q[0]) + Self::twice(self, q[1])
    }
    fn tip(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        [a.cos() + Self::square(b), self.k * a.sin()]
    }
    fn energies(v: [f64; 2], x: [f64; 2]) -> (f64, f64) {
        let mut kinetic = 0.0;
        for w in v {
            kinetic += Self::square(w);
        }
        (kinetic, Self::norm(&x))
    }
    fn norm(x: &[f64; 2]) -> f64 {
        Self::square(x[0]) + Self::square((*x)[1])
    }
    fn square(x: f64) -> f64 {
        x * x
    }
    fn twice(&self, x: f64) -> f64 {
        2.0 * x
    }
}

feature! {
    constants, Constants { k: f64 = 1.2 },
    const N: usize = 2;
    const LAST: usize = Self::N - 1;
    const G: f64 = 9.81;
    const MASSES: [f64; Self::N] = [1.0, Self::G / 2.0];
    fn lagrangian(&self, q: [f64; Self::N], v: [f64; 2]) -> f64 {
        let mut w = [0.0; Self::N];
        let pairs = [[1.0; Self::N]; Self::LAST];
        for i in 0..Self::N {
            w[i] = Self::MASSES[i] * v[i] * v[i] * pairs[0][i];
        }
        w[0] + w[Self::LAST] - Self::G * q[0].sin() * q[1] * std::f64::consts::PI - core::f64::consts::FRAC_PI_4 * self.k
    }
}

feature! {
    qualified_functions, QualifiedFunctions { k: f64 = 1.2 },
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        f64::powi(v[0], 2) + f64::sin(self.k * q[0]) + f64::hypot(q[0], 1.0) + f64::mul_add(q[0], v[0], f64::from(2u8))
    }
}

feature! {
    powers, Powers { e: f64 = 1.3 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let x = q[0] + 0.5;
        v[0].powi(2) * x.powi(-3) + v[1].powi(2) * x.powi(0) + x.powf(1.5) + x.powf(-2.5) + x.powf(0.37)
            + x.powf(self.e) + x.powf(q[1]) + (x * x).powf(0.5) + 2f64.powf(q[1]) + x.powf(2.0)
    }
}

feature! {
    trigonometry, Trigonometry { k: f64 = 0.8 },
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        let x = self.k * q[0];
        let (s, c) = x.sin_cos();
        v[0] * v[0] + s * c + x.tan() + x.asin() - x.acos() + x.atan() + x.atan2(1.0 + v[0]) + x.to_radians() + x.to_degrees()
    }
}

feature! {
    hyperbolic, Hyperbolic { k: f64 = 0.8 },
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        let x = self.k * q[0];
        v[0] * v[0] + x.sinh() * x.cosh() - x.tanh() + x.asinh() + (1.5 + x).acosh() + x.atanh()
    }
}

feature! {
    exponentials, Exponentials { k: f64 = 0.8 },
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        let x = self.k * q[0];
        v[0] * v[0] + x.exp() - x.exp2() + x.exp_m1() + x.ln() * x.ln_1p() + x.log2() + x.log10() + x.sqrt() + x.cbrt()
            + x.recip() + x.hypot(v[0]) + x.mul_add(v[0], 3.0) + (-x).exp() + (-x).cbrt()
    }
}

feature! {
    signs, Signs { k: f64 = 0.8 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let d = q[0] - q[1];
        let r = (d * d).sqrt();
        let down = -(d - 1.0);
        v[0] * v[0] + v[1] * v[1] - r + (-d).sin() * (-d).cos() - (-d).atan() / down + (2.0 * q[1] - 2.0 * q[0]).tanh()
            + (d * d * d).cbrt() - -self.k * d + ((-2.0) * d).powi(3) + (q[0] - q[1]).powi(2) * (q[1] - q[0]).powi(3)
    }
}

feature! {
    references, References { m: [f64; 2] = [1.0, 2.0] },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let (x, m) = (&q, &self.m);
        let first = &x[0];
        m[0] * v[0] * v[0] + m[1] * v[1] * v[1] - *first * x[1]
    }
}

feature! {
    functions_of_roles, FunctionsOfRoles { k: f64 = 0.4 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[1] * v[1] - self.push(q)
    }
    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.k * q[0] * q[1]
    }
}

/// Fields of fields, with names that run together.
#[derive(Debug)]
struct Body {
    mass: f64,
    arm: (f64, [f64; 2]),
}

feature! {
    nested_fields, NestedFields { body: Body = Body { mass: 1.5, arm: (0.3, [0.2, 0.9]) }, body_mass: f64 = 0.25, body_arm_0: f64 = 7.0 },
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        let arm = &self.body.arm;
        self.body.mass * v[0] * v[0] - self.body_mass * q[0] - self.body.arm.0 * q[0].cos() + arm.1[1] * arm.1[0]
            + self.body_arm_0 * q[0].sin()
    }
}

#[derive(Debug)]
struct Scalar {
    k: f64,
}

#[variational(initial_point, endpoint, midpoint, taylor2)]
impl Scalar {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * v * v * (1.0 + 0.1 * (self.k * t).sin()) - q.powi(4) * t + v * (q * t).cos()
    }
}

#[test]
fn scalar_with_time() {
    let system = Scalar { k: 3.0 };
    check(&system, |t, q, v| system.lagrangian(t, q[0], v[0]));
}

#[derive(Debug)]
struct Points {
    m: [f64; 3],
}

#[variational(midpoint)]
impl Points {
    fn lagrangian(&self, q: [[f64; 2]; 3], v: [[f64; 2]; 3]) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            let [x, y] = v[i];
            sum += 0.5 * self.m[i] * (x * x + y * y);
            for j in 0..i {
                let (dx, dy) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                sum += self.m[i] * self.m[j] / (dx * dx + dy * dy + 0.01).sqrt();
            }
        }
        sum
    }

    #[h1]
    fn turn(&self, q: [[f64; 2]; 3], p: [[f64; 2]; 3]) -> [f64; 3] {
        let mut turn = [0.0; 3];
        for i in 0..3 {
            turn[i] = self.m[i] * (q[i][0] * p[i][1] - q[i][1] * p[i][0]);
        }
        turn
    }
}

#[test]
fn points_in_the_plane() {
    let system = Points { m: [1.0, 2.0, 0.5] };
    check::<_, _, 6, 3>(&system, |_, q, v| {
        let rows = |x: &[f64]| [[x[0], x[1]], [x[2], x[3]], [x[4], x[5]]];
        system.lagrangian(rows(q), rows(v))
    });
}

feature! {
    casts_wrap, CastsWrap { k: f64 = 0.5 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let large = 300i32;
        let mut sum = (large as u8) as f64 * q[0] + ((large - 400) as i8) as f64 * q[1];
        sum += (large as u8 as i16 - 100) as f64 * v[0] * v[1] + (70_000u32 as i16) as f64 * self.k;
        for i in 0..2 {
            let signed = i as i64 - 1;
            sum += signed as f64 * q[i] + (200 + 50 * i as i32) as u8 as f64 * v[i] * v[i];
        }
        sum + f64::from(2_u8.pow(7)) * (2_i8.pow(6) as i32 * 4) as f64 * q[0].sin()
    }
}

feature! {
    arrays_of_functions, ArraysOfFunctions { k: [f64; 3] = [0.5, 1.5, 0.7] },
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let doubled: [f64; 3] = std::array::from_fn(|i| 2.0 * q[i] + self.k[i]);
        let products: [[f64; 2]; 3] = core::array::from_fn(|i| std::array::from_fn(|j| doubled[i] * q[j]));
        let twice = std::array::from_fn::<f64, { Self::LONG }, _>(|i| i as f64 * q[i % 3]);
        let kinetic = self.squares(v);
        kinetic.iter().sum::<f64>() - products.as_flattened().iter().sum::<f64>() * twice[3] - twice[4].sin()
    }
    fn squares(&self, v: [f64; 3]) -> [f64; 3] {
        let half = 0.5;
        std::array::from_fn(|i| half * self.k[i] * v[i] * v[i])
    }
    const LONG: usize = 5;
}

feature! {
    conversions, Conversions { k: f64 = 0.5 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let three: f64 = 3.into();
        let pair: [f64; 2] = (q[0] * v[1], three).into();
        let same: f64 = self.k.into();
        let small: i32 = 7_u8.into();
        v[0] * v[0] + Self::half(2_i32.into()) * v[1] * v[1] + pair[0] * pair[1] - same * self.count() * q[1] + small as f64 * q[0]
    }
    fn half(x: f64) -> f64 {
        0.5 * x
    }
    fn count(&self) -> f64 {
        5_u16.into()
    }
}

#[derive(Debug)]
struct Tuple(f64, [f64; 2]);

#[variational(midpoint)]
impl Tuple {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        let Self(k, pair) = self;
        0.5 * self.0 * v * v - self.1[1] * q * q + pair[0] * k * q
    }
}

#[test]
fn tuple_structs() {
    let system = Tuple(1.5, [0.25, 2.0]);
    check(&system, |_, q, v| system.lagrangian(q[0], v[0]));
}

#[test]
fn noises_are_the_functions() {
    let system = Points { m: [1.0, 2.0, 0.5] };
    let q = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
    let p = [0.9, 0.7, 0.5, 0.3, 0.1, -0.1];
    let rows = |x: &[f64]| [[x[0], x[1]], [x[2], x[3]], [x[4], x[5]]];
    let jets = system.noise_jets(0.0, &q, &p);
    for (a, jet) in jets.iter().enumerate() {
        for i in 0..6 {
            let along_q = |x: f64| system.turn(rows(&with(&q, i, x)), rows(&p))[a];
            let along_p = |x: f64| system.turn(rows(&q), rows(&with(&p, i, x)))[a];
            close("dG/dq", jet.dq[i], slope(&along_q, q[i]), 1e-9);
            close("dG/dp", jet.dp[i], slope(&along_p, p[i]), 1e-9);
        }
    }
}

#[test]
fn gamma_enters_with_a_minus() {
    let system = FunctionsOfRoles { k: 0.4 };
    let (q, p) = ([0.3, 0.8], [0.0, 0.0]);
    let [jet] = system.noise_jets(0.0, &q, &p);
    for i in 0..2 {
        let along = |x: f64| -system.push(with(&q, i, x).try_into().unwrap());
        close("dG/dq", jet.dq[i], slope(&along, q[i]), 1e-9);
    }
}
