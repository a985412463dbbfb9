//! Whether an expression vanishes identically, decided by evaluation at random points.
//!
//! Input: an expression; output: true if at every point where it is defined its value is within a running bound of the
//! rounding errors of its evaluation. Where a function underflows or has saturated, a point tells nothing and another one is
//! taken. The points are fixed, so the answer is the same in every build.

use super::Map;
use super::expr::{Arena, Expr, Function, Node, Symbol};

/// Points at which an identity has to hold.
const POINTS: usize = 6;

/// Points tried before an expression is called nowhere defined, and so not zero: first those near 1 …
const ATTEMPTS: u64 = 40 + SCALES.len() as u64 * TIMES;

/// … then, where those tell nothing, points of other scales: `exp(−(q/1e−6)²)` and `1 − cos(1e−9 q)` vanish to rounding near 1.
const SCALES: [f64; 10] = [1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9, 1e-12, 1e12, 1e-15, 1e15];

/// Points tried of each other scale.
const TIMES: u64 = 16;

/// Relative change of a function, for such a change of its argument, below which the value tells nothing of the argument:
/// tanh of 20 is 1, and exp of −1000 is 0.
const FLAT: f64 = 1e-9;

/// The running bound is of first order; this leaves room for the second.
const SLACK: f64 = 64.0;

/// A value with a bound of its error.
#[derive(Clone, Copy)]
struct Rounded {
    value: f64,
    error: f64,
}

impl Arena {
    /// Whether `expr` is zero wherever it is defined.
    pub(crate) fn is_zero(&self, expr: Expr) -> bool {
        if let Some(value) = self.constant_value(expr) {
            return value == 0.0;
        }
        if self.is_exhausted() {
            return true;
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
                return false;
            }
            held += 1;
            if held == POINTS {
                return true;
            }
        }
        false
    }

    /// Which of `exprs` are zero: as [`is_zero`](Self::is_zero), with what they share evaluated once at the point that tells most
    /// of them from zero.
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

    /// The values of `exprs` at random points where all of them are defined; what is within its rounding error is zero.
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

    /// The value of `expr` at a point.
    #[cfg(test)]
    pub(crate) fn evaluate(&self, expr: Expr, at: impl Fn(Symbol) -> f64) -> f64 {
        self.evaluate_nodes(&self.reachable(&[expr], |_| true), at)[&expr].value
    }

    fn evaluate_bounded(&self, nodes: &[Expr], attempt: u64) -> Map<Expr, Rounded> {
        self.evaluate_nodes(nodes, |symbol| {
            let unit = uniform(attempt, u64::from(symbol.0));
            let near_one = ATTEMPTS - SCALES.len() as u64 * TIMES;
            let scale = match attempt.checked_sub(near_one) {
                None => 1.0,
                Some(later) => SCALES[(later / TIMES) as usize],
            };
            // near and inside the unit interval first, where most functions are defined; then of either sign
            scale
                * if attempt.is_multiple_of(2) {
                    0.1 + 0.8 * unit
                } else {
                    4.0 * unit - 2.0
                }
        })
    }

    fn evaluate_nodes(&self, nodes: &[Expr], at: impl Fn(Symbol) -> f64) -> Map<Expr, Rounded> {
        self.spend(4 * nodes.len());
        let mut values: Map<Expr, Rounded> = Map::default();
        values.reserve(nodes.len());
        for &e in nodes {
            let (value, inherited) = match self.node(e) {
                Node::Constant(bits) => (bits.get(), 0.0),
                Node::Symbol(symbol) => (at(*symbol), 0.0),
                Node::Opaque(x) => (values[x].value, values[x].error),
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
                    let (value, slope) = (function.evaluate(x.value), function.slope(x.value));
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

/// An error without a bound, where a value has lost what it should tell.
fn unknown(is_lost: bool) -> f64 {
    if is_lost { f64::NAN } else { 0.0 }
}

impl Function {
    /// `|f′(x)|` by a difference: good to a few digits, which is all that an error bound needs.
    fn slope(self, x: f64) -> f64 {
        let dx = 1e-6 * x.abs().max(1e-3);
        ((self.evaluate(x + dx) - self.evaluate(x - dx)) / (2.0 * dx)).abs()
    }
}

/// A number in [0, 1) for an attempt and a symbol: the finaliser of splitmix64 (Steele, Lea, Flood 2014).
fn uniform(attempt: u64, symbol: u64) -> f64 {
    let mut z = attempt
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(symbol.wrapping_add(1).wrapping_mul(0xd1b5_4a32_d192_ed03));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 53) as f64
}
