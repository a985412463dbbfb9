use sve_runtime::prelude::*;

#[variational(midpoint)]
fn lagrangian(q: [f64; 1], v: [f64; 1]) -> f64 {
    v[0] * v[0] - q[0]
}

fn main() {
    let _ = lagrangian([1.0], [0.0]);
}
