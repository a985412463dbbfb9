use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
