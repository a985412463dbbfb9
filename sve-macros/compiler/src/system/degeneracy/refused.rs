//! Degenerate Lagrangians that are refused, with the reasons and the advice of the messages.

use crate::syntax::parse::Annotated;
use crate::system::regular::{self, Undetermined, kinetic_term, names};

/// The reason why a Lagrangian is refused: it does not determine the motion, or not in a form for
/// which steps are derived.
pub(super) enum Refused {
    /// Nothing determines these velocities.
    Undetermined(Vec<usize>),
    /// ∂²L/∂v² is singular, and the null directions are not coordinates.
    NoSplit,
    /// The momentum of this coordinate depends on time.
    TimeDependent(usize),
    /// ω is singular everywhere. Its null vectors contain these coordinates.
    SingularForm(Vec<usize>),
    /// L is linear in these algebraic coordinates, so their equations are constraints on other
    /// coordinates, 0 = φ(q).
    Multipliers(Vec<usize>),
    /// ∂L/∂q of this algebraic coordinate depends on velocities.
    WithVelocity(usize),
    /// A noise depends on this algebraic coordinate.
    NoisyAlgebraic(usize, String),
}

impl Refused {
    /// Returns the error. It stands at the Lagrangian or at the noise.
    pub(super) fn error(
        &self,
        block: &Annotated,
        n: usize,
        undetermined: &Undetermined,
    ) -> syn::Error {
        let (q, v) = (
            |i: usize| regular::coordinate(block, i, n),
            |i: usize| regular::velocity(block, i, n),
        );
        let mut place = block.lagrangian.name.span();
        let message = match self {
            Self::Undetermined(velocities) => {
                let velocities = velocities.clone();
                let undetermined = Undetermined {
                    velocities,
                    ..*undetermined
                };
                return undetermined.error(block, n, "");
            }
            Self::NoSplit => {
                let remedy =
                    "change coordinates so that the directions without mass are coordinates, or ";
                return undetermined.error(block, n, remedy);
            }
            Self::TimeDependent(i) => format!(
                "this Lagrangian is affine in `{}`, and its factor depends on time: steps are derived for ∂L/∂v = α(q); \
                 choose coordinates in which this factor does not depend on time",
                v(*i)
            ),
            Self::SingularForm(coordinates) => format!(
                "this Lagrangian is degenerate: it is affine in {}, and ∂L/∂v = α(q) does not determine the motion, \
                 since ω = Dαᵀ − Dα is singular everywhere on {}; {}, or pair the coordinates, as in `q[0] * v[1]` of two coordinates without kinetic terms",
                names(coordinates, v),
                names(coordinates, q),
                kinetic_term(block, coordinates, n),
            ),
            Self::Multipliers(coordinates) => {
                let (what, constraint) = match coordinates.len() {
                    1 => (
                        "its equation, 0 = ∂L/∂q, is a constraint on the others, and the coordinate a multiplier",
                        "the constraint",
                    ),
                    _ => (
                        "their equations, 0 = ∂L/∂q, are constraints on the others, and the coordinates multipliers",
                        "each constraint",
                    ),
                };
                let listed = names(coordinates, q);
                format!(
                    "this Lagrangian is degenerate: it is linear in {listed} without {}, so {what}; leave {listed} out of the coordinates and of L, \
                     and write {constraint} as `#[constraint] fn name(&self, q: …) -> f64`, whose value is to be 0; or {}",
                    names(coordinates, v),
                    kinetic_term(block, coordinates, n),
                )
            }
            Self::WithVelocity(i) => format!(
                "this Lagrangian is degenerate: `{v}` does not occur in it, and the equation of `{q}`, 0 = ∂L/∂{q}, has other velocities; \
                 solve this equation for `{q}` and insert the solution into L, or {term}",
                v = v(*i),
                q = q(*i),
                term = kinetic_term(block, &[*i], n),
            ),
            Self::NoisyAlgebraic(i, noise) => {
                let name = noise.split('[').next().unwrap_or(noise);
                let function = block.noises.iter().find(|f| f.name == name);
                place = function.map_or(place, |f| f.name.span());
                format!(
                    "the noise `{noise}` depends on `{q}` or its momentum, and `{v}` does not occur in L: \
                     the equation of `{q}`, ∂L/∂{q} dt + ∂γ/∂{q} ∘ dW = 0, has no solution; let the noise depend on other coordinates, or {term}",
                    q = q(*i),
                    v = v(*i),
                    term = kinetic_term(block, &[*i], n),
                )
            }
        };
        syn::Error::new(place, message)
    }
}
