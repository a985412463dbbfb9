#![no_implicit_prelude]
#![deny(warnings, unused)]

struct Pendulum {
    g: f64,
}

#[::sve_runtime::variational(midpoint)]
impl Pendulum {
    #[must_use]
    fn lagrangian(&self, mut q: [f64; 1], v: [f64; 1]) -> f64 {
        q[0] *= self.g;
        let unused = 1.0;
        v[0] * v[0] - self.potential(q[0]).abs()
    }

    fn potential(&self, x: f64) -> f64 {
        self.g * x
    }
}

fn main() {
    let _ = ::sve_runtime::Integrator::new(Pendulum { g: 1.0 }, ::sve_runtime::Midpoint);
}
