//! What one joint optimisation leaves for the next: memory, no numbers. Fresh pages cost as much as the steps.

use std::sync::{Mutex, PoisonError};

use super::compiled::Relative;
use crate::solver::{Block, Solver};

/// Waits for the next problem. Results do not depend on what was solved before.
#[derive(Debug, Default)]
pub struct Memory(Mutex<Kept>);

/// What a solve works in.
#[derive(Debug, Default)]
pub(super) struct Kept {
    pub solver: Solver,
    pub relatives: Vec<Relative>,
    pub x: Vec<Block>,
}

impl Clone for Memory {
    /// Memory of its own, still empty.
    fn clone(&self) -> Self {
        Memory::default()
    }
}

impl Memory {
    /// What is there; empty if it is in use for somebody else.
    pub(super) fn take(&self) -> Kept {
        self.0.try_lock().map(|mut kept| std::mem::take(&mut *kept)).unwrap_or_default()
    }

    /// Keeps it for the next problem.
    pub(super) fn keep(&self, kept: Kept) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = kept;
    }
}
