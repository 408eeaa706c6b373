//! All integration tests, one binary.

#[macro_use]
mod support;

mod joint;
