//! Cases where integrators break: stiff, chaotic, singular, of odd sizes, dominated by noise.
//!
//! Each test says what must hold and why. A bound that is not derived is a few times the measured
//! value.

mod branches;
mod domains;
mod noise;
mod orbits;
mod places;
mod refine;
mod roots;
mod sampling;
mod scales;
mod stiff;
mod systems;
mod wild;
