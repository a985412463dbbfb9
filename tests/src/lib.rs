//! Models shared by the integration tests.

pub mod models;
