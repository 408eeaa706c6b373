//! What one joint optimisation leaves for the next: memory, no numbers. Fresh pages cost as much as the steps.

use std::sync::{Mutex, PoisonError};

use super::problem::JointProblem;
use crate::solver::Solver;

/// A solver that waits for its next problem. Results do not depend on what it solved before.
#[derive(Debug, Default)]
pub struct Memory(Mutex<Solver>);

impl Clone for Memory {
    /// Memory of its own, still empty.
    fn clone(&self) -> Self {
        Memory::default()
    }
}

impl Memory {
    /// A solver ready for a problem; one of its own if this one is at work for somebody else.
    pub(super) fn solver(&self, problem: &JointProblem) -> Solver {
        let mut solver = self.0.try_lock().map(|mut s| std::mem::take(&mut *s)).unwrap_or_default();
        solver.analyse(problem, problem.block_count(), &problem.held);
        solver
    }

    /// Keeps a solver for the next problem.
    pub(super) fn keep(&self, solver: Solver) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = solver;
    }
}
