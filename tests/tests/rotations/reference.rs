//! Steps of a rigid body computed elsewhere with 40-digit arithmetic, independently of this
//! project.

use sve_models::reference::check;
use sve_runtime::prelude::*;

use crate::systems::{FreeBody, NoisyBody};

#[test]
fn steps_of_a_rigid_body_agree_with_forty_digits() {
    let noisy = std::cell::Cell::new(0);
    check("rigid_body", 2, 1e-12, |run| {
        let i = run.vector("I");
        if !run.has("chi") {
            return run.error(FreeBody { i }, Midpoint);
        }
        noisy.set(noisy.get() + 1);
        let (chi, k) = (run.vector("chi"), run.vector("K"));
        run.error(NoisyBody { i, chi, k }, Midpoint)
    });
    assert_eq!(noisy.get(), 1);
}
