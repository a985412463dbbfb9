//! Printers of a derived system. Rust is one back end.

pub(crate) mod rust;
