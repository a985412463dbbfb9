//! Long paths: energies and momenta wander by rounding and do not drift.

mod comets;
mod gauss;
mod paths;
mod planets;
mod scenes;
mod thermal;
mod walks;
