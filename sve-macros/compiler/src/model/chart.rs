//! The exponential chart of rotations.
//!
//! The increment of a rotation is the vector x of the rotation `R₀ᵀR₁ = exp(x̂)`: an angle |x|
//! about an axis. The chart moves with R₀. An action S(x, R̄) depends on the ends through x and the
//! middle `R̄ = R₀ exp(x̂/2)` of the geodesic between them. With g = ∂S/∂x and the left-trivialised
//! derivative τ of S in R̄ the momenta are
//!
//! ```text
//! Π₀ = A g + ½ x × g + B x (x·g) − ½ (τ + T x × τ)        Π₁ = Π₀ − x × g + τ
//! ```
//!
//! with three functions of s = |x|² and the angle θ = |x|,
//!
//! ```text
//! T = tan(θ/4)/θ        A = (θ/2) cot(θ/2)        B = (1 − A)/s
//! ```
//!
//! All are computed from one rational function u₂, without a root, an angle, or a difference that
//! cancels at 0:
//!
//! ```text
//! u = 1/48 + s u₂        T = (1 + s u)/4        B = (u + T²)/(4T)        A = 1 − s B
//! ```
//!
//! A free body turns about a principal axis by h Π/I in a step, as the motion does: no other chart
//! whose momenta have this form does so for each angle.
//!
//! Source of the derivative of the exponential: Hairer, Lubich, Wanner, *Geometric Numerical
//! Integration* (2006), section III.4; the second variation is a Jacobi field on a group with a
//! bi-invariant metric, at the middle of its geodesic.

mod parts;
#[cfg(test)]
mod tests;

use super::configuration::{DIRECTIONS, ENTRIES, cross};
use crate::algebra::{Arena, Expr};
pub(crate) use parts::of_small_angles;
use parts::{Part, b_of};

/// The coefficients of the Padé approximant of u₂ at s = 0, from the constants on. The error of T
/// is below 10⁻¹⁶ of it up to an angle of 4.
const U2: [[f64; 4]; 2] = [
    [
        0.000_520_833_333_333_333_3,
        -1.976_277_376_892_786e-6,
        1.406_828_457_026_933_2e-9,
        -8.594_808_182_442_149e-17,
    ],
    [
        1.0,
        -0.029_092_071_611_253_197,
        0.000_097_953_583_607_355_99,
        -6.754_809_644_035_987e-8,
    ],
];

/// The coefficients of the Padé approximant of `B₂ = (B − 1/12)/s` at s = 0. The error of A is
/// below 10⁻¹⁸ up to an angle of 4.
const B2: [[f64; 6]; 2] = [
    [
        0.001_388_888_888_888_889,
        -0.000_017_679_080_179_080_18,
        6.488_412_285_513_735e-8,
        -8.308_809_637_312_053e-11,
        3.062_365_338_829_446e-14,
        -9.897_754_811_989_16e-20,
    ],
    [
        1.0,
        -0.036_538_461_538_461_54,
        0.000_321_441_843_180_973_6,
        -9.953_814_301_640_39e-7,
        1.144_785_660_422_579e-9,
        -3.869_388_675_179_794e-13,
    ],
];

/// The functions A and B of the chart at an increment.
pub(crate) struct Momenta {
    x: Vec<Expr>,
    /// s.
    square: Expr,
    a: Expr,
    b: Expr,
}

/// The chart at an increment.
pub(crate) struct Chart {
    momenta: Momenta,
    u: Expr,
    t: Expr,
}

/// The middle of the geodesic between two rotations.
pub(crate) struct Midpoint {
    /// The entries of the matrix.
    pub(crate) entries: Vec<Expr>,
    /// T.
    pub(crate) quarter: Expr,
}

impl Momenta {
    /// Returns the functions for a body without a node, of which T is not needed: this is cheaper.
    pub(crate) fn new(x: &[Expr], arena: &mut Arena) -> Self {
        let square = square(x, arena);
        let b2 = Part::B2.named(quotient(&B2, square, arena), arena);
        let product = arena.mul(square, b2);
        let b = arena.sum(1.0 / 12.0, &[(1.0, product)]);
        let b = Part::BOfB2.named(b, arena);
        Self::of(x, square, b, arena)
    }

    fn of(x: &[Expr], square: Expr, b: Expr, arena: &mut Arena) -> Self {
        let product = arena.mul(square, b);
        let a = arena.sum(1.0, &[(-1.0, product)]);
        let a = arena.opaque(a);
        let x = x.to_vec();
        Self { x, square, a, b }
    }

    /// Returns `A g + ½ x × g + B x (x·g)`, the part of the momentum at the start that depends on
    /// the derivative g in the increment.
    pub(crate) fn at_start(&self, g: &[Expr], arena: &mut Arena) -> Vec<Expr> {
        let along = dot(&self.x, g, arena);
        let along = arena.mul(self.b, along);
        let along = arena.opaque(along);
        let across = cross(&self.x, g, arena);
        let momentum = (0..DIRECTIONS).map(|k| {
            let (own, along) = (arena.mul(self.a, g[k]), arena.mul(self.x[k], along));
            arena.sum(0.0, &[(1.0, own), (0.5, across[k]), (1.0, along)])
        });
        momentum.collect()
    }
}

impl Chart {
    pub(crate) fn new(x: &[Expr], arena: &mut Arena) -> Self {
        let square = square(x, arena);
        let u2 = Part::U2.named(quotient(&U2, square, arena), arena);
        let product = arena.mul(square, u2);
        let u = arena.sum(1.0 / 48.0, &[(1.0, product)]);
        let u = Part::U.named(u, arena);
        let product = arena.mul(square, u);
        let t = arena.sum(0.25, &[(0.25, product)]);
        let t = Part::T.named(t, arena);
        let b = b_of(t, u, arena);
        let momenta = Momenta::of(x, square, b, arena);
        Self { momenta, u, t }
    }

    /// Returns the functions A and B.
    pub(crate) fn momenta(&self) -> &Momenta {
        &self.momenta
    }

    /// Returns `sin(θ/2)/θ`, as `2T/(1 + T² s)`.
    fn half_sine(&self, arena: &mut Arena) -> Expr {
        let stretch = self.stretch(arena);
        let sine = arena.product(&[(self.t, 1), (stretch, -1)]);
        let sine = arena.scale(2.0, sine);
        Part::Sine.named(sine, arena)
    }

    /// Returns `1 + T² s`.
    fn stretch(&self, arena: &mut Arena) -> Expr {
        let r = arena.product(&[(self.t, 2), (self.momenta.square, 1)]);
        let stretch = arena.sum(1.0, &[(1.0, r)]);
        arena.opaque(stretch)
    }

    /// Returns the entries of the end `R₀ exp(x̂)`.
    pub(crate) fn end(&self, start: &[Expr], arena: &mut Arena) -> Vec<Expr> {
        let [k, _] = self.sines(arena);
        let curved = arena.scale(0.5, k);
        let versine = arena.mul(self.momenta.square, curved);
        let versine = arena.opaque(versine);
        let sine = arena.mul(k, self.momenta.a);
        let sine = arena.opaque(sine);
        self.turned(start, [sine, curved, versine], arena)
    }

    /// Returns the midpoint `R₀ exp(x̂/2)`.
    pub(crate) fn midpoint(&self, start: &[Expr], arena: &mut Arena) -> Midpoint {
        let sine = self.half_sine(arena);
        let curved = arena.mul(self.t, sine);
        let curved = arena.opaque(curved);
        let versine = arena.mul(self.momenta.square, curved);
        let versine = Part::Versine.named(versine, arena);
        Midpoint {
            entries: self.turned(start, [sine, curved, versine], arena),
            quarter: self.t,
        }
    }

    /// Returns the entries of R₀ times the rotation about x by an angle φ. A row a of R₀ becomes
    /// `a + sin φ/θ a × x + (1 − cos φ)/s ((a·x) x − s a)`; the functions are sin φ/θ, (1 − cos
    /// φ)/s and 1 − cos φ.
    fn turned(
        &self,
        start: &[Expr],
        [sine, curved, versine]: [Expr; 3],
        arena: &mut Arena,
    ) -> Vec<Expr> {
        let x = &self.momenta.x;
        let mut entries = vec![arena.constant(0.0); ENTRIES];
        for row in 0..3 {
            let a: Vec<Expr> = (0..3).map(|column| start[3 * column + row]).collect();
            let along = dot(&a, x, arena);
            let along = arena.mul(curved, along);
            let along = arena.opaque(along);
            let across = cross(&a, x, arena);
            for column in 0..3 {
                let parts = [
                    (1.0, arena.mul(along, x[column])),
                    (-1.0, arena.mul(versine, a[column])),
                    (1.0, arena.mul(sine, across[column])),
                ];
                let change = arena.sum(0.0, &parts);
                let change = arena.opaque(change);
                entries[3 * column + row] = arena.add(a[column], change);
            }
        }
        entries
    }

    /// Returns `K = 2 (1 − cos θ)/s`, as `(2 sin(θ/2)/θ)²`, and its root.
    fn sines(&self, arena: &mut Arena) -> [Expr; 2] {
        let sine = self.half_sine(arena);
        let root = arena.scale(2.0, sine);
        let k = arena.pow(root, 2);
        [arena.opaque(k), root]
    }

    /// Returns the matrix of the differential of the exponential, `(exp(x̂)ᵀ d exp(x̂))^∨ = D dx`:
    /// `sin θ/θ − (1 − cos θ)/s x̂ + (1 − sin θ/θ)/s x xᵀ`, by rows.
    pub(crate) fn differential(&self, arena: &mut Arena) -> [[Expr; 3]; 3] {
        let [k, root] = self.sines(arena);
        let own = arena.mul(k, self.momenta.a);
        // (1 − K A)/s = (T² − u)/(1 + T² s) (1 + √K) + K B
        let stretch = self.stretch(arena);
        let t2 = arena.pow(self.t, 2);
        let difference = arena.sub(t2, self.u);
        let sum = arena.sum(1.0, &[(1.0, root)]);
        let first = arena.product(&[(difference, 1), (sum, 1), (stretch, -1)]);
        let second = arena.mul(k, self.momenta.b);
        let along = arena.sum(0.0, &[(1.0, first), (1.0, second)]);
        let along = arena.opaque(along);
        self.matrix(arena, |unit, across, product, row, arena| {
            let own = arena.mul(own, unit);
            let across = arena.mul(k, across);
            let product = arena.product(&[(product, 1), (self.momenta.x[row], 1), (along, 1)]);
            arena.sum(0.0, &[(1.0, own), (-0.5, across), (1.0, product)])
        })
    }

    /// Returns exp(x̂)ᵀ, by rows: the image of a direction at R₀ in the frame of R₁ = R₀ exp(x̂).
    pub(crate) fn transposed(&self, arena: &mut Arena) -> [[Expr; 3]; 3] {
        let [k, _] = self.sines(arena);
        let sine = arena.mul(k, self.momenta.a);
        self.matrix(arena, |unit, across, product, row, arena| {
            // x̂² = x xᵀ − s
            let along = arena.mul(product, self.momenta.x[row]);
            let own = arena.mul(self.momenta.square, unit);
            let twice = arena.sub(along, own);
            let (once, twice) = (arena.mul(sine, across), arena.mul(k, twice));
            arena.sum(0.0, &[(1.0, unit), (-1.0, once), (0.5, twice)])
        })
    }

    /// Returns a matrix by rows. `entry` gets, for a unit vector e, a row of e, of x × e, and x·e.
    fn matrix(
        &self,
        arena: &mut Arena,
        entry: impl Fn(Expr, Expr, Expr, usize, &mut Arena) -> Expr,
    ) -> [[Expr; 3]; 3] {
        let [zero, one] = [0.0, 1.0].map(|number| arena.constant(number));
        let mut matrix = [[zero; 3]; 3];
        for column in 0..3 {
            let mut unit = [zero; 3];
            unit[column] = one;
            let across = cross(&self.momenta.x, &unit, arena);
            for row in 0..3 {
                matrix[row][column] =
                    entry(unit[row], across[row], self.momenta.x[column], row, arena);
            }
        }
        matrix
    }
}

/// Returns a·b.
fn dot(a: &[Expr], b: &[Expr], arena: &mut Arena) -> Expr {
    let products = a.iter().zip(b).map(|(&a, &b)| (1.0, arena.mul(a, b)));
    let products: Vec<(f64, Expr)> = products.collect();
    arena.sum(0.0, &products)
}

/// Returns |x|².
fn square(x: &[Expr], arena: &mut Arena) -> Expr {
    let squares: Vec<(f64, Expr)> = x.iter().map(|&x| (1.0, arena.pow(x, 2))).collect();
    let square = arena.sum(0.0, &squares);
    Part::Square.named(square, arena)
}

/// Returns the quotient of two polynomials.
fn quotient<const N: usize>(polynomials: &[[f64; N]; 2], x: Expr, arena: &mut Arena) -> Expr {
    let [dividend, divisor] = [0, 1].map(|k| polynomial(&polynomials[k], x, arena));
    arena.product(&[(dividend, 1), (divisor, -1)])
}

/// Returns a polynomial by Estrin's rule, whose operations depend on fewer ones before them than
/// those of Horner's.
fn polynomial(coefficients: &[f64], x: Expr, arena: &mut Arena) -> Expr {
    let mut parts: Vec<Expr> = coefficients.iter().map(|&c| arena.constant(c)).collect();
    let mut power = x;
    while parts.len() > 1 {
        let pairs = parts.chunks(2).map(|pair| match *pair {
            [low, high] => {
                let product = arena.mul(high, power);
                let sum = arena.add(low, product);
                arena.opaque(sum)
            }
            _ => pair[0],
        });
        parts = pairs.collect();
        let square = arena.pow(power, 2);
        power = arena.opaque(square);
    }
    parts[0]
}
