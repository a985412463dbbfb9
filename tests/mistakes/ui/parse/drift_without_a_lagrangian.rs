use sve_runtime::prelude::*;

struct Overdamped {
    sigma: f64,
}

#[variational(midpoint)]
impl Overdamped {
    fn drift(&self, q: f64) -> f64 {
        q - q.powi(3)
    }

    #[gamma]
    fn noise(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

fn main() {
    let _ = Integrator::new(Overdamped { sigma: 0.1 }, Midpoint);
}
