//! What tests share.

#[macro_use]
pub mod both_backends;
pub mod dice;
pub mod g2o;
pub mod problems;
pub mod room;
