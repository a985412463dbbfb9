//! The test whether an expression vanishes identically.
//!
//! Input: an expression. Output: the reason why it is taken for zero, or `None` if it does not
//! vanish. The algebra decides if it leaves the constant 0. Otherwise the expression is evaluated
//! at random points near 1 and of other scales, with a running bound of the rounding errors. Plain
//! `f64` recognises most expressions that do not vanish; an expression that it takes for zero is
//! evaluated again in 106 bits (`sharp`). If a function underflows or has saturated at a point, the
//! point is replaced by another one. The points are fixed, so the answer is the same in every
//! build.

use super::Map;
use super::expr::{Arena, Expr, Function, Node, Symbol};
use super::sharp::{Sharp, Verdict};

/// The reason why an expression is taken for zero, the most certain first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Vanishing {
    /// The algebra leaves the constant 0: a proof.
    Proved,
    /// Zero to some 28 digits of the sum of the magnitudes of its terms, at all points. A term that
    /// is smaller than this at all points goes unnoticed.
    Evaluated,
    /// Not larger, at any point, than the rounding of its constants can explain. Whether the
    /// expression vanishes cannot be decided.
    Undecided,
}

/// Points near 1 at which an identity has to hold.
const POINTS: usize = 6;

/// Points tried before an expression counts as nowhere defined, and so not as zero. The points near
/// 1 come first.
const ATTEMPTS: u64 = NEAR_ONE + SCALES.len() as u64 * TIMES;

/// Points tried near 1.
const NEAR_ONE: u64 = 40;

/// Scales of the points tried if the points near 1 tell nothing: `exp(−(q/1e−6)²)` and
/// `1 − cos(1e−9 q)` vanish to rounding near 1.
const SCALES: [f64; 10] = [1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9, 1e-12, 1e12, 1e-15, 1e15];

/// Points tried at each of these scales.
const TIMES: u64 = 16;

/// Points at which each symbol has a scale of its own, for terms that are small beside the others
/// unless one symbol grows.
const MIXED: u64 = 6;

/// Scales of the symbols at such a point.
const MIXED_SCALES: [f64; 5] = [1.0, 1e-3, 1e3, 1e-6, 1e6];

/// Relative slope below which a value has lost the information of its argument: tanh of 20 is 1,
/// and exp of −1000 is 0.
const FLAT: f64 = 1e-9;

/// Magnitude above which a product of a few numbers is far from underflow.
const MODERATE: f64 = 1e-60;

/// Factor on the running bound, which is of first order; it leaves room for the second order.
const SLACK: f64 = 64.0;

/// A value with a bound of its rounding error.
#[derive(Clone, Copy)]
struct Rounded {
    value: f64,
    error: f64,
}

impl Arena {
    /// Returns whether `expr` is zero wherever it is defined, as far as this can be known.
    pub(crate) fn is_zero(&self, expr: Expr) -> bool {
        self.vanishing(expr).is_some()
    }

    /// Returns the reason why `expr` is taken for zero wherever it is defined; `None` if it is not
    /// zero.
    pub(crate) fn vanishing(&self, expr: Expr) -> Option<Vanishing> {
        let found = self.vanishing_as_it_is(expr)?;
        Some(if self.has_lost_constants() {
            Vanishing::Undecided
        } else {
            found
        })
    }

    /// Returns whether folding has lost a constant. If so, the remaining expression may differ from
    /// the one that was written.
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
            // without digits at any point, the evaluation in `f64` decides
            Err(Verdict::Nothing) => (held > 0).then_some(Vanishing::Undecided),
            Err(_) => None,
        }
    }

    /// Repeats the test in 106 bits. Returns the verdict as an error if the expression is not taken
    /// for zero.
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

    /// Returns, for each of `exprs`, whether it is zero; see [`is_zero`](Self::is_zero). Shared
    /// subexpressions are evaluated once, at a first point that already recognises most nonzero
    /// expressions.
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

    /// Returns the values of `exprs` at random points where all of them are defined. A value below
    /// its rounding error is replaced by zero.
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

    /// Returns the values of `exprs` at random points in 106 bits, with their bounds.
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

    /// Returns a power of two that scales the largest of `exprs` to the order of 1 at a random
    /// point. Returns 1 if a product of two of them is in range anyway.
    pub(crate) fn scale_of(&self, exprs: &[Expr]) -> f64 {
        let largest = |point: Vec<f64>| point.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let size = self.samples(exprs).map(largest).next().unwrap_or(1.0);
        if size == 0.0 || (MODERATE..1.0 / MODERATE).contains(&size) {
            1.0
        } else {
            2.0f64.powi(-size.log2().round() as i32)
        }
    }

    /// Returns the values of expressions at a point.
    pub(crate) fn values(&self, exprs: &[Expr], at: impl Fn(Symbol) -> f64) -> Vec<f64> {
        let values = self.evaluate_nodes(&self.reachable(exprs, |_| true), at);
        exprs.iter().map(|e| values[e].value).collect()
    }

    /// Returns the value of `expr` at a point.
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

/// Returns the numbers of the points for an evaluation in 106 bits: points near 1, two of each
/// other scale, and points of mixed scales.
fn sharp_attempts() -> impl Iterator<Item = u64> {
    let scales = (NEAR_ONE..ATTEMPTS).filter(|attempt| (attempt - NEAR_ONE) % TIMES < 2);
    (0..NEAR_ONE)
        .chain(scales)
        .chain(ATTEMPTS..ATTEMPTS + MIXED)
}

/// Returns a coordinate of a random point. The first attempts lie near and inside the unit
/// interval, where most functions are defined, the next ones have either sign, and attempts after
/// [`NEAR_ONE`] have other scales.
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

/// Returns an unbounded error if the value has lost the information of its argument.
fn unknown(is_lost: bool) -> f64 {
    if is_lost { f64::NAN } else { 0.0 }
}

impl Function {
    /// Returns `|f′(x)|` by a difference quotient. It is good to a few digits, which suffices for
    /// an error bound.
    fn difference_quotient(self, x: f64) -> f64 {
        let dx = 1e-6 * x.abs().max(1e-3);
        ((self.evaluate(x + dx) - self.evaluate(x - dx)) / (2.0 * dx)).abs()
    }
}

/// Returns a number in [0, 1) for an attempt and a symbol, by the finaliser of splitmix64 (Steele,
/// Lea, Flood 2014).
fn uniform(attempt: u64, symbol: u64) -> f64 {
    let mut z = attempt
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(symbol.wrapping_add(1).wrapping_mul(0xd1b5_4a32_d192_ed03));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 53) as f64
}
