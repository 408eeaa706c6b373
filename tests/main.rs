//! All integration tests, one binary.

mod building; // A made-up building with known truth.
mod metrics; // Errors against hand-computed values and naive twins.
mod render; // Pictures: right primitives in the right places, same bytes for the same input.
