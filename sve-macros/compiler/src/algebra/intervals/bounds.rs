//! Interval arithmetic on expressions, in the form of midpoint and radius.

use std::collections::HashMap;

use super::{BOX, EXPONENT, Flavour, Range};
use crate::algebra::{Arena, Binary, BinaryBound, Bound, Expr, Function, Map, Node, Symbol};

/// The values within `radius` of `mid`.
#[derive(Clone, Copy)]
pub(super) struct Interval {
    pub(super) mid: Expr,
    pub(super) radius: Expr,
    /// The end of the range, if the values go from 0 to it.
    pub(super) end: Option<Expr>,
}

pub(super) struct Bounds<'a> {
    pub(super) arena: &'a mut Arena,
    ranges: &'a HashMap<Symbol, Range>,
    flavour: Flavour,
    done: Map<Expr, Interval>,
    pub(super) conditions: Vec<Expr>,
}

impl<'a> Bounds<'a> {
    /// Creates an empty set of bounds.
    pub(super) fn new(
        ranges: &'a HashMap<Symbol, Range>,
        flavour: Flavour,
        arena: &'a mut Arena,
    ) -> Self {
        Self {
            arena,
            ranges,
            flavour,
            done: Map::default(),
            conditions: Vec::new(),
        }
    }

    pub(super) fn all(&mut self, roots: &[Expr]) -> Option<Vec<Interval>> {
        for e in self.arena.reachable(roots, |_| true) {
            let interval = self.of(e)?;
            self.done.insert(e, interval);
        }
        roots.iter().map(|e| self.done.get(e).copied()).collect()
    }

    fn of(&mut self, e: Expr) -> Option<Interval> {
        if !self.ranges.keys().any(|&s| self.arena.contains(e, s)) {
            return Some(self.exact(e));
        }
        match self.arena.node(e).clone() {
            Node::Constant(_) => Some(self.exact(e)),
            Node::Symbol(symbol) => Some(self.symbol(e, symbol)),
            Node::Opaque(x, identity) => {
                let inner = self.done[&x];
                let mid = if inner.mid == x {
                    e
                } else {
                    self.arena.intermediate(inner.mid, identity)
                };
                Some(Interval { mid, ..inner })
            }
            Node::Sum(constant, terms) => {
                let parts: Vec<(f64, Interval)> =
                    terms.iter().map(|(x, c)| (c.get(), self.done[x])).collect();
                let mids: Vec<_> = parts.iter().map(|(c, i)| (*c, i.mid)).collect();
                let radii: Vec<_> = parts.iter().map(|(c, i)| (c.abs(), i.radius)).collect();
                let end = match parts.as_slice() {
                    [(c, Interval { end: Some(end), .. })] if constant.get() == 0.0 => {
                        Some(self.arena.scale(*c, *end))
                    }
                    _ => None,
                };
                Some(Interval {
                    mid: self.arena.sum(constant.get(), &mids),
                    radius: self.arena.sum(0.0, &radii),
                    end,
                })
            }
            Node::Product(factors) => self.product(&factors),
            Node::Call(function, x) => self.call(function, x, e),
            Node::Call2(function, x, y) => self.call2(function, x, y),
        }
    }

    fn exact(&mut self, mid: Expr) -> Interval {
        around(mid, self.arena.constant(0.0))
    }

    fn symbol(&mut self, e: Expr, symbol: Symbol) -> Interval {
        match self.ranges.get(&symbol) {
            None => self.exact(e),
            Some(Range::Small) => self.up_to(e),
            Some(&Range::Around { limit, reach }) => around(self.arena.symbol(limit), reach),
            Some(&Range::Within(radius)) => around(e, self.arena.symbol(radius)),
            Some(&Range::Unknown { limit, moved }) => {
                let limit = self.arena.symbol(limit);
                let distance = self.arena.sub(e, limit);
                let distance = self.arena.abs(distance);
                let (mid, width) = if self.flavour == Flavour::Limit {
                    (limit, 0.5 + BOX)
                } else {
                    (self.arena.sum(0.0, &[(0.5, e), (0.5, limit)]), BOX)
                };
                let radius = self.arena.sum(0.0, &[(width, distance), (1.0, moved)]);
                around(mid, radius)
            }
        }
    }

    /// Returns the interval from 0 to `end`.
    fn up_to(&mut self, end: Expr) -> Interval {
        let (mid, half) = if self.flavour == Flavour::Limit {
            (self.arena.constant(0.0), end)
        } else {
            let half = self.arena.scale(0.5, end);
            (half, half)
        };
        Interval {
            mid,
            radius: self.arena.abs(half),
            end: Some(end),
        }
    }

    /// Bounds `Π base^exponent`. The factors that go from 0 to an end are proportional to the same
    /// small quantity, so they reach their ends together; the other factors are bounded
    /// independently.
    fn product(&mut self, factors: &[(Expr, i32)]) -> Option<Interval> {
        let one = self.arena.constant(1.0);
        let zero = self.arena.constant(0.0);
        let (mut scale, mut product) = (one, around(one, zero));
        let mut from_zero = false;
        if self.flavour == Flavour::Limit && factors.iter().any(|f| self.is_from_zero(*f)) {
            return Some(self.size(factors));
        }
        for &(base, k) in factors {
            let factor = self.done[&base];
            if let (Some(end), 1..) = (factor.end, k) {
                let power = self.arena.pow(end, k);
                scale = self.arena.mul(scale, power);
                from_zero = true;
            } else if factor.radius == zero {
                let power = self.arena.pow(factor.mid, k);
                scale = self.arena.mul(scale, power);
            } else if k.unsigned_abs() > EXPONENT {
                return None;
            } else if k < 0 {
                let factor = self.inverse_power(factor, k);
                product = self.times(product, factor);
            } else {
                for _ in 0..k {
                    product = self.times(product, factor);
                }
            }
        }
        if from_zero && product.radius == zero {
            // the product is 1
            return Some(self.up_to(scale));
        }
        let size = self.arena.abs(scale);
        let mid = self.arena.mul(scale, product.mid);
        if !from_zero {
            return Some(around(mid, self.arena.mul(size, product.radius)));
        }
        // s m with s from 0 to 1: the midpoint is half of the end
        let half = self.arena.abs(product.mid);
        let radius = self.arena.sum(0.0, &[(0.5, half), (1.0, product.radius)]);
        Some(around(
            self.arena.scale(0.5, mid),
            self.arena.mul(size, radius),
        ))
    }

    fn is_from_zero(&self, (base, k): (Expr, i32)) -> bool {
        k > 0 && self.done[&base].end.is_some()
    }

    /// Bounds a product with a factor that goes from 0 to its end, by the product of the largest
    /// magnitudes.
    fn size(&mut self, factors: &[(Expr, i32)]) -> Interval {
        let one = self.arena.constant(1.0);
        let (mut size, mut end) = (one, Some(one));
        for &(base, k) in factors {
            let factor = self.done[&base];
            let is_wave = matches!(
                self.arena.node(base),
                Node::Call(function, _) if function.entry().bound == Bound::Wave
            );
            let largest = match factor.end {
                Some(end) if k > 0 => self.arena.abs(end),
                _ if is_wave && k > 0 => one,
                _ if k > 0 => {
                    let middle = self.arena.abs(factor.mid);
                    self.arena.add(middle, factor.radius)
                }
                _ => {
                    let middle = self.arena.abs(factor.mid);
                    self.positive(middle, factor.radius)
                }
            };
            let power = self.arena.pow(largest, k);
            size = self.arena.mul(size, power);
            let exact = self.arena.constant(0.0) == factor.radius;
            end = match (end, factor.end) {
                (Some(product), Some(end)) if k > 0 => {
                    let power = self.arena.pow(end, k);
                    Some(self.arena.mul(product, power))
                }
                (Some(product), None) if exact => {
                    let power = self.arena.pow(factor.mid, k);
                    Some(self.arena.mul(product, power))
                }
                _ => None,
            };
        }
        Interval {
            mid: self.arena.constant(0.0),
            radius: size,
            end,
        }
    }

    fn times(&mut self, a: Interval, b: Interval) -> Interval {
        let (size_a, size_b) = (self.arena.abs(a.mid), self.arena.abs(b.mid));
        let terms = [(size_a, b.radius), (a.radius, size_b), (a.radius, b.radius)];
        let terms = terms.map(|(x, y)| (1.0, self.arena.mul(x, y)));
        around(self.arena.mul(a.mid, b.mid), self.arena.sum(0.0, &terms))
    }

    /// Bounds `x^k` with a negative k. With `ε = r/|x|`, Bernoulli's inequality bounds the relative
    /// change: `(1 − ε)^k − 1 ≤ |k|ε / (1 − |k|ε)`.
    fn inverse_power(&mut self, x: Interval, k: i32) -> Interval {
        let mid = self.arena.pow(x.mid, k);
        let times = self.arena.scale(f64::from(k.abs()), x.radius);
        let distance = self.arena.abs(x.mid);
        let left = self.positive(distance, times);
        let size = self.arena.abs(mid);
        around(
            mid,
            self.arena.product(&[(size, 1), (times, 1), (left, -1)]),
        )
    }

    /// Returns `size − radius`, and records the condition that it is positive.
    pub(super) fn positive(&mut self, size: Expr, radius: Expr) -> Expr {
        let left = self.arena.sub(size, radius);
        self.conditions.push(left);
        left
    }

    /// Bounds a function of one argument by its largest slope near the midpoint.
    fn call(&mut self, function: Function, x: Expr, e: Expr) -> Option<Interval> {
        let Interval {
            mid: x_mid,
            radius: r,
            ..
        } = self.done[&x];
        let mid = if x_mid == x {
            e
        } else {
            self.arena.call(function, x_mid)
        };
        let radius = match function.entry().bound {
            Bound::Wave if self.flavour == Flavour::Global => {
                return Some(around(self.arena.constant(0.0), self.arena.constant(1.0)));
            }
            Bound::Wave | Bound::Slope => r,
            Bound::Growth { constant, rate } => {
                let r = self.arena.scale(rate, r);
                self.grown(mid, constant, r)
            }
            Bound::Root => {
                self.positive(x_mid, r);
                self.arena.div(r, mid)
            }
            Bound::CubeRoot => {
                let size = self.arena.abs(x_mid);
                self.positive(size, r);
                self.arena.product(&[(r, 1), (mid, -2)])
            }
            Bound::Logarithm { shift, scale } => self.logarithm(shift, scale, x_mid, r),
            Bound::Arc { is_root } => {
                let left = self.left_of_one(x_mid, r);
                let divisor = if is_root {
                    self.arena.call(Function::Sqrt, left)
                } else {
                    left
                };
                self.arena.div(r, divisor)
            }
            // relative: |(1+ε)^k − 1| ≤ |k| 2^|k−1| ε for ε ≤ ½
            Bound::Power => {
                let k = function.exponent();
                let half = self.arena.scale(0.5, x_mid);
                self.positive(half, r);
                let slope = k.abs() * (k - 1.0).abs().exp2();
                let size = self.arena.abs(mid);
                let relative = self.arena.div(r, x_mid);
                let radius = self.arena.mul(size, relative);
                self.arena.scale(slope, radius)
            }
            Bound::None => return None,
        };
        Some(around(mid, radius))
    }

    /// Bounds a function of two arguments by its largest slopes near the midpoints.
    fn call2(&mut self, function: Binary, x: Expr, y: Expr) -> Option<Interval> {
        let (x, y) = (self.done[&x], self.done[&y]);
        let reach = |arena: &mut Arena| arena.add(x.radius, y.radius);
        match function.entry().bound {
            BinaryBound::Sum => {
                let mid = self.arena.call2(function, x.mid, y.mid);
                Some(around(mid, reach(self.arena)))
            }
            BinaryBound::Angle => {
                let distance = self.arena.call2(Binary::Hypot, x.mid, y.mid);
                let reach = reach(self.arena);
                let left = self.positive(distance, reach);
                let mid = self.arena.call2(function, x.mid, y.mid);
                Some(around(mid, self.arena.div(reach, left)))
            }
            BinaryBound::None => None,
        }
    }

    /// Bounds a growing function by `(constant + |value|)(e^r − 1)`, where `e^r − 1 ≤ r + r²` for r
    /// below 1.7.
    fn grown(&mut self, value: Expr, constant: f64, r: Expr) -> Expr {
        let bound = self.arena.constant(1.7);
        self.positive(bound, r);
        let size = self.arena.abs(value);
        let size = self.arena.sum(constant, &[(1.0, size)]);
        let more = self.arena.sum(1.0, &[(1.0, r)]);
        self.arena.product(&[(size, 1), (r, 1), (more, 1)])
    }

    /// Bounds `scale ln(shift + x)`, which changes by at most `scale r / (shift + x − r)`.
    fn logarithm(&mut self, shift: f64, scale: f64, x: Expr, r: Expr) -> Expr {
        let shifted = self.arena.sum(shift, &[(1.0, x)]);
        let left = self.positive(shifted, r);
        let radius = self.arena.div(r, left);
        self.arena.scale(scale, radius)
    }

    /// Returns `1 − (|x| + r)²`, and records the condition that it is positive.
    fn left_of_one(&mut self, x: Expr, r: Expr) -> Expr {
        let size = self.arena.abs(x);
        let largest = self.arena.add(size, r);
        let square = self.arena.pow(largest, 2);
        let one = self.arena.constant(1.0);
        self.positive(one, square)
    }
}

fn around(mid: Expr, radius: Expr) -> Interval {
    Interval {
        mid,
        radius,
        end: None,
    }
}
