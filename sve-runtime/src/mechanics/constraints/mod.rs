//! Holonomic constraints: consistent states, the forces of constraints, and the errors of steps
//! that lose them.
//!
//! Input: the constraints that the macro differentiated ([`System::constraint_jets`]) and the mass
//! matrix `M = ∂²L/∂v²`. Output: states, forces and errors. Nothing here is on the fast path of a
//! step: the equations of a step contain the constraints.
//!
//! | file | part |
//! | --- | --- |
//! | `consistent.rs` | projection of a state onto the constraints |
//! | `fold.rs` | places where the gradients become dependent, along a step |
//! | `drift.rs` | the motion without noise, with the forces of the constraints |
//! | `explain.rs` | the error of a step that lost the constraints |

mod consistent;
pub(crate) mod drift;
pub(crate) mod explain;
pub(crate) mod fold;

pub(crate) use consistent::project;

use nalgebra::{DMatrix, DVector};

use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::system::{ConstraintJet, Dims, System};

/// Smallest pivot of a regular system of constraints, relative to its diagonal entry: gradients
/// that differ in direction by 10⁻⁵. Below it, a step has lost the digits of the constraint forces.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Fails to compile if a system has constraints, which the methods for comparison do not treat.
pub(crate) const fn assert_unconstrained<S: System>() {
    assert!(
        S::CONSTRAINTS.is_empty(),
        "this method is for systems without constraints: it would leave them"
    );
}

/// The reason why a function of [`Mechanics`](crate::Mechanics) does not compile for a system with
/// constraints.
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

/// A constraint whose gradient depends on the gradients of the constraints before it.
struct Dependent {
    k: usize,
    pivot: f64,
}

/// Rounding errors of a constraint, in units of the magnitudes of its terms.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Largest change of a gradient, relative to the gradient, over a distance at which the constraint
/// changes by its violation and its rounding errors. At a double root the change is ½, and it is
/// larger at a root of higher multiplicity.
const LARGEST_CHANGE: f64 = 0.125;

impl<const N: usize> Linearised<N> {
    /// Returns the constraints of a system at a point; `None` if the mass matrix is singular there.
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

    /// Returns the first constraint whose gradient depends on the gradients before it.
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

    /// Returns the first constraint whose gradient vanishes where the constraint holds, such as the
    /// gradient of f² for every f. The constraint is known only up to its violation and rounding
    /// errors. Within the corresponding distance such a gradient changes along its own direction by
    /// a large part of itself. The returned number is this change, relative to the gradient.
    fn vanishing<S, Q, const M: usize>(&self, system: &S, t: f64, q: &Q::Flat) -> Option<Dependent>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        let start = State::at(t, *q, [0.0; N]);
        for (k, jet) in self.jets.iter().enumerate() {
            let (along, open) = (
                self.matrix[(k, k)],
                jet.value.abs() + ROUNDING * jet.magnitude,
            );
            let mut change: f64 = 0.0;
            for sign in [-1.0, 1.0] {
                let by: [f64; N] =
                    core::array::from_fn(|i| sign * open / along * self.directions[(i, k)]);
                let (there, _) = Q::Flat::moved(&start, &by, &[0.0; N]);
                system.constraint_jets(t, &there, &mut {
                    let mut at = 0;
                    let change = &mut change;
                    move |other: ConstraintJet<N>| {
                        if at == k {
                            let slopes = other.dq.iter().zip(&jet.dq).enumerate();
                            let rates = slopes
                                .map(|(i, (there, here))| (there - here) * self.directions[(i, k)]);
                            let relative = rates.sum::<f64>() / along;
                            *change = change.max(relative.abs()) + 0.0 * relative;
                        }
                        at += 1;
                    }
                });
            }
            if change > LARGEST_CHANGE {
                return Some(Dependent { k, pivot: change });
            }
        }
        None
    }

    /// Returns `A⁻¹ b`.
    fn solve(&self, b: &DVector<f64>) -> Option<DVector<f64>> {
        self.matrix.clone().lu().solve(b)
    }

    /// Returns the constraint with the largest violation, and this violation relative to the terms
    /// of the constraint.
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
