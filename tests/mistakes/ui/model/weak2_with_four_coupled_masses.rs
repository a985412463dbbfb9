use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
}

#[variational(midpoint, midpoint(weak2), stormer_verlet(weak2))]
impl Pendulum {
    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let mut l = 0.0;
        for i in 0..4 {
            l += 4.0 * v[i] * v[i] + self.g * q[i].cos();
            for j in 0..i {
                l += (q[i] - q[j]).cos() * v[i] * v[j];
            }
        }
        l
    }

    #[gamma]
    fn push(&self, q: [f64; 4]) -> f64 {
        self.g * q[0] * q[1]
    }
}

fn main() {
    let _ = Integrator::new(Pendulum { g: 1.0 }, Midpoint);
}
