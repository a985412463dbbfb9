//! Dense linear systems of a size known at compile time.
//!
//! Input: matrix and right-hand side; output: the solution, or `None` where the matrix is singular to rounding.
//! One and two unknowns are written out (Cramer's rule is forward stable for two: Higham, Accuracy and Stability of
//! Numerical Algorithms, section 1.10.1); from three on Gaussian elimination with scaled partial pivoting,
//! so that equations in different units choose the same pivots.

/// Relative size under which a pivot counts as zero: the rounding error of forming it.
const SINGULAR: f64 = 4.0 * f64::EPSILON;

/// Solves `a x = b`.
#[inline(always)]
#[allow(clippy::inline_always)] // the sizes are constants: the branch and the loops vanish
pub fn solve<const K: usize>(a: &[[f64; K]; K], b: &[f64; K]) -> Option<[f64; K]> {
    let mut x = [0.0; K];
    match K {
        0 => {}
        1 => {
            if a[0][0] == 0.0 {
                return None;
            }
            x[0] = b[0] / a[0][0];
        }
        2 => {
            let (ad, bc) = (a[0][0] * a[1][1], a[0][1] * a[1][0]);
            let det = ad - bc;
            if det.abs() <= SINGULAR * (ad.abs() + bc.abs()) {
                return None;
            }
            let inverse = 1.0 / det;
            x[0] = (b[0] * a[1][1] - b[1] * a[0][1]) * inverse;
            x[1] = (b[1] * a[0][0] - b[0] * a[1][0]) * inverse;
        }
        _ => return eliminate(*a, *b),
    }
    Some(x)
}

fn eliminate<const K: usize>(mut a: [[f64; K]; K], mut b: [f64; K]) -> Option<[f64; K]> {
    let mut scale = [0.0; K];
    for i in 0..K {
        scale[i] = a[i].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    }
    for k in 0..K {
        let mut pivot = k;
        for i in k + 1..K {
            // |a[i][k]| / scale[i] > |a[pivot][k]| / scale[pivot], without dividing
            if a[i][k].abs() * scale[pivot] > a[pivot][k].abs() * scale[i] {
                pivot = i;
            }
        }
        if a[pivot][k].abs() <= SINGULAR * scale[pivot] {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        scale.swap(k, pivot);
        for i in k + 1..K {
            let factor = a[i][k] / a[k][k];
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    let mut x = [0.0; K];
    for k in (0..K).rev() {
        let mut sum = b[k];
        for j in k + 1..K {
            sum -= a[k][j] * x[j];
        }
        x[k] = sum / a[k][k];
    }
    Some(x)
}
