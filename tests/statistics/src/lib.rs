//! Tests that integrate many long paths: they are compiled with optimisation, those of `sve-tests`
//! without.
