//! Whether an expression vanishes identically.
//!
//! Input: an expression. Output: how it is known to vanish, or that it does not. The algebra
//! answers where it leaves the constant 0. Otherwise the expression is evaluated at random points
//! near 1 and of other scales, with a running bound of the rounding errors. Plain `f64` finds most
//! expressions that do not vanish; only what it takes for zero is evaluated again in 106 bits
//! (`sharp`). Where a function underflows or has saturated, a point tells nothing and another point
//! is taken. The points are fixed, so the answer is the same in every build.

use super::Map;
use super::expr::{Arena, Expr, Function, Node, Symbol};
use super::sharp::{Sharp, Verdict};

/// How an expression is known to vanish, the surest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Vanishing {
    /// The algebra leaves the constant 0: a proof.
    Proved,
    /// Zero to some 28 digits of the sum of the magnitudes of its terms at all points. A term that
    /// is smaller than that at all points is not seen.
    Evaluated,
    /// No larger than the rounding of the constants in it allows at all points: whether it vanishes
    /// cannot be decided.
    Undecided,
}

/// Points near 1 at which an identity has to hold.
const POINTS: usize = 6;

/// Points tried before an expression is called nowhere defined, and so not zero: first those near
/// 1 …
const ATTEMPTS: u64 = NEAR_ONE + SCALES.len() as u64 * TIMES;

/// Points tried near 1.
const NEAR_ONE: u64 = 40;

/// … then, where those tell nothing, points of other scales: `exp(−(q/1e−6)²)` and
/// `1 − cos(1e−9 q)` vanish to rounding near 1.
const SCALES: [f64; 10] = [1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9, 1e-12, 1e12, 1e-15, 1e15];

/// Points tried of each other scale.
const TIMES: u64 = 16;

/// Points at which each symbol has a scale of its own, for terms that are small beside the others
/// unless one of them grows.
const MIXED: u64 = 6;

/// The scales among which a symbol of such a point has its own.
const MIXED_SCALES: [f64; 5] = [1.0, 1e-3, 1e3, 1e-6, 1e6];

/// Relative change of a function, for such a change of its argument, below which the value tells
/// nothing of the argument: tanh of 20 is 1, and exp of −1000 is 0.
const FLAT: f64 = 1e-9;

/// Products of a few numbers of this size are far from underflow.
const MODERATE: f64 = 1e-60;

/// The running bound is of first order; this leaves room for the second.
const SLACK: f64 = 64.0;

/// A value with a bound of its error.
#[derive(Clone, Copy)]
struct Rounded {
    value: f64,
    error: f64,
}

impl Arena {
    /// Whether `expr` is zero wherever it is defined, as far as that can be known.
    pub(crate) fn is_zero(&self, expr: Expr) -> bool {
        self.vanishing(expr).is_some()
    }

    /// How `expr` is known to be zero wherever it is defined; nothing where it is not zero.
    pub(crate) fn vanishing(&self, expr: Expr) -> Option<Vanishing> {
        let found = self.vanishing_as_it_is(expr)?;
        Some(if self.has_lost_constants() {
            Vanishing::Undecided
        } else {
            found
        })
    }

    /// Whether folding has lost a constant, so that what is left may be another expression than
    /// what was written.
    pub(crate) fn has_lost_constants(&self) -> bool {
        self.has_lost_constants.get()
    }

    fn vanishing_as_it_is(&self, expr: Expr) -> Option<Vanishing> {
        if let Some(value) = self.constant_value(expr) {
            return (value == 0.0).then_some(Vanishing::Proved);
        }
        if self.is_exhausted() {
            return Some(Vanishing::Proved);
        }
        let nodes = self.reachable(&[expr], |_| true);
        let mut held = 0;
        for attempt in 0..ATTEMPTS {
            let at = self.evaluate_bounded(&nodes, attempt);
            let Rounded { value, error } = at[&expr];
            if !(value.is_finite() && error.is_finite()) {
                continue;
            }
            if value.abs() > SLACK * error {
                return None;
            }
            held += 1;
            if held == POINTS {
                break;
            }
        }
        match self.vanishing_sharply(&nodes, expr) {
            Ok(vanishing) => Some(vanishing),
            // no digits anywhere: what the plain numbers say
            Err(Verdict::Nothing) => (held > 0).then_some(Vanishing::Undecided),
            Err(_) => None,
        }
    }

    /// The same in 106 bits; the verdict where that is another one.
    fn vanishing_sharply(&self, nodes: &[Expr], expr: Expr) -> Result<Vanishing, Verdict> {
        let mut found = None;
        let mut held = 0;
        for attempt in sharp_attempts() {
            if held >= POINTS && attempt < NEAR_ONE {
                continue;
            }
            let at = self.evaluate_sharp(nodes, |symbol| coordinate(attempt, symbol));
            let vanishing = match at.get(&expr).map_or(Verdict::Nothing, |x| x.verdict()) {
                Verdict::Nothing => continue,
                Verdict::NotZero => return Err(Verdict::NotZero),
                Verdict::Zero => Vanishing::Evaluated,
                Verdict::Undecided => Vanishing::Undecided,
            };
            found = found.max(Some(vanishing));
            held += 1;
        }
        found.ok_or(Verdict::Nothing)
    }

    /// Which of `exprs` are zero: as [`is_zero`](Self::is_zero), with what they share evaluated
    /// once at the point that tells most of them from zero.
    pub(crate) fn zeros(&self, exprs: &[Expr]) -> Vec<bool> {
        if self.is_exhausted() {
            return vec![true; exprs.len()];
        }
        let first = self.evaluate_bounded(&self.reachable(exprs, |_| true), 0);
        let is_zero = |e: &Expr| {
            let Rounded { value, error } = first[e];
            let differs = value.is_finite() && error.is_finite() && value.abs() > SLACK * error;
            !differs && self.is_zero(*e)
        };
        exprs.iter().map(is_zero).collect()
    }

    /// The values of `exprs` at random points where all of them are defined; what is within its
    /// rounding error is zero.
    pub(crate) fn samples<'a>(&'a self, exprs: &'a [Expr]) -> impl Iterator<Item = Vec<f64>> + 'a {
        let nodes = self.reachable(exprs, |_| true);
        let attempts = if self.is_exhausted() { 0 } else { ATTEMPTS };
        let defined = move |attempt| {
            let at = self.evaluate_bounded(&nodes, attempt);
            let value = |e: &Expr| {
                let Rounded { value, error } = at[e];
                let known = value.is_finite() && error.is_finite();
                known.then_some(if value.abs() > SLACK * error {
                    value
                } else {
                    0.0
                })
            };
            exprs.iter().map(value).collect::<Option<Vec<f64>>>()
        };
        (0..attempts).filter_map(defined).take(POINTS)
    }

    /// The same in 106 bits, with their bounds.
    pub(crate) fn sharp_samples<'a>(
        &'a self,
        exprs: &'a [Expr],
    ) -> impl Iterator<Item = Vec<Sharp>> + 'a {
        let nodes = self.reachable(exprs, |_| true);
        let attempts = if self.is_exhausted() { 0 } else { ATTEMPTS };
        let defined = move |attempt| {
            let at = self.evaluate_sharp(&nodes, |symbol| coordinate(attempt, symbol));
            let value = |e: &Expr| Some(at[e]).filter(|x| x.verdict() != Verdict::Nothing);
            exprs.iter().map(value).collect::<Option<Vec<Sharp>>>()
        };
        (0..attempts).filter_map(defined).take(POINTS)
    }

    /// A power of two that brings the largest of `exprs` to the order of 1 at a random point; 1
    /// where they are not so large or small that a product of two of them is out of range.
    pub(crate) fn scale_of(&self, exprs: &[Expr]) -> f64 {
        let largest = |point: Vec<f64>| point.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let size = self.samples(exprs).map(largest).next().unwrap_or(1.0);
        if size == 0.0 || (MODERATE..1.0 / MODERATE).contains(&size) {
            1.0
        } else {
            2.0f64.powi(-size.log2().round() as i32)
        }
    }

    /// The values of expressions at a point.
    pub(crate) fn values(&self, exprs: &[Expr], at: impl Fn(Symbol) -> f64) -> Vec<f64> {
        let values = self.evaluate_nodes(&self.reachable(exprs, |_| true), at);
        exprs.iter().map(|e| values[e].value).collect()
    }

    /// The value of `expr` at a point.
    #[cfg(test)]
    pub(crate) fn evaluate(&self, expr: Expr, at: impl Fn(Symbol) -> f64) -> f64 {
        self.evaluate_nodes(&self.reachable(&[expr], |_| true), at)[&expr].value
    }

    fn evaluate_bounded(&self, nodes: &[Expr], attempt: u64) -> Map<Expr, Rounded> {
        self.evaluate_nodes(nodes, |symbol| coordinate(attempt, symbol))
    }

    fn evaluate_nodes(&self, nodes: &[Expr], at: impl Fn(Symbol) -> f64) -> Map<Expr, Rounded> {
        self.spend(4 * nodes.len());
        let mut values: Map<Expr, Rounded> = Map::default();
        values.reserve(nodes.len());
        for &e in nodes {
            let (value, inherited) = match self.node(e) {
                Node::Constant(bits) => (bits.get(), 0.0),
                Node::Symbol(symbol) => (at(*symbol), 0.0),
                Node::Opaque(x, _) => (values[x].value, values[x].error),
                Node::Sum(constant, terms) => {
                    let (mut sum, mut error, mut size) =
                        (constant.get(), 0.0, constant.get().abs());
                    for (x, c) in terms {
                        let x = values[x];
                        sum += c.get() * x.value;
                        size += (c.get() * x.value).abs();
                        error += c.get().abs() * x.error;
                    }
                    (sum, error + f64::EPSILON * size)
                }
                Node::Product(factors) => {
                    let (mut product, mut relative) = (1.0, 0.0);
                    for (x, k) in factors {
                        let x = values[x];
                        product *= x.value.powi(*k);
                        if x.value != 0.0 {
                            relative +=
                                f64::from(k.abs()) * (f64::EPSILON + x.error / x.value.abs());
                        } else if x.error.is_nan() {
                            relative = f64::NAN;
                        }
                    }
                    let underflows =
                        product == 0.0 && factors.iter().all(|f| values[&f.0].value != 0.0);
                    (product, relative * product.abs() + unknown(underflows))
                }
                Node::Call(function, x) => {
                    let x = values[x];
                    let (value, slope) = (
                        function.evaluate(x.value),
                        function.difference_quotient(x.value),
                    );
                    let flat = slope * x.value.abs() <= FLAT * value.abs() && x.value != 0.0;
                    (value, slope * x.error + unknown(flat))
                }
                Node::Call2(function, x, y) => {
                    let (x, y) = (values[x], values[y]);
                    let value = function.evaluate(x.value, y.value);
                    let dx = function.evaluate(x.value + x.error, y.value) - value;
                    let dy = function.evaluate(x.value, y.value + y.error) - value;
                    let underflows = value == 0.0 && x.value != 0.0 && y.value != 0.0;
                    (value, dx.abs() + dy.abs() + unknown(underflows))
                }
            };
            let has_digits = value == 0.0 || value.abs() >= f64::MIN_POSITIVE;
            let error = inherited + f64::EPSILON * value.abs() + unknown(!has_digits);
            values.insert(e, Rounded { value, error });
        }
        values
    }
}

/// The attempts of an evaluation in 106 bits: points near 1, two of each other scale, and those of
/// mixed scales.
fn sharp_attempts() -> impl Iterator<Item = u64> {
    let scales = (NEAR_ONE..ATTEMPTS).filter(|attempt| (attempt - NEAR_ONE) % TIMES < 2);
    (0..NEAR_ONE)
        .chain(scales)
        .chain(ATTEMPTS..ATTEMPTS + MIXED)
}

/// A coordinate of a random point: near and inside the unit interval first, where most functions
/// are defined, then of either sign; after [`NEAR_ONE`] attempts of other scales.
pub(crate) fn coordinate(attempt: u64, symbol: Symbol) -> f64 {
    let unit = uniform(attempt, u64::from(symbol.0));
    let scale = match attempt.checked_sub(NEAR_ONE) {
        None => 1.0,
        Some(later) if attempt < ATTEMPTS => SCALES[(later / TIMES) as usize],
        Some(later) => {
            let choice = uniform(later, u64::from(symbol.0) ^ 0x5eed);
            let chosen = MIXED_SCALES.iter().zip(1..);
            chosen
                .filter(|&(_, up_to)| 5.0 * choice < f64::from(up_to))
                .map(|(scale, _)| *scale)
                .next()
                .unwrap_or(1.0)
        }
    };
    let near = if attempt.is_multiple_of(2) {
        0.1 + 0.8 * unit
    } else {
        4.0 * unit - 2.0
    };
    scale * near
}

/// An error without a bound, where a value has lost what it should tell.
fn unknown(is_lost: bool) -> f64 {
    if is_lost { f64::NAN } else { 0.0 }
}

impl Function {
    /// `|f′(x)|` by a difference: good to a few digits, which is all that an error bound needs.
    fn difference_quotient(self, x: f64) -> f64 {
        let dx = 1e-6 * x.abs().max(1e-3);
        ((self.evaluate(x + dx) - self.evaluate(x - dx)) / (2.0 * dx)).abs()
    }
}

/// A number in [0, 1) for an attempt and a symbol: the finaliser of splitmix64 (Steele, Lea, Flood
/// 2014).
fn uniform(attempt: u64, symbol: u64) -> f64 {
    let mut z = attempt
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(symbol.wrapping_add(1).wrapping_mul(0xd1b5_4a32_d192_ed03));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 53) as f64
}
