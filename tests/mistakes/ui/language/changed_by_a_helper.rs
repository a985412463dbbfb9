use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut x = q;
        for x in x.iter_mut() {
            Self::double(x);
        }
        v.iter().map(|v| v * v).sum::<f64>() - self.g * x[0]
    }

    fn double(x: &mut f64) {
        *x *= 2.0;
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
