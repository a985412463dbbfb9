//! Scenes: systems whose number of sites is the length of their state, as users write them. Their
//! steps are compared with the unrolled steps of the same systems, and their impulses with
//! differences of the users' functions, which remain plain Rust.
//!
//! | file | part |
//! | --- | --- |
//! | `common.rs` | one block as a scene and as an unrolled system, and what is compared |
//! | `chains.rs` | chains and rings, with masses of their own and with noise |
//! | `lattices.rs` | lattices in two and three dimensions, open and periodic |
//! | `bodies.rs` | all pairs of bodies, and lists of bonds, angles and neighbours with a cut-off |
//! | `invariants.rs` | energies, the symplectic form, strong order |
//! | `kinetic.rs` | kinetic energies that are no sums of `½ m v²` |
//! | `forces.rs` | friction, pushes and forces of neighbours |
//! | `drags.rs` | forces that depend on velocities |
//! | `noise_forces.rs` | forces of places that are noise |
//! | `h1.rs` | noises that move positions |
//! | `shapes.rs` | sums in formulas in many shapes, against differences |
//! | `totals.rs` | sums that enter other formulas, such as a mean field |
//! | `inner.rs` | inner sums that enter formulas of the sum around them |
//! | `rough.rs` | conditions on numbers, and rounded numbers |
//! | `midpoint.rs` | the midpoint rule, whose equations join all sites |
//! | `bounds.rs` | bounds of its equations, and what layouts tell of them |
//! | `symmetric.rs` | systems with symmetries |
//! | `symmetries.rs` | the momenta of symmetries |
//! | `conserved.rs` | steps conserve them, and what breaks a symmetry moves its momentum |
//! | `hard_steps.rs` | midpoint steps that fail, and solutions far from the first guess |
//! | `restored.rs` | explicit steps that fail where they cannot be made backwards |
//! | `failures.rs` | indices out of range and fields of wrong lengths |
//! | `output.rs` | saved states, files and snapshots |

#[macro_use]
mod common;
mod blocks;
mod bodies;
mod bounds;
mod chains;
mod conserved;
mod drags;
mod failures;
mod forces;
mod h1;
mod h1_midpoint;
mod hard_steps;
mod inner;
mod inputs;
mod invariants;
mod kinetic;
mod lattices;
mod midpoint;
mod noise_forces;
mod noises;
mod output;
mod restored;
mod rough;
mod shapes;
mod symmetric;
mod symmetries;
mod totals;
