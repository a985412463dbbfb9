use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * self.s * (w.x * w.x + w.y * w.y) - r[(2, 2)]
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
