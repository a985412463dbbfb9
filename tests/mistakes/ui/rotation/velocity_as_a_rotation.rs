use sve_runtime::prelude::*;

struct Body {
    s: f64,
}

#[variational(midpoint)]
impl Body {
    fn lagrangian(&self, r: Rotation3<f64>, w: Rotation3<f64>) -> f64 {
        self.s * (r * w)[(0, 0)]
    }
}

fn main() {
    let _ = Integrator::new(Body { s: 1.0 }, Midpoint);
}
