//! All integration tests, one binary: it links once.

/// A made-up building with known truth.
mod building;
/// Readers and writers: round trips, exact messages, every prefix of every format, the real logs.
mod formats;
/// From a raw log to a map.
mod front_end;
/// Laws of the numbers: SE(2), angles, scatter.
mod laws;
/// What the source tree may look like: layers, file lengths, words that must not occur.
mod layering;
/// Errors of trajectories and maps, against naive twins.
mod metrics;
/// FootSLAM, FeetSLAM and what belongs to them.
mod pedestrian;
/// The whole pipeline on simulated maps.
mod pipeline;
/// Pictures: what is drawn where, and the same bytes every time.
mod render;
/// Simulated worlds against their own claims.
mod simulate;
/// Each stage of the pipeline by itself.
mod stages;
/// Scratch folders, the shared data where they are, and seeded random maps.
mod support;
