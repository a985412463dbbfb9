//! The Gauss rules: reference steps, orders, symplecticity, momenta, solvers, failures; and the
//! option `weak2` of all rules.

mod action;
mod derivatives;
mod failures;
mod orders;
mod reference;
mod roots;
mod solvers;
mod stage_noise;
mod systems;
mod trajectories;
mod weak2;
