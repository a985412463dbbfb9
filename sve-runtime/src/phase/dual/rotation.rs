//! Rotations in dual numbers: the matrix of an attitude that turns in a direction.

use core::ops::{Index, Mul};

use nalgebra::{UnitQuaternion, Vector3};

use super::Dual;
use crate::phase::configuration::FixedSize;

/// The matrix of a rotation whose entries vary in a direction: the attitude in a
/// [`DualState`](crate::DualState).
///
/// It turns vectors of the body into space, `r * Vector3::x()` and `r * [a, b, c]`, has entries,
/// `r[(row, column)]`, and an [`inverse`](Self::inverse).
///
/// ```
/// use sve_runtime::prelude::*;
/// use sve_runtime::Dual;
///
/// /// A heavy top: its axis leans out of the vertical.
/// struct Top { i: Vector3<f64>, weight: f64 }
///
/// #[variational(midpoint)]
/// impl Top {
///     fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
///         0.5 * w.dot(&self.i.component_mul(&w)) - self.weight * r[(2, 2)]
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let top = Integrator::new(Top { i: Vector3::new(1.0, 1.0, 0.5), weight: 2.0 }, Midpoint);
/// let attitude = UnitQuaternion::from_euler_angles(0.4, 0.0, 0.0);
/// let start = State::new(attitude, Vector3::new(0.0, 0.0, 3.0));
/// // the height of the axis after a second
/// let height = top.trajectory(start, 0.01, NoNoise).gradient(100, |k, state| {
///     let [_, _, z]: [Dual; 3] = state.q * Vector3::z();
///     (k == 100).then_some(z)
/// })?;
/// println!("∂z/∂weight = {:?}, by the body momentum {}", height.get("weight"), height.start().p);
/// // a turn e about the vertical, which keeps Π = y − ½ e × Π, changes nothing
/// let e = start.q.inverse() * Vector3::z();
/// let change = height.start().q.dot(&e) + height.start().p.dot(&(0.5 * e.cross(&start.p)));
/// assert!(change.abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct DualRotation {
    /// The columns of the matrix.
    columns: [[Dual; 3]; 3],
}

impl DualRotation {
    /// Returns the rotation R, which moves by R ê along the direction e: column `j` by
    /// `R (e × e_j)`.
    pub(crate) fn new(rotation: &UnitQuaternion<f64>, along: [f64; 3]) -> Self {
        let mut entries = [0.0; 9];
        rotation.entries(&mut entries);
        let column = |j: usize| -> [f64; 3] { core::array::from_fn(|i| entries[3 * j + i]) };
        let columns = core::array::from_fn(|j| {
            // `e × e_j` has the components `e_l` along m and `−e_m` along l, with `e_j × e_l = e_m`
            let (l, m) = ((j + 1) % 3, (j + 2) % 3);
            let (to_l, to_m) = (column(l), column(m));
            let value = column(j);
            core::array::from_fn(|i| {
                let slope = along[m] * to_l[i] - along[l] * to_m[i];
                Dual::varying(value[i], slope)
            })
        });
        Self { columns }
    }

    /// Returns the inverse rotation, which turns vectors of space into the frame of the body.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            columns: core::array::from_fn(|j| core::array::from_fn(|i| self.columns[i][j])),
        }
    }
}

impl Index<(usize, usize)> for DualRotation {
    type Output = Dual;

    /// Returns the entry of a row and a column.
    fn index(&self, (row, column): (usize, usize)) -> &Dual {
        &self.columns[column][row]
    }
}

impl Mul<[Dual; 3]> for DualRotation {
    type Output = [Dual; 3];

    fn mul(self, vector: [Dual; 3]) -> [Dual; 3] {
        core::array::from_fn(|i| (0..3).map(|j| self.columns[j][i] * vector[j]).sum())
    }
}

impl Mul<Vector3<f64>> for DualRotation {
    type Output = [Dual; 3];

    fn mul(self, vector: Vector3<f64>) -> [Dual; 3] {
        self * [vector.x, vector.y, vector.z].map(Dual::from)
    }
}
