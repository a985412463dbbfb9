//! The language of a body: each feature, and the idioms of programs that are larger.

#![allow(
    clippy::assign_op_pattern,
    clippy::cast_lossless,
    clippy::cast_sign_loss,
    clippy::explicit_iter_loop,
    clippy::needless_for_each,
    clippy::unnecessary_cast,
    clippy::useless_conversion
)] // each way to write a loop, a cast and a conversion is what is tested

mod features;
mod idioms;
