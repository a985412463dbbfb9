//! Tokens → annotated block: nesting, the attribute, the items with their roles and signatures; errors of shape.

pub(crate) mod nalgebra;
pub(crate) mod nesting;
pub(crate) mod parse;
pub(crate) mod recovery;
pub(crate) mod roles;
pub(crate) mod signature;
