use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, _r: Rotation3<f64>, q: Vector3<f64>, w: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * self.s * (w.norm_squared() + v.norm_squared()) - q.x
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
