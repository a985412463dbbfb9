use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint, reduced)]
impl Body {
    fn lagrangian(&self, w: Vector3<f64>) -> f64 {
        0.5 * self.s * w.norm_squared()
    }
    #[gamma]
    fn push(&self, r: Rotation3<f64>) -> f64 {
        r[(0, 0)]
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
