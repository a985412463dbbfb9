//! Steps whose residuals cannot be smaller than the rounding errors of their terms: far from the
//! origin, the force between neighbours has a rounding error that does not decrease with the
//! momenta. The step must succeed and be accurate to this rounding error.

use sve_models::checks::assert_close;
use sve_models::oracle::{chain, rails};
use sve_models::stepper::{Stepper, one_node};
use sve_runtime::prelude::*;

/// Beads at the distances where the bonds are at rest: L = Σ ½v² − Σ (1 − exp(−(Δq − 1)))².
struct Morse;

#[variational(initial_point, endpoint, midpoint)]
impl Morse {
    fn lagrangian(&self, q: [f64; 6], v: [f64; 6]) -> f64 {
        let mut l = 0.0;
        for i in 0..6 {
            l += 0.5 * v[i] * v[i];
        }
        for i in 1..6 {
            l -= (1.0 - (1.0 + q[i - 1] - q[i]).exp()).powi(2);
        }
        l
    }

    #[gamma]
    fn shake(&self, q: [f64; 6]) -> f64 {
        (q[0] - q[1]).sin()
    }
}

/// L depends on differences only, so a step far from the origin, of a chain at rest whose one end
/// is kicked, is the translated step at the origin.
fn check<const N: usize>(rule: &dyn Stepper<[f64; N], [f64; 1]>, spacing: f64) {
    let kicked = |h: f64, offset: f64| {
        let q = core::array::from_fn(|i| offset + spacing * i as f64);
        let p = core::array::from_fn(|i| f64::from(u8::from(i == 0)));
        rule.after(State::new(q, p), h, &[0.0], 1)
    };
    for h in [0.1, 1e-2, 1e-3, 1e-5] {
        let near = kicked(h, 0.0);
        for offset in [0.1, -3.7, 1e3, 1e6] {
            let far = kicked(h, offset);
            let row = format!("{}, h = {h}, offset {offset}", rule.name());
            // coordinates are known to half a unit in the last place, forces to stiffnesses below
            // 10 times that
            let rounding = 2.0 * f64::EPSILON * (offset.abs() + N as f64);
            let of_p = 20.0 * h * rounding + 8.0 * f64::EPSILON;
            let moved = far.q.map(|q| q - offset);
            assert_close(&moved, &near.q, rounding * (1.0 + 10.0 * h), &row);
            assert_close(&far.p, &near.p, of_p, &row);
        }
    }
}

#[test]
fn a_chain_that_is_kicked_far_from_the_origin() {
    for rule in one_node(&chain()) {
        check(&*rule, 0.0);
    }
    check(&Integrator::new(rails(), Midpoint), 0.0);
}

#[test]
fn bonds_at_rest() {
    for rule in one_node(&Morse) {
        check(&*rule, 1.0);
    }
}
