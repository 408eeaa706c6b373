//! Everything that is tested from outside: one binary, so that it links once.

// Scratch folders, the shared data where they are, and seeded random maps.
mod support;

// Readers and writers: round trips, exact messages, every prefix of every format, the real logs.
mod formats;

// From a raw log to a map.
mod front_end;
