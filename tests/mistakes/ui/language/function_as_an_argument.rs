use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * Self::total(v, Self::square) - self.g * Self::total(q, f64::sin)
    }

    fn square(x: f64) -> f64 {
        x * x
    }

    fn total(x: [f64; 2], f: fn(f64) -> f64) -> f64 {
        f(x[0]) + f(x[1])
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
