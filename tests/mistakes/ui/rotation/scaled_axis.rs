use sve_runtime::prelude::*;

struct Torsion {
    i: Vector3<f64>,
    k: f64,
}

#[variational(midpoint)]
impl Torsion {
    fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        let turned = r.scaled_axis();
        let angle = r.angle();
        0.5 * w.dot(&self.i.component_mul(&w)) - 0.5 * self.k * (turned.norm_squared() + angle * angle)
    }
}

fn main() {
    let i = Vector3::new(1.0, 2.0, 3.0);
    let _ = Integrator::new(Torsion { i, k: 1.0 }, Midpoint);
}
