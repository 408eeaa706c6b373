//! Reading and writing: one file per format.

pub mod atomic;
