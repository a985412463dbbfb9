//! What the integration tests share: models, the users' functions as oracles, differences, random points.

pub mod differences;
pub mod models;
pub mod oracle;
pub mod random;
