//! Models shared by the integration tests, each with hand-written oracles.
