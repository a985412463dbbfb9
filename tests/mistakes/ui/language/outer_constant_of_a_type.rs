use sve_runtime::prelude::*;

const DIM: usize = 3;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let a: [f64; DIM] = std::array::from_fn(|i| q[i]);
        v.iter().map(|v| v * v).sum::<f64>() - self.g * a[0]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
