//! The quantities by which means are differentiated.

use core::fmt;
use core::ops::Range;

use crate::phase::Field;
use crate::system::{Dimensions, System};

/// The parameter that varies along a direction, if one does, and the steps in which it varies.
#[derive(Clone, Debug)]
pub(super) struct Varied {
    parameter: Option<usize>,
    steps: Range<u64>,
}

impl Varied {
    /// Returns the number of the parameter that varies in a step.
    #[inline(always)]
    pub(super) fn in_step(&self, step: u64) -> Option<usize> {
        if self.steps.contains(&step) {
            self.parameter
        } else {
            None
        }
    }
}

/// The quantity by which a mean is differentiated: a parameter, a parameter during some steps, or a
/// coordinate of the start.
///
/// The name of a parameter, as `"k"`, `"l[0]"` or `"body.mass"`, converts to it.
///
/// ```
/// use sve_runtime::ensemble::By;
/// use sve_runtime::prelude::*;
///
/// struct Oscillator { k: f64 }
///
/// #[variational(midpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * self.k * q * q }
/// }
///
/// # fn main() -> Result<(), EnsembleError> {
/// let oscillator = Integrator::new(Oscillator { k: 1.0 }, Midpoint);
/// let halves = [By::during("k", 0..50), By::during("k", 50..100)];
/// let [first, second] = halves;
/// let by = [By::parameter("k"), first, second, By::q(0), By::p(0)];
/// let summary = Ensemble::new(&oscillator)
///     .paths(1).steps(0.01, 100)
///     .start(State::new([1.0], [0.0]))
///     .gradient("q", by.clone(), |state| state.q[0])
///     .run()?;
/// let [k, first, second, q, p] = by.map(|by| summary.derivative("q", by).unwrap().mean()[1]);
/// // q(t) = q₀ cos t + p₀ sin t at t = 1
/// assert!((q - 1_f64.cos()).abs() < 1e-4 && (p - 1_f64.sin()).abs() < 1e-4);
/// // the derivatives by the parameter in both halves sum up to the derivative by the parameter
/// assert!((first + second - k).abs() < 1e-14);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct By(Quantity);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Quantity {
    Parameter(String),
    During(String, Range<u64>),
    Q(usize),
    P(usize),
}

impl By {
    /// A parameter, by its name in the source without `self`.
    pub fn parameter(name: impl Into<String>) -> Self {
        Self(Quantity::Parameter(name.into()))
    }

    /// The value that a parameter has during some steps, as if it were a step function of time. An
    /// observable that reads the parameter at a recorded time reads its value in the step before.
    pub fn during(name: impl Into<String>, steps: Range<u64>) -> Self {
        Self(Quantity::During(name.into(), steps))
    }

    /// A coordinate of the start, by its number in a row of all. Random starts are moved together.
    /// A rotation has three, the canonical coordinates of a [`Tangent`](crate::Tangent).
    #[must_use]
    pub fn q(number: usize) -> Self {
        Self(Quantity::Q(number))
    }

    /// A momentum of the start.
    #[must_use]
    pub fn p(number: usize) -> Self {
        Self(Quantity::P(number))
    }

    /// Returns the parameter that varies, and the steps in which it varies. Each step of the
    /// ensemble is `parts` of these steps.
    pub(super) fn varied<S: System>(&self, parts: u64) -> Varied {
        let step = |number: u64| number.saturating_mul(parts);
        let (name, steps) = match &self.0 {
            Quantity::Parameter(name) => (name.as_str(), 0..u64::MAX),
            Quantity::During(name, steps) => (name.as_str(), step(steps.start)..step(steps.end)),
            Quantity::Q(_) | Quantity::P(_) => ("", 0..0),
        };
        Varied {
            parameter: S::PARAMETERS.iter().position(|&known| known == name),
            steps,
        }
    }

    /// Returns the tangent vector at the start.
    pub(super) fn start<D: Dimensions>(&self) -> Field<D::Vector> {
        let mut field = Field::zero::<D>();
        match self.0 {
            Quantity::Q(number) => field.q.as_mut()[number] = 1.0,
            Quantity::P(number) => field.p.as_mut()[number] = 1.0,
            _ => {}
        }
        field
    }

    /// Returns the reason why a system with so many coordinates has no such quantity; `None` if it
    /// has the quantity.
    pub(super) fn problem<S: System>(&self, coordinates: usize) -> Option<String> {
        match &self.0 {
            Quantity::Parameter(name) | Quantity::During(name, _) => {
                let is_unknown = !S::PARAMETERS.contains(&name.as_str());
                is_unknown.then(|| {
                    let known = S::PARAMETERS;
                    format!(
                        "L, the noises and the force have no such parameter; they have {known:?}"
                    )
                })
            }
            Quantity::Q(_) | Quantity::P(_)
                if !S::CONSTRAINTS.is_empty() || !S::ROLES.is_empty() =>
            {
                let why = "the coordinates of a start are not independent under constraints and for a degenerate Lagrangian";
                Some(why.to_owned())
            }
            Quantity::Q(number) | Quantity::P(number) => (*number >= coordinates).then(|| {
                format!("the system has {coordinates} coordinates, whose numbers begin at 0")
            }),
        }
    }
}

impl From<&str> for By {
    fn from(name: &str) -> Self {
        Self::parameter(name)
    }
}

impl From<String> for By {
    fn from(name: String) -> Self {
        Self::parameter(name)
    }
}

impl fmt::Display for By {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Quantity::Parameter(name) => write!(f, "{name}"),
            Quantity::During(name, steps) => write!(f, "{name} in {}..{}", steps.start, steps.end),
            Quantity::Q(number) => write!(f, "q[{number}] at the start"),
            Quantity::P(number) => write!(f, "p[{number}] at the start"),
        }
    }
}
