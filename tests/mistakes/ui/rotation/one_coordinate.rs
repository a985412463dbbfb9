use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, q: f64, r: Rotation3<f64>, v: f64, w: Vector3<f64>) -> f64 {
        0.5 * self.s * (w.norm_squared() + v * v) - q * r[(0, 0)]
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
