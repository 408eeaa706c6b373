//! All integration tests, one binary: it links once.

/// Laws of the numbers: SE(2), angles, scatter.
mod laws;
/// What the source tree may look like: layers, file lengths, words that must not occur.
mod layering;
/// Simulated worlds against their own claims.
mod simulate;
/// Each stage of the pipeline by itself.
mod stages;
