//! Rotations as configurations: rigid bodies, alone, several, and beside vectors.

mod reference;
mod systems;
