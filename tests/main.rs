//! All integration tests, one binary: it links once.

/// Scratch folders, shared data, random input, and the macro that runs a test on both back ends.
#[macro_use]
mod support;

/// A made-up building with known truth.
mod building;
/// The `hitl` command as a user meets it: every command, every refusal, the standard streams.
mod cli;
/// Re-association.
mod closures;
/// Real logs and maps made bad.
mod damage;
/// Readers and writers: round trips, exact messages, every prefix of every format, the real logs.
mod formats;
/// From a raw log to a map.
mod front_end;
/// The pairwise inconsistency against its definition.
mod inconsistency;
/// From raw inertial data to steps.
mod inertial;
/// The joint problem: factors, both back ends, the paper's literal form, malformed problems.
mod joint;
/// Laws of the numbers: SE(2), angles, scatter.
mod laws;
/// What the source tree may look like: layers, file lengths, words that must not occur.
mod layering;
/// Errors of trajectories and maps, against naive twins.
mod metrics;
/// The committed docs/RESULTS.md keeps its promises.
mod paper_numbers;
/// FootSLAM, FeetSLAM and what belongs to them.
mod pedestrian;
/// The simulated person.
mod person;
/// The whole pipeline on simulated maps.
mod pipeline;
/// Pictures: what is drawn where, and the same bytes every time.
mod render;
/// Scan matching: its parts and the chain it makes of a real log.
mod scan_match;
/// What single scenarios claim of themselves.
mod scenarios;
/// The interactive tool's server: who may ask, and what survives.
#[cfg(feature = "serve")]
mod serve;
/// Sessions: undo, replay, and a file that loses nothing.
mod session;
/// Simulated worlds against their own claims.
mod simulate;
/// The solver by itself, against dense algebra.
mod solver;
/// Each stage of the pipeline by itself.
mod stages;
/// Where a correction would help most.
mod suggest;
/// Walks as maps, and maps as walks.
mod walk_maps;
/// Table 1's metric.
mod walls;
