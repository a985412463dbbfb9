//! Dual numbers: a number with its derivative in one direction. Functions of a state that are
//! written with dual numbers are differentiated exactly. They cannot branch, so that they are
//! smooth.

use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

pub use rotation::DualRotation;

use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;

/// A number with its derivative (a dual number), from which smooth functions of a state are formed.
///
/// It has the operators and the smooth methods of `f64`, also with plain numbers on either side.
/// There is no comparison, no `abs` and no access to the value: the derivative of the mean of a
/// function with jumps differs from the mean of its derivatives along the paths, so such functions
/// cannot be written.
///
/// ```
/// use sve_runtime::{Dual, DualState};
///
/// /// The energy of a pendulum.
/// fn energy(state: &DualState<'_, 1>) -> Dual {
///     0.5 * state.p[0].powi(2) - state.parameter("g") * state.q[0].cos()
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    value: f64,
    slope: f64,
    /// True for a constant, which has the slope 0 also where a derivative is infinite: √σ at σ = 0.
    is_constant: bool,
}

/// A state whose coordinates vary in a direction: the argument of smooth functions of a state.
///
/// Coordinates and momenta stand in one row, also for `[[f64; 3]; B]` and vectors: the coordinates
/// of body 1 in space begin at `q[3]`. In systems with rotations `q` has the parts of the state's
/// `q`: a [`DualRotation`] for each rotation, a row for the other coordinates, `state.q.0` and
/// `state.q.1`, and nothing for a reduced system. The momenta are one row in these systems too.
#[allow(missing_debug_implementations)] // a view that lives as long as a call
pub struct DualState<'a, const N: usize, Q = [Dual; N]> {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Q,
    /// Momenta.
    pub p: [Dual; N],
    parameter: &'a dyn Fn(&str) -> Dual,
}

impl<'a, const N: usize, Q> DualState<'a, N, Q> {
    /// Returns a state that varies along a direction of its canonical coordinates; `parameter`
    /// returns the parameters.
    pub(crate) fn along<C: Coordinates<N, Dual = Q>>(
        state: &State<C>,
        direction: &Field<[f64; N]>,
        parameter: &'a dyn Fn(&str) -> Dual,
    ) -> Self {
        // For a rotation, Π = y − ½ ε × Π to first order.
        let (p, mut dp) = (C::components(&state.p), direction.p);
        C::Flat::add_transport(&p.map(|p| 0.5 * p), &direction.q, &mut dp);
        Self {
            t: state.t,
            q: state.q.dual(&direction.q),
            p: Dual::row(&p, &dp),
            parameter,
        }
    }

    /// Returns a parameter of the system by its name in the source without `self`, such as `k`,
    /// `l[0]`, `body.mass`.
    ///
    /// A function that depends on a parameter has to read it with this method. A number from
    /// elsewhere counts as a constant.
    ///
    /// If L, the noises and the force have no such parameter, the number is NaN, and the call that
    /// differentiates the function returns an error that lists the parameters.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Dual {
        (self.parameter)(name)
    }
}

impl Dual {
    /// Returns a number that varies with this slope.
    pub(crate) fn varying(value: f64, slope: f64) -> Self {
        Self {
            value,
            slope,
            is_constant: false,
        }
    }

    /// Returns a parameter, with the slope 1 if it varies and as a constant otherwise.
    pub(crate) fn parameter(value: f64, varies: bool) -> Self {
        Self {
            value,
            slope: f64::from(u8::from(varies)),
            is_constant: !varies,
        }
    }

    /// Returns numbers that vary with these slopes.
    pub(crate) fn row<const N: usize>(values: &[f64; N], slopes: &[f64; N]) -> [Self; N] {
        core::array::from_fn(|i| Self::varying(values[i], slopes[i]))
    }

    /// Returns the number itself.
    pub fn value(self) -> f64 {
        self.value
    }

    /// Returns the derivative.
    pub(crate) fn slope(self) -> f64 {
        self.slope
    }

    /// Returns a function of this number from the function's value and derivative.
    #[inline(always)]
    fn map(self, value: f64, derivative: f64) -> Self {
        Self {
            value,
            slope: if self.is_constant {
                0.0
            } else {
                derivative * self.slope
            },
            ..self
        }
    }
}

impl Dual {
    /// Returns a function of this number and another one from the function's value and slope.
    #[inline(always)]
    fn with(self, other: Self, value: f64, slope: f64) -> Self {
        let is_constant = self.is_constant && other.is_constant;
        Self {
            value,
            slope: if is_constant { 0.0 } else { slope },
            is_constant,
        }
    }
}

impl From<f64> for Dual {
    /// Returns a constant.
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self {
            value,
            slope: 0.0,
            is_constant: true,
        }
    }
}

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident($x:ident) = $value:expr, $derivative:expr;)*) => {
        /// Smooth functions of one number; outside of their domain they are NaN, like the functions
        /// of `f64`.
        impl Dual {$(
            $(#[$doc])*
            #[inline(always)]
            #[must_use]
            pub fn $name(self) -> Self {
                let $x = self.value;
                self.map($value, $derivative)
            }
        )*}
    };
}

functions! {
    /// The square root.
    sqrt(x) = x.sqrt(), 0.5 / x.sqrt();
    /// The cubic root.
    cbrt(x) = x.cbrt(), 1.0 / (3.0 * x.cbrt().powi(2));
    /// eˣ.
    exp(x) = x.exp(), x.exp();
    /// 2ˣ.
    exp2(x) = x.exp2(), core::f64::consts::LN_2 * x.exp2();
    /// eˣ − 1.
    exp_m1(x) = x.exp_m1(), x.exp();
    /// The natural logarithm.
    ln(x) = x.ln(), 1.0 / x;
    /// The natural logarithm of 1 + x.
    ln_1p(x) = x.ln_1p(), 1.0 / (1.0 + x);
    /// The logarithm to base 2.
    log2(x) = x.log2(), 1.0 / (x * core::f64::consts::LN_2);
    /// The logarithm to base 10.
    log10(x) = x.log10(), 1.0 / (x * core::f64::consts::LN_10);
    /// The sine.
    sin(x) = x.sin(), x.cos();
    /// The cosine.
    cos(x) = x.cos(), -x.sin();
    /// The tangent.
    tan(x) = x.tan(), 1.0 + x.tan().powi(2);
    /// The inverse sine.
    asin(x) = x.asin(), 1.0 / ((1.0 - x) * (1.0 + x)).sqrt();
    /// The inverse cosine.
    acos(x) = x.acos(), -1.0 / ((1.0 - x) * (1.0 + x)).sqrt();
    /// The inverse tangent.
    atan(x) = x.atan(), 1.0 / (1.0 + x * x);
    /// The hyperbolic sine.
    sinh(x) = x.sinh(), x.cosh();
    /// The hyperbolic cosine.
    cosh(x) = x.cosh(), x.sinh();
    /// The hyperbolic tangent.
    tanh(x) = x.tanh(), x.cosh().powi(-2);
    /// The inverse hyperbolic sine.
    asinh(x) = x.asinh(), 1.0 / x.hypot(1.0);
    /// The inverse hyperbolic cosine.
    acosh(x) = x.acosh(), 1.0 / ((x - 1.0) * (x + 1.0)).sqrt();
    /// The inverse hyperbolic tangent.
    atanh(x) = x.atanh(), 1.0 / ((1.0 - x) * (1.0 + x));
    /// 1/x.
    recip(x) = 1.0 / x, -1.0 / (x * x);
}

impl Dual {
    /// Returns the power with an integer exponent.
    #[inline(always)]
    #[must_use]
    pub fn powi(self, n: i32) -> Self {
        let derivative = if n == 0 {
            0.0
        } else {
            f64::from(n) * self.value.powi(n - 1)
        };
        self.map(self.value.powi(n), derivative)
    }

    /// Returns the power with a constant exponent.
    #[inline(always)]
    #[must_use]
    pub fn powf(self, n: f64) -> Self {
        let derivative = if n == 0.0 {
            0.0
        } else {
            n * self.value.powf(n - 1.0)
        };
        self.map(self.value.powf(n), derivative)
    }

    /// Returns sine and cosine.
    #[must_use]
    pub fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }

    /// Returns √(x² + y²).
    #[must_use]
    pub fn hypot(self, other: impl Into<Self>) -> Self {
        let other = other.into();
        let value = self.value.hypot(other.value);
        let slope = self.value / value * self.slope + other.value / value * other.slope;
        self.with(other, value, slope)
    }

    /// Returns the angle of the point (x, y), where this number is y. An angle jumps by 2π: use its
    /// sine and cosine in means.
    #[must_use]
    pub fn atan2(self, x: impl Into<Self>) -> Self {
        let x = x.into();
        let (y, square) = (self, self.value * self.value + x.value * x.value);
        let slope = (x.value * y.slope - y.value * x.slope) / square;
        y.with(x, y.value.atan2(x.value), slope)
    }

    /// Returns this number times `a` plus `b`.
    #[must_use]
    pub fn mul_add(self, a: impl Into<Self>, b: impl Into<Self>) -> Self {
        self * a.into() + b.into()
    }
}

impl Neg for Dual {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(-self.value, -1.0)
    }
}

macro_rules! operators {
    ($($trait:ident::$function:ident, $assign_trait:ident::$assign:ident, ($a:ident, $b:ident) = $value:expr, $slope:expr;)*) => {$(
        impl $trait for Dual {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                self.with(other, $value, $slope)
            }
        }

        impl $trait<f64> for Dual {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                self.$function(Self::from(other))
            }
        }

        impl $trait<Dual> for f64 {
            type Output = Dual;

            #[inline(always)]
            fn $function(self, other: Dual) -> Dual {
                Dual::from(self).$function(other)
            }
        }

        impl<T> $assign_trait<T> for Dual
        where
            Self: $trait<T, Output = Self>,
        {
            #[inline(always)]
            fn $assign(&mut self, other: T) {
                *self = (*self).$function(other);
            }
        }
    )*};
}

operators! {
    Add::add, AddAssign::add_assign, (a, b) = a.value + b.value, a.slope + b.slope;
    Sub::sub, SubAssign::sub_assign, (a, b) = a.value - b.value, a.slope - b.slope;
    Mul::mul, MulAssign::mul_assign, (a, b) = a.value * b.value, a.slope * b.value + a.value * b.slope;
    Div::div, DivAssign::div_assign, (a, b) = a.value / b.value, (a.slope - a.value / b.value * b.slope) / b.value;
}

impl Sum for Dual {
    fn sum<T: Iterator<Item = Self>>(terms: T) -> Self {
        terms.fold(Self::from(0.0), Add::add)
    }
}

mod rotation;
#[cfg(test)]
mod tests;
