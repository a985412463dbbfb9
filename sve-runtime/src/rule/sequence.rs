//! Code shared by compositions and splittings: substep `k` has the length `wₖ h` and the increments
//! `wₖ ΔW`.

use super::Mode;
use crate::system::plan::{Operations, Plan, Substeps};

/// Returns number and fraction of the substep that a walk visits after `at` other substeps.
#[inline(always)]
pub(super) fn visited<S, I: ?Sized, M: Mode<S, I>>(fractions: &[f64], at: usize) -> (usize, f64) {
    let number = if M::IS_BACKWARD {
        fractions.len() - 1 - at
    } else {
        at
    };
    (number, fractions[number])
}

/// Returns the plan of `count` substeps. Each of the given plans describes the same number of
/// substeps.
pub(super) const fn plan_of<const K: usize>(
    plans: [&Plan; K],
    rule: &'static str,
    composition: &'static str,
    order: u32,
    count: usize,
) -> Plan {
    let none = Operations {
        arithmetic: 0,
        transcendental: 0,
        angle_additions: 0,
    };
    let (mut prepare, mut step, mut carried) = (none, none, none);
    let (mut iteration, mut at) = (none, 0);
    let mut in_lanes = true;
    while at < K {
        let times = count / K;
        prepare = prepare.plus(times, plans[at].prepare);
        step = step.plus(times, plans[at].step);
        carried = carried.plus(times, plans[at].carried);
        iteration = iteration.plus(times, plans[at].iteration);
        in_lanes = in_lanes && plans[at].in_lanes;
        at += 1;
    }
    Plan {
        rule,
        substeps: Some(Substeps { composition, count }),
        deterministic_order: order,
        weak_order: if plans[0].noises == 0 {
            order
        } else {
            plans[0].weak_order
        },
        in_lanes,
        prepare,
        step,
        carried,
        iteration,
        ..*plans[0]
    }
}
