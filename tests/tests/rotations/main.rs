//! Rotations as configurations: rigid bodies, alone, several, and beside vectors.

mod accuracy;
mod charts;
mod gradients;
mod motion;
mod reduced;
mod reference;
mod runs;
mod starts;
mod symplectic;
mod systems;
