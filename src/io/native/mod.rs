//! The native map: one `.npz` that `numpy.load` opens (docs/FORMATS.md, "Native map", field by field).
//!
//! A zip of `.npy` arrays, stored without compression and with fixed dates: equal maps give equal bytes. Arrays from
//! `numpy.savez_compressed` are read too. Metres, radians, seconds. Numbers are read back bit for bit.

mod npy;
mod reader;
mod writer;

pub use reader::read;
pub use writer::write;
pub(super) use writer::write_arrays;

/// Version of the layout that is written, and the newest that is read.
pub const FORMAT_VERSION: i64 = 1;
