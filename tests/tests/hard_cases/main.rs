//! Cases where integrators break: stiff, chaotic, singular, of odd sizes, dominated by noise.
//!
//! Each test says what has to hold and why; bounds that are not derived are a few times what is measured.

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
