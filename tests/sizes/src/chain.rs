//! A chain with anharmonic springs and a noise at each end.

use sve_runtime::prelude::*;

const N: usize = 128;

struct Chain {
    k: f64,
    noise: f64,
}

#[variational(endpoint, midpoint, stormer_verlet)]
impl Chain {
    fn lagrangian(&self, q: [f64; 128], v: [f64; 128]) -> f64 {
        let mut l = -self.potential(q[0]);
        for i in 0..128 {
            l += 0.5 * v[i].powi(2);
        }
        for i in 1..128 {
            l -= self.potential(q[i] - q[i - 1]);
        }
        l
    }

    fn potential(&self, x: f64) -> f64 {
        0.5 * self.k * x.powi(2) + 0.25 * x.powi(4)
    }

    #[gamma]
    fn kicks(&self, q: [f64; 128]) -> [f64; 2] {
        [self.noise * q[0].sin(), self.noise * q[127].sin()]
    }
}

pub(crate) fn check() {
    let chain = || Chain { k: 1.0, noise: 0.3 };
    let state: State<[f64; N]> = State::new(
        std::array::from_fn(|i| 0.3 * (i as f64).sin()),
        std::array::from_fn(|i| 0.2 * (i as f64).cos()),
    );
    super::check(chain(), Endpoint, state);
    super::check(chain(), Midpoint, state);
    super::check(chain(), StormerVerlet, state);
}
