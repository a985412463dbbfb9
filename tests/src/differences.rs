//! Derivatives by central differences with two Richardson extrapolations.
//!
//! With δ = 2⁻⁶ the extrapolated error is of the size δ⁶/64 f⁽⁷⁾/7! ≈ 5e-17 f⁽⁷⁾, and rounding gives 4ε|f|/δ ≈ 6e-14 |f|.

/// Largest step of the differences.
const DELTA: f64 = 1.0 / 64.0;

/// `f'(0)`.
pub fn derivative(f: impl Fn(f64) -> f64) -> f64 {
    let [d] = derivatives(|x| [f(x)]);
    d
}

/// `f'(0)`, entry by entry.
pub fn derivatives<const K: usize>(f: impl Fn(f64) -> [f64; K]) -> [f64; K] {
    extrapolated(&f)
}

// through a pointer: one copy of the code a size, not one a function
fn extrapolated<const K: usize>(f: &dyn Fn(f64) -> [f64; K]) -> [f64; K] {
    let central = |delta: f64| {
        let (plus, minus) = (f(delta), f(-delta));
        core::array::from_fn(|i| (plus[i] - minus[i]) / (2.0 * delta))
    };
    let [a, b, c]: [[f64; K]; 3] = [DELTA, DELTA / 2.0, DELTA / 4.0].map(central);
    core::array::from_fn(|i| {
        let (ab, bc) = ((4.0 * b[i] - a[i]) / 3.0, (4.0 * c[i] - b[i]) / 3.0);
        (16.0 * bc - ab) / 15.0
    })
}

/// The gradient of `f` at `x`.
pub fn gradient<const N: usize>(x: [f64; N], f: impl Fn([f64; N]) -> f64) -> [f64; N] {
    core::array::from_fn(|i| derivative(|d| f(moved(x, i, d))))
}

/// `x` with `d` added to entry `i`.
pub fn moved<const N: usize>(mut x: [f64; N], i: usize, d: f64) -> [f64; N] {
    x[i] += d;
    x
}
