//! Reading and writing: one file per format.

pub mod atomic;
pub mod corrections_out;
