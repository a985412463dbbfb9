//! The structure of derived steps: the plan, the printed mathematics, and the comparison with steps
//! without structure.

mod comparison;
mod formulas;
mod plan;
mod plan_table;
