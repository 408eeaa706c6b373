//! Who solves a joint problem.

use std::str::FromStr;

use super::problem::JointProblem;
use super::{Memory, Options, ceres, rust_backend};
use crate::error::{Error, Result};
use crate::solver::Report;

/// What this build can solve with, for `--version`: `rust, ceres 2.1.0`, or why Ceres is missing.
pub const BACK_ENDS: &str = env!("HITL_BACK_ENDS");

/// A solver of joint problems. Results never depend on the machine that built the program: the default is Rust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// [`crate::solver`].
    #[default]
    Rust,
    /// Ceres Solver, if it was there when the program was built.
    Ceres,
}

impl Backend {
    /// The name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Rust => "rust",
            Backend::Ceres => "ceres",
        }
    }

    /// True if this build can use it.
    pub fn available(self) -> bool {
        self == Backend::Rust || ceres::LINKED
    }

    /// Refuses a back end that this build does not have.
    ///
    /// # Errors
    /// [`Error::Input`] that says how to get it.
    pub fn require(self) -> Result<()> {
        if self.available() { Ok(()) } else { Err(ceres::absence()) }
    }

    /// Minimises the problem in place, from where it stands.
    ///
    /// # Errors
    /// [`Error::Input`] for a malformed problem or a back end that is not there; [`Error::Internal`] for a fault of
    /// the back end. Not to converge is no error: the report says so.
    pub fn solve(self, problem: &mut JointProblem, options: &Options) -> Result<Report> {
        self.solve_in(&Memory::default(), problem, options)
    }

    /// The same in memory that is there already (Ceres has its own).
    ///
    /// # Errors
    /// As [`Backend::solve`].
    pub fn solve_in(self, memory: &Memory, problem: &mut JointProblem, options: &Options) -> Result<Report> {
        match self {
            Backend::Rust => rust_backend::solve(memory, problem, &options.solver),
            Backend::Ceres => ceres::solve(problem, &options.solver, &options.ceres),
        }
    }
}

impl FromStr for Backend {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        [Backend::Rust, Backend::Ceres]
            .into_iter()
            .find(|b| b.name() == name)
            .ok_or_else(|| Error::input("solver", format!("found {name}, expected rust or ceres")))
    }
}
