//! The map that comes with the program.

/// The ACES building, raw odometry (data/README.md says where it comes from and its licence).
pub const LOG: &[u8] = include_bytes!("../../data/aces.clf.bz2");
/// Its file name.
pub const NAME: &str = "aces.clf.bz2";
