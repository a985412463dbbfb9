use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, _r: Rotation2<f64>, w: f64) -> f64 {
        0.5 * self.s * w * w
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
