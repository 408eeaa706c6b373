//! What tests share.

#[macro_use]
pub mod both_backends;
pub mod dice;
pub mod input;
pub mod problems;
pub mod room;

pub use dice::Dice;
pub use input::{Scratch, message, public_graph, shared, small_log};
