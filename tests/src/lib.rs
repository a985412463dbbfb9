//! What the integration tests share: models, the users' functions as oracles, differences, random points.

pub mod differences;
pub mod double_double;
pub mod models;
pub mod oracle;
pub mod random;
