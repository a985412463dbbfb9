//! The language of a body: each feature, and the idioms of programs that are larger.

#![allow(
    clippy::cast_lossless,
    clippy::cast_sign_loss,
    clippy::unnecessary_cast,
    clippy::useless_conversion
)] // casts and conversions are what is tested

mod features;
mod idioms;
