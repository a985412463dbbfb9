//! Common idioms: iterators, slices, closures, conditions on indices, constants from outside the
//! block. Each derived system is compared with the user's function, and its derivatives with
//! difference quotients.

use std::f64::consts::PI;

use sve_models::feature;
use sve_models::language::check;
use sve_runtime::prelude::*;

/// Constants of the file.
const GRAVITY: f64 = 9.81;
const MASSES: [f64; 2] = [1.5, 0.5];

/// Constants of a module.
mod constants {
    pub(super) const STIFFNESS: f64 = 2.5;
}

feature! {
    loops_over_iterators, LoopsOverIterators { k: [f64; 3] = [0.5, 1.5, 2.5] },
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        for (i, x) in q.iter().enumerate() {
            sum -= self.k[i] * x.cos();
        }
        for (x, y) in v.iter().zip(q) {
            sum += x * x * (1.0 + y * y);
        }
        for (k, &x) in self.k.iter().zip(&q) {
            sum -= k * x.powi(4);
        }
        for i in (1..3).rev() {
            sum -= (i as f64) * (q[i] - q[i - 1]).powi(2);
        }
        for i in (0..=2).step_by(2) {
            sum += q[i];
        }
        for &x in &q {
            sum += 0.1 * x;
        }
        sum
    }
}

feature! {
    sums_of_iterators, SumsOfIterators { m: [f64; 3] = [0.5, 1.5, 2.5] },
    const N: usize = 3;
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let kinetic: f64 = v.iter().zip(&self.m).map(|(v, m)| 0.5 * m * v * v).sum();
        let springs = (1..Self::N).map(|i| (q[i] - q[i - 1]).powi(2)).sum::<f64>();
        let pairs = (0..Self::N)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| ((q[i] - q[j]) * (i + j) as f64).cos())
            .sum::<f64>();
        let product: f64 = q.iter().map(|x| 1.0 + x * x).product();
        let norm = q.iter().fold(1.0, |sum, x| sum + x * x).sqrt();
        let count = (0..Self::N).filter(|&i| i != 1).map(|i| i + 1).sum::<usize>();
        kinetic - springs - pairs - product.ln() * norm + count as f64 * q[1]
    }
}

feature! {
    slices_and_pieces, SlicesAndPieces { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let bends: f64 = q.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2)).sum();
        let planar: f64 = v.chunks_exact(2).map(|w| w[0] * w[0] + w[1] * w[1]).sum();
        let steps: f64 = q[1..].iter().zip(&q[..3]).map(|(a, b)| (a - b).cos()).sum();
        let ends = q.iter().skip(3).chain(q.iter().take(1)).sum::<f64>();
        let squares = q.map(|x| x * x);
        planar - self.k * bends - steps - ends * squares[1..=2][1] + squares.len() as f64
    }
}

feature! {
    conditions_on_indices, ConditionsOnIndices { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            let weight = if i == 0 { self.k } else if i < 2 { 2.0 } else { 3.0 };
            sum += weight * v[i] * v[i];
            for j in 0..3 {
                if i == j {
                    continue;
                }
                sum -= (q[i] - q[j]).cos();
            }
            for j in 0..3 {
                if j > i || (j == i && i == 2) {
                    break;
                }
                sum += q[j] * q[i];
            }
        }
        sum
    }
}

feature! {
    deferred_and_swapped, DeferredAndSwapped { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let (kinetic, potential);
        kinetic = v[0] * v[0] + v[1] * v[1];
        {
            potential = self.k * q[0].cos();
        }
        let (mut a, mut b) = (q[0], q[1].exp());
        (a, b) = (b, a + b);
        [a, _] = [a * b, 0.0];
        let [first, .., last] = [a, b, kinetic];
        let all @ [_, rest @ ..] = [first, last];
        all[0] * rest[0] - potential + kinetic
    }
}

feature! {
    constants_from_elsewhere, ConstantsFromElsewhere { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        use std::f64::consts::{FRAC_PI_2, TAU as TURN};
        const HALF: f64 = 0.5;
        let mut kinetic = 0.0;
        for (m, v) in MASSES.iter().zip(v) {
            kinetic += HALF * m * v * v;
        }
        kinetic - MASSES[1] * GRAVITY * (q[0] / PI).cos() - constants::STIFFNESS * (q[1] * TURN).sin() * FRAC_PI_2
            + self::constants::STIFFNESS * f64::EPSILON * self.k
    }
}

feature! {
    helpers_with_lengths, HelpersWithLengths { m: [f64; 2] = [1.5, 0.5], axis: [[f64; 2]; 2] = [[1.0, 0.2], [0.3, 2.0]] },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let m: [f64; 2] = self.m;
        let mut sum = Self::dot(&v, &v) - Self::weighted(&self.m, q);
        for m in m {
            sum -= m * Self::dot(&self.turned(&q), &v);
        }
        sum * Self::dot::<2>(&m, &self.m) + v[0].powi(4)
    }
    fn dot<const K: usize>(a: &[f64; K], b: &[f64; K]) -> f64 {
        let mut sum = 0.0;
        for i in 0..K {
            sum += a[i] * b[i];
        }
        sum
    }
    fn weighted(m: &[f64; 2], x: [f64; 2]) -> f64 {
        m.iter().zip(x).map(|(m, x)| m * x.cos()).sum::<f64>() + m.len() as f64
    }
    fn turned(&self, x: &[f64]) -> [f64; 2] {
        let axis: [[f64; 2]; 2] = self.axis;
        axis.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
    }
}

feature! {
    closures, Closures { k: [f64; 2] = [0.7, 1.3] },
    #[allow(clippy::let_and_return)] // spellings are what is tested
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let square = |x: f64| x * x;
        let half = 0.5;
        let kinetic = |i: usize| -> f64 {
            let energy = half * square(v[i]);
            energy
        };
        let half = 0.25;
        let spring = move |(k, x): (f64, &f64)| half * k * square(*x);
        let pairs = (0..2).map(|i| kinetic(i) * square(q[1 - i])).sum::<f64>();
        let springs = self.k.into_iter().zip(&q).map(spring).sum::<f64>();
        Self::total(2, |i| kinetic(i) + pairs) - springs - Self::total(2, |i| q[i].sin() * self.k[i])
    }
    fn total(n: usize, term: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        for i in 0..n {
            sum += term(i);
        }
        sum
    }
}

feature! {
    #[allow(clippy::useless_conversion)] // a matrix stays one
    converted_parameters, ConvertedParameters {
        m: [[f64; 2]; 2] = [[2.0, 0.3], [0.1, 1.5]],
        n: Matrix2<f64> = Matrix2::new(1.0, 0.2, -0.4, 2.0),
        r: Rotation2<f64> = Rotation2::new(0.3)
    },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let m: Matrix2<f64> = self.m.into();
        let n: Matrix2<f64> = self.n.into();
        let r: Matrix2<f64> = self.r.into();
        let (q, v) = (Vector2::from(q), Vector2::from(v));
        v.dot(&(m * v)) + m.m12 * q.x.sin() - q.dot(&(n * q)) - r[(1, 0)] * q.y.cos() - (r * q).y.powi(4)
    }
}

/// A module of the user that has the name of the standard library's.
mod consts {
    pub(super) const G0: f64 = 9.806_65;
    pub(super) const TAU: f64 = std::f64::consts::TAU;
}

feature! {
    constants_of_a_module_of_the_same_name, ConstantsOfAModuleOfTheSameName { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0].powi(2) + v[1].powi(2) - self.k * (consts::TAU * q[0]).cos() - consts::G0 * q[1].sin()
    }
}

feature! {
    constants_of_an_imported_module, ConstantsOfAnImportedModule { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        use std::f64::consts;
        consts::LN_2 * v[0].powi(2) + v[1].powi(2) - self.k * (consts::TAU * q[0]).cos() * q[1].sin()
    }
}

feature! {
    all_constants_at_once, AllConstantsAtOnce { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        use std::f64::consts::*;
        FRAC_1_PI * v[0].powi(2) + LN_2 * v[1].powi(2) - self.k * (TAU * q[0]).cos() * (q[1] / SQRT_2).sin()
    }
}

feature! {
    functions_by_name, FunctionsByName { k: f64 = 0.7 },
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v.map(Self::square).iter().sum::<f64>() - q.iter().copied().map(f64::sin).sum::<f64>() * self.k
    }
    fn square(x: f64) -> f64 {
        x * x
    }
}

feature! {
    #[allow(clippy::inconsistent_digit_grouping, clippy::unreadable_literal)]
    numbers, Numbers { k: f64 = 0.7 },
    #[allow(clippy::cast_lossless, clippy::manual_clamp, clippy::neg_multiply)] // spellings are what is tested
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let n = 3_usize;
        let x = q[0] + 1.;
        -v[0].powi(2) * -1e0 + v[1].powi(2) * 1_000.0e-3 + 2f64 * x.log(10.) + x.log(q[1] + 2_f64)
            - x.powi(n as i32 - 5) + x.powf(-1.5) * x.powf(1.0 / 2.0) + -x.powi(2) + (-x).powi(3)
            + x.powf(2.0 / 3.0) + f64::from(7u8) + (2_i32.pow(3) as f64) * x + n.min(2).max(1) as f64
            + (n as i32 - 4).abs() as f64 * x.powi(0) + x.powf(0.0) + x.powf(1.0) * self.k.powi(1)
    }
}

/// Lengths computed from constants of the block.
#[derive(Debug)]
struct Lengths {
    k: f64,
}

#[variational(midpoint)]
impl Lengths {
    const N: usize = 2;
    const DIM: usize = 2 * Self::N - 1;

    fn lagrangian(&self, q: [[f64; 2 * Self::N]; Self::DIM - 2], v: [[f64; 4]; 1]) -> f64 {
        v.as_flattened().iter().map(|x| x * x).sum::<f64>()
            - self.k * q.iter().flatten().map(|x| x.sin()).product::<f64>()
    }
}

#[test]
fn lengths_from_constants() {
    let system = Lengths { k: 0.7 };
    check::<_, _, 4, 0>(&system, |_, q, v| system.lagrangian([*q], [*v]));
}

feature! {
    entries_changed_in_place, EntriesChangedInPlace { k: [f64; 3] = [0.5, 1.5, 0.7] },
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut x = q;
        for x in x.iter_mut() {
            *x *= 2.0;
        }
        for (i, x) in x.iter_mut().enumerate() {
            *x += self.k[i] * v[i];
        }
        for (x, v) in x.iter_mut().rev().zip(&v) {
            *x = *x * x.sin() + v * v;
        }
        for x in &mut x[1..] {
            *x -= 1.0;
        }
        x.iter_mut().skip(1).for_each(|x| *x *= 0.5);
        let mut rows = [[x[0], v[1]], [q[2], x[1]]];
        for row in rows.iter_mut() {
            let first = row[0];
            row[1] += first * row[1];
            for entry in row.iter_mut() {
                *entry = entry.cos() + *entry;
            }
        }
        for [a, b] in &mut rows {
            let moved = a;
            *moved += 0.5 * *b;
            *b = moved.powi(2);
        }
        let mut pair = (1.0, [q[0], q[1]]);
        for (entry, scale) in pair.1.iter_mut().zip([2.0, 3.0]) {
            *entry *= scale * pair.0;
        }
        pair.0 += 1.0;
        let mut firsts: [f64; 2] = std::array::from_fn(|i| rows[i][0]);
        for (pair, target) in rows.iter().zip(firsts.iter_mut()) {
            *target *= pair[1];
        }
        v.iter().map(|v| v * v).sum::<f64>() - x.iter().sum::<f64>() - rows.as_flattened().iter().sum::<f64>()
            + pair.0 * pair.1[0] * pair.1[1] + firsts[0] * firsts[1]
    }
}

/// Attributes and items that are not for this macro are passed through.
mod passed_through {
    /// A system that is visible in other modules.
    #[derive(Debug)]
    pub(super) struct Through {
        pub(super) k: f64,
    }

    #[sve_runtime::variational(midpoint)]
    impl Through
    where
        Through: Sized,
    {
        /// L, at compile time too.
        #[inline]
        #[must_use]
        pub(super) const fn lagrangian(&self, q: f64, v: f64) -> f64
        where
            Self: Sized,
        {
            0.5 * v * v - self.k * Self::square(q)
        }

        /// Helpers may be `const`, hidden and unused.
        #[doc(hidden)]
        #[inline(always)]
        const fn square(x: f64) -> f64 {
            x * x
        }

        #[allow(dead_code)]
        #[deprecated]
        pub(super) fn describe(&self) -> String {
            format!("{self:?}")
        }
    }

    pub(super) const AT_REST: f64 = Through { k: 2.0 }.lagrangian(1.0, 0.0);
}

#[test]
fn what_is_not_the_macros_is_passed_through() {
    let system = passed_through::Through { k: 0.7 };
    check(&system, |_, q, v| system.lagrangian(q[0], v[0]));
    assert_eq!(passed_through::AT_REST, -2.0);
}
