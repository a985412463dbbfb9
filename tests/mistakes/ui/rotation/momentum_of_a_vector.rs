use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * self.s * w.norm_squared()
    }
    #[h1]
    fn kick(&self, _r: Rotation3<f64>, p: Vector3<f64>) -> f64 {
        p.x
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
