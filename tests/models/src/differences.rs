//! Derivatives by central differences with two Richardson extrapolations.
//!
//! With δ = 2⁻⁶ the extrapolated error is of the size δ⁶/64 f⁽⁷⁾/7! ≈ 5e-17 f⁽⁷⁾, and rounding
//! gives 4ε|f|/δ ≈ 6e-14 |f|.

/// Largest step of the differences.
const DELTA: f64 = 1.0 / 64.0;

/// Returns `f'(0)`.
pub fn derivative(f: impl Fn(f64) -> f64) -> f64 {
    derivatives(|x| vec![f(x)])[0]
}

/// Returns `f'(0)`, entry by entry.
pub fn derivatives(f: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    extrapolated(&f)
}

// The function is passed by pointer, so that the code is compiled once for all functions.
fn extrapolated(f: &dyn Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let central = |delta: f64| -> Vec<f64> {
        let (plus, minus) = (f(delta), f(-delta));
        let pairs = plus.iter().zip(&minus);
        pairs.map(|(a, b)| (a - b) / (2.0 * delta)).collect()
    };
    let [a, b, c] = [DELTA, DELTA / 2.0, DELTA / 4.0].map(central);
    let entry = |i: usize| {
        let (ab, bc) = ((4.0 * b[i] - a[i]) / 3.0, (4.0 * c[i] - b[i]) / 3.0);
        (16.0 * bc - ab) / 15.0
    };
    (0..a.len()).map(entry).collect()
}

/// Returns the gradient of `f` at `x`.
pub fn gradient(x: &[f64], f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let along = |i| derivative(|d| f(&moved(x, i, d)));
    (0..x.len()).map(along).collect()
}

/// Returns `x` with `d` added to entry `i`.
pub fn moved(x: &[f64], i: usize, d: f64) -> Vec<f64> {
    let mut x = x.to_vec();
    x[i] += d;
    x
}
