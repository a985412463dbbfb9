use sve_runtime::prelude::*;

#[variational(midpoint)]
struct Pendulum {
    g: f64,
}

fn main() {
    let _ = Pendulum { g: 1.0 }.g;
}
