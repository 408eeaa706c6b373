//! What tests share.

pub mod against_truth;
#[macro_use]
pub mod both_backends;
pub mod dice;
pub mod input;
pub mod problems;
pub mod room;

pub use against_truth::{ate_m, largest_distance_m, worst_edges};
pub use dice::Dice;
pub use input::{Scratch, message, public_graph, shared, small_log};
