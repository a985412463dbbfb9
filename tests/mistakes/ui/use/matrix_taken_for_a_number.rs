use sve_runtime::prelude::*;

struct Oscillator {
    stiffness: Matrix2<f64>,
}

#[variational(midpoint, endpoint)]
impl Oscillator {
    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        0.5 * v.norm_squared() - (self.stiffness * q).norm_squared()
    }

    #[gamma]
    fn push(&self, q: Vector2<f64>) -> f64 {
        (self.stiffness * q).x
    }
}

fn main() {}
