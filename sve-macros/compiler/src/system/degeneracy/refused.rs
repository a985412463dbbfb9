//! Why a degenerate Lagrangian is refused, and what to write instead.

use crate::syntax::parse::Annotated;
use crate::system::regular;

/// Why a Lagrangian does not determine the motion, or not in a form for which steps are derived.
pub(super) enum Refused {
    /// Velocities that nothing determines: the error of the regularity check stands.
    Undetermined,
    /// ∂²L/∂v² is singular, and the null directions are not coordinates.
    NoSplit,
    /// The momentum of this coordinate depends on time.
    TimeDependent(usize),
    /// ω is singular everywhere; its null vectors have these coordinates.
    SingularForm(Vec<usize>),
    /// ∂L/∂q of this algebraic coordinate depends on velocities.
    WithVelocity(usize),
    /// A noise depends on this algebraic coordinate.
    NoisyAlgebraic(usize, String),
}

impl Refused {
    /// The error at the Lagrangian, or at the noise.
    pub(super) fn error(&self, block: &Annotated, n: usize) -> syn::Error {
        let (q, v) = (
            |i: usize| format!("`{}`", regular::coordinate(block, i, n)),
            |i: usize| format!("`{}`", regular::velocity(block, i, n)),
        );
        let mut place = block.lagrangian.name.span();
        let message = match self {
            Self::Undetermined | Self::NoSplit => {
                "this Lagrangian is degenerate: ∂²L/∂v² is singular everywhere, and the directions without mass are no coordinates; \
                 change coordinates so that the massless directions are coordinates, whose velocities occur linearly or not at all"
                    .to_owned()
            }
            Self::TimeDependent(i) => format!(
                "this Lagrangian is affine in {}, and the factor of this velocity depends on time: steps are derived for ∂L/∂v = α(q); \
                 write L so that time occurs only in the terms without velocities, by adding a total derivative",
                v(*i)
            ),
            Self::SingularForm(coordinates) => {
                let names: Vec<String> = coordinates.iter().map(|&i| q(i)).collect();
                format!(
                    "this Lagrangian is degenerate: ∂L/∂v = α(q) does not determine the motion, since ω = Dαᵀ − Dα is singular everywhere on the coordinates {}; \
                     give each of their velocities a kinetic term, or pair them: α must not be a gradient, and as many coordinates as it pairs are needed",
                    names.join(", ")
                )
            }
            Self::WithVelocity(i) => format!(
                "this Lagrangian is degenerate: {} does not occur in L, and ∂L/∂{} depends on other velocities; \
                 solve 0 = ∂L/∂{} for the coordinate and insert it into L",
                v(*i),
                q(*i).trim_matches('`'),
                q(*i).trim_matches('`'),
            ),
            Self::NoisyAlgebraic(i, noise) => {
                let name = noise.split('[').next().unwrap_or(noise);
                let function = block.noises.iter().find(|f| f.name == name);
                place = function.map_or(place, |f| f.name.span());
                let q = q(*i);
                let bare = q.trim_matches('`');
                format!(
                    "the noise `{noise}` depends on {q}, whose velocity does not occur in L: \
                     the equation of {q}, ∂L/∂{bare} dt + ∂γ/∂{bare} ∘ dW = 0, has no solution; give {q} a kinetic term, or let the noise depend on other coordinates"
                )
            }
        };
        syn::Error::new(place, message)
    }
}
