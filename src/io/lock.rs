//! Files that one program at a time may have open.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::Duration;

use crate::error::{Error, Result};

/// So often a lock is tried, 20 ms apart.
const TRIES: usize = 10;

/// Takes the file for this program alone, until it is closed. Whoever held it may let go a moment later: a child process has its
/// own hold on it until it is a program of its own.
///
/// # Errors
///
/// [`Error::Input`] if another program has it; [`Error::Io`] if it cannot be locked.
pub fn alone(file: &File, path: &Path) -> Result<()> {
    for _ in 0..TRIES {
        match file.try_lock() {
            Ok(()) => return Ok(()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(20)),
            Err(TryLockError::Error(e)) => return Err(Error::io(path, e)),
        }
    }
    let message = "found that another hitl has it open, expected to be alone: close the other one";
    Err(Error::input(path.display(), message))
}
