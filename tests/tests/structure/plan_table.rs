//! The plans of every model and rule.

/// The strong order of each system, with the pair of noises that do not commute. For each rule that
/// the system has: the kind of the step, and the number of unknowns in its implicit blocks.
const PLANS: &str = "\
system               | strong order                 | initial_point | endpoint   | midpoint | stormer_verlet | taylor2
Pendulum             |                              | explicit 0    | explicit 0 | Newton 1 | explicit 0     | Newton 1
PlanarDoublePendulum |                              | Newton 2      | Newton 2   | Newton 2 | Newton 2       | Newton 6
Magnetic             |                              | linear 2      | Newton 2   | Newton 2 | Newton 2       | Newton 6
SphericalPendulum    |                              | linear 1      | linear 1   | Newton 2 | Newton 2       | Newton 6
Relativistic         |                              | Newton 2      | Newton 2   | Newton 2 | Newton 2       | Newton 6
HenonHeiles          |                              | explicit 0    | explicit 0 | Newton 2 | explicit 0     | Newton 2
Quartic              |                              | explicit 0    | explicit 0 | Newton 1 | explicit 0     | Newton 2
Oscillator           | strong 1                     | explicit 0    | explicit 0 | linear 1 | explicit 0
Kubo                 | strong 1                     | linear 1      | linear 1   | linear 1 | explicit 0
DoublePendulum       | strong 1                     | Newton 2      | Newton 2   | Newton 2 | Newton 2
Mixed                | strong 1/2: drag[0], drag[1] | Newton 2      | Newton 4   | Newton 4 | Newton 2
Polar                | strong 1/2: push, turn       | Newton 2      | Newton 3   | Newton 3 | Newton 3
Driven               | strong 1/2: push, jitter     | linear 1      | Newton 2   | Newton 2 | Newton 2
Synchrotron          | strong 1                     | explicit 0    | explicit 0 | Newton 1 | explicit 0
Actions              | strong 1                     | Newton 1      | Newton 1   | Newton 2 | Newton 2
Clashing             | strong 1/2: push, stretch    | linear 1      | linear 1   | Newton 2 | linear 2
Chain                | strong 1                     | explicit 0    | explicit 0 | Newton 6 | explicit 0
OneMomentum          | strong 1/2: drag, push       | linear 1      | Newton 1   | Newton 4 | Newton 2
Rails                | strong 1                     | linear 8      | linear 8   | Newton 8 | linear 8
Stirred              |                              | Newton 2      | Newton 1   | Newton 2 | Newton 2       | Newton 5
Stretched            |                              | Newton 1      | Newton 1   | Newton 1 | Newton 1       | Newton 3
Damped               | strong 1                     | linear 1      | explicit 0 | Newton 1 | linear 1
Towed                | strong 1/2: jitter, push     | Newton 2      | Newton 3   | Newton 3 | Newton 2
Sail                 | strong 1/2: jitter, push     | Newton 2      | Newton 3   | Newton 3 | Newton 2
Rubbed               | strong 1                     | Newton 1      | explicit 0 | Newton 1 | Newton 1
Charges              | strong 1/2: jitter[1], pull  | linear 6      | Newton 10  | Newton 8 | linear 6
Central              | strong 1                     | explicit 0    | explicit 0 | Newton 2 | explicit 0";

/// The cells of a row, without those of rules that the system does not have.
fn cells(row: &str) -> impl Iterator<Item = &str> {
    row.split('|').map(str::trim)
}

/// The strong order of a system and, by a rule, the kind of the step and its number of unknowns.
pub(crate) fn plan(system: &str, rule: &str) -> Option<[&'static str; 2]> {
    let mut rows = PLANS.lines();
    let column = cells(rows.next()?).position(|name| name == rule)?;
    let row = rows.find(|row| cells(row).next() == Some(system))?;
    Some([cells(row).nth(1)?, cells(row).nth(column)?])
}

/// The number of pairs of a system and a rule.
pub(crate) fn count() -> usize {
    let rows = PLANS.lines().skip(1);
    rows.map(|row| cells(row).count() - 2).sum()
}
