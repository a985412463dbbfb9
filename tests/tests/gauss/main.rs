//! The Gauss rules: reference steps, orders, symplecticity, solvers, long runs.

mod reference;
mod systems;
