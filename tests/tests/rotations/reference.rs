//! Steps of rigid bodies with 40 digits from the discrete action alone, by
//! `tests/data/rigid_body.py`.

use sve_models::reference::check;
use sve_runtime::prelude::*;

use crate::systems::{FreeBody, HeavyTop, NoisyBody};

#[test]
fn steps_of_a_rigid_body_agree_with_forty_digits() {
    let noisy = std::cell::Cell::new(0);
    check("rigid_body", 6, 1e-12, |run| {
        let i = run.vector("I");
        if run.has("weight") {
            let (weight, s) = (run.number("weight"), run.number("s"));
            let top = HeavyTop { i, weight, s };
            return match run.rule.as_str() {
                "midpoint" => run.error(top, Midpoint),
                _ => run.error(top, StormerVerlet),
            };
        }
        if run.rule != "midpoint" {
            return run.error(FreeBody { i }, StormerVerlet);
        }
        if !run.has("chi") {
            return run.error(FreeBody { i }, Midpoint);
        }
        noisy.set(noisy.get() + 1);
        let (chi, k) = (run.vector("chi"), run.vector("K"));
        run.error(NoisyBody { i, chi, k }, Midpoint)
    });
    assert_eq!(noisy.get(), 1);
}
