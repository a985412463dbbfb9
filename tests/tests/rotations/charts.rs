//! Canonical coordinates near a state with rotations, and derivatives of steps by differences.
//!
//! Near a rotation R with momentum Π the coordinates are the Cayley vector ε of R cay(ε) and the
//! conjugate momentum y = A(ε)ᵀ Π, with A(ε) = (1 − ½ ε̂)/(1 + ¼|ε|²).

use sve_runtime::nalgebra::{DMatrix, Quaternion};
use sve_runtime::prelude::*;

/// The distance of differences, and the weights of one, two and three distances.
const STEP: f64 = 2e-3;
const WEIGHTS: [f64; 3] = [0.75, -0.15, 1.0 / 60.0];

/// A state that has canonical coordinates: `2 N` numbers.
pub(crate) trait Chart: Copy {
    const N: usize;
    /// Returns the state with these coordinates in the chart around this state.
    fn moved(&self, coordinates: &[f64]) -> Self;
    /// Returns the coordinates of another state in the chart around this state.
    fn coordinates(&self, other: &Self) -> Vec<f64>;
}

fn cayley(x: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::from_parts(1.0, 0.5 * x))
}

/// Returns the Cayley vector of a rotation.
pub(crate) fn cayley_vector(r: &UnitQuaternion<f64>) -> Vector3<f64> {
    2.0 * r.imag() / r.w
}

/// Returns A(ε)ᵀ Π.
fn conjugate(e: Vector3<f64>, pi: Vector3<f64>) -> Vector3<f64> {
    (pi + 0.5 * e.cross(&pi)) / (1.0 + 0.25 * e.norm_squared())
}

/// Returns Π, of which y is the conjugate.
fn body(e: Vector3<f64>, y: Vector3<f64>) -> Vector3<f64> {
    y - 0.5 * e.cross(&y) + 0.25 * e * e.dot(&y)
}

impl Chart for (UnitQuaternion<f64>, Vector3<f64>) {
    const N: usize = 3;

    fn moved(&self, z: &[f64]) -> Self {
        let (e, dy) = (
            Vector3::from_column_slice(&z[..3]),
            Vector3::from_column_slice(&z[3..]),
        );
        (self.0 * cayley(e), body(e, self.1 + dy))
    }

    fn coordinates(&self, other: &Self) -> Vec<f64> {
        let e = cayley_vector(&(self.0.inverse() * other.0));
        let dy = conjugate(e, other.1) - self.1;
        e.iter().chain(dy.iter()).copied().collect()
    }
}

impl Chart for State<UnitQuaternion<f64>> {
    const N: usize = 3;

    fn moved(&self, z: &[f64]) -> Self {
        let (q, p) = (self.q, self.p).moved(z);
        Self { t: self.t, q, p }
    }

    fn coordinates(&self, other: &Self) -> Vec<f64> {
        (self.q, self.p).coordinates(&(other.q, other.p))
    }
}

impl Chart for State<(Vector3<f64>, UnitQuaternion<f64>)> {
    const N: usize = 6;

    fn moved(&self, z: &[f64]) -> Self {
        let part = |at: usize| Vector3::from_column_slice(&z[at..at + 3]);
        let (r, pi) = (self.q.1, self.p.1).moved(&[&z[3..6], &z[9..]].concat());
        let q = (self.q.0 + part(0), r);
        let p = (self.p.0 + part(6), pi);
        Self { t: self.t, q, p }
    }

    fn coordinates(&self, other: &Self) -> Vec<f64> {
        let z = (self.q.1, self.p.1).coordinates(&(other.q.1, other.p.1));
        let (q, p) = (other.q.0 - self.q.0, other.p.0 - self.p.0);
        [q.as_slice(), &z[..3], p.as_slice(), &z[3..]].concat()
    }
}

impl<const K: usize> Chart for State<[UnitQuaternion<f64>; K]> {
    const N: usize = 3 * K;

    fn moved(&self, z: &[f64]) -> Self {
        let mut state = *self;
        for b in 0..K {
            let own = [&z[3 * b..3 * b + 3], &z[3 * (K + b)..3 * (K + b) + 3]].concat();
            (state.q[b], state.p[b]) = (self.q[b], self.p[b]).moved(&own);
        }
        state
    }

    fn coordinates(&self, other: &Self) -> Vec<f64> {
        let mut z = vec![0.0; 6 * K];
        for b in 0..K {
            let own = (self.q[b], self.p[b]).coordinates(&(other.q[b], other.p[b]));
            z[3 * b..3 * b + 3].copy_from_slice(&own[..3]);
            z[3 * (K + b)..3 * (K + b) + 3].copy_from_slice(&own[3..]);
        }
        z
    }
}

/// Returns the derivatives of a function by the canonical coordinates around a state, by
/// differences of sixth order.
pub(crate) fn slopes<C: Chart>(start: &C, function: impl Fn(&C) -> f64) -> Vec<f64> {
    let size = 2 * C::N;
    let slope = |column: usize| -> f64 {
        let at = |distance: f64| {
            let mut z = vec![0.0; size];
            z[column] = distance;
            function(&start.moved(&z))
        };
        let difference = |k: f64| (at(k * STEP) - at(-k * STEP)) / STEP;
        let terms = WEIGHTS.iter().zip([1.0, 2.0, 3.0]);
        terms.map(|(weight, k)| weight * difference(k)).sum()
    };
    (0..size).map(slope).collect()
}

/// Returns the derivative of a map in canonical coordinates at its start and its end, by
/// differences of sixth order.
pub(crate) fn differences<C: Chart>(start: &C, map: impl Fn(&C) -> C) -> DMatrix<f64> {
    let end = map(start);
    let size = 2 * C::N;
    let mut matrix = DMatrix::zeros(size, size);
    for column in 0..size {
        for (k, weight) in WEIGHTS.iter().enumerate() {
            let mut z = vec![0.0; size];
            let mut at = |scale: f64| {
                z[column] = scale * (k + 1) as f64 * STEP;
                end.coordinates(&map(&start.moved(&z)))
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            for row in 0..size {
                matrix[(row, column)] += weight * (ahead[row] - behind[row]) / STEP;
            }
        }
    }
    matrix
}

/// Returns the largest entry of `MᵀΩM − Ω`.
pub(crate) fn symplectic_defect(matrix: &DMatrix<f64>) -> f64 {
    let n = matrix.nrows() / 2;
    let omega = DMatrix::from_fn(2 * n, 2 * n, |i, j| {
        f64::from(i8::from(j == i + n) - i8::from(i == j + n))
    });
    (matrix.transpose() * &omega * matrix - omega).amax()
}
