//! What the macro made of each step: the plan, the printed mathematics, and the step without its structure.

mod comparison;
mod formulas;
mod plan;
mod plan_table;
