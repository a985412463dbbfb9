//! The tests of steps, trajectories, ensembles and studies: see `tests`.
