//! Holonomic constraints: consistent states, the forces of constraints, and the errors of steps that lose them.
//!
//! Input: the constraints that the macro differentiated ([`System::constraint_jets`]) and the mass matrix `M = ∂²L/∂v²`. Output: as above. Nothing here is on the
//! fast path of a step: the equations of a step have the constraints in them.
//!
//! | file | part |
//! | --- | --- |
//! | `consistent.rs` | projection of a state onto the constraints |
//! | `forces.rs` | the forces of the constraints in a step |
//! | `drift.rs` | the motion without noise, with the forces of the constraints |
//! | `explain.rs` | the error of a step that lost the constraints |

mod consistent;
pub(crate) mod drift;
pub(crate) mod explain;
mod forces;

pub use forces::{ConstraintForce, ConstraintForces};

use nalgebra::{DMatrix, DVector};

use crate::configuration::Coordinates;
use crate::system::{ConstraintJet, Dims, System};

/// Smallest pivot of a regular system of constraints, relative to its diagonal entry: gradients that differ in direction by 10⁻⁵. Below it, a step has lost
/// the digits of the constraint forces.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Fails to compile if a system has constraints, which the methods for comparison do not know.
pub(crate) const fn assert_unconstrained<S: System>() {
    assert!(
        S::CONSTRAINTS.is_empty(),
        "this method is for systems without constraints: it would leave them"
    );
}

/// Why a function of [`Mechanics`](crate::Mechanics) does not compile for a system with constraints.
pub(crate) const LEAVES_OUT_FORCES: &str = "this function is for systems without constraints: it would leave out their forces; `drift` has them, and a step makes the motion with noise";

/// The constraints at a point, with `A = ∂φ/∂q M⁻¹ ∂φ/∂qᵀ`.
struct Linearised<const N: usize> {
    jets: Vec<ConstraintJet<N>>,
    /// The columns of `M⁻¹ ∂φ/∂qᵀ`.
    directions: DMatrix<f64>,
    matrix: DMatrix<f64>,
    /// The mass matrix and the momentum at rest.
    mass: DMatrix<f64>,
    rest: [f64; N],
}

/// A constraint that depends on those before it.
struct Dependent {
    k: usize,
    pivot: f64,
}

impl<const N: usize> Linearised<N> {
    /// The constraints of a system at a point; `None` if the mass matrix is singular there.
    fn at<S, Q, const M: usize>(system: &S, t: f64, q: &Q::Flat) -> Option<Self>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        let mut jets = Vec::new();
        system.constraint_jets(t, q, &mut |jet| jets.push(jet));
        let lagrangian = system.lagrangian_jet(t, q, &[0.0; N]);
        let mass = DMatrix::from_fn(N, N, |i, j| lagrangian.dvv[i][j]);
        let slopes = DMatrix::from_fn(jets.len(), N, |k, i| jets[k].dq[i]);
        let directions = mass.clone().lu().solve(&slopes.transpose())?;
        let matrix = &slopes * &directions;
        Some(Self {
            jets,
            directions,
            matrix,
            mass,
            rest: lagrangian.dv,
        })
    }

    /// Returns the first constraint whose gradient depends on those before it.
    fn dependent(&self) -> Option<Dependent> {
        let mut matrix = self.matrix.clone();
        let count = matrix.nrows();
        for k in 0..count {
            let pivot = matrix[(k, k)] / self.matrix[(k, k)];
            // a gradient of zero has no ratio
            let is_regular = pivot.abs() > SMALLEST_PIVOT;
            if !is_regular {
                let pivot = if pivot.is_finite() { pivot } else { 0.0 };
                return Some(Dependent { k, pivot });
            }
            for i in k + 1..count {
                let factor = matrix[(i, k)] / matrix[(k, k)];
                for j in k..count {
                    let product = factor * matrix[(k, j)];
                    matrix[(i, j)] -= product;
                }
            }
        }
        None
    }

    /// Returns `A⁻¹ b`.
    fn solve(&self, b: &DVector<f64>) -> Option<DVector<f64>> {
        self.matrix.clone().lu().solve(b)
    }

    /// The constraint that is violated most, with its violation relative to its terms.
    fn worst(&self) -> (usize, f64) {
        let relative =
            |jet: &ConstraintJet<N>| jet.value.abs() / (jet.magnitude + f64::MIN_POSITIVE);
        let each = self.jets.iter().map(relative).enumerate();
        each.fold(
            (0, 0.0),
            |worst, next| if next.1 > worst.1 { next } else { worst },
        )
    }
}
