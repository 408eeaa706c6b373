//! The one error type of the library: what was wrong, where, and what was expected instead.
//!
//! Bad input is [`Error::Input`]: one line `place: found …, expected …`. The command line maps it to exit code 2.
//! [`Error::Internal`] is a fault of ours (exit code 3). A correction that cannot be applied is *not* an error:
//! it is a rejected correction with a reason (see [`crate::pipeline`]).

use std::fmt;
use std::io::ErrorKind;
use std::path::Path;

/// What went wrong.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// Something the user gave is not as it should be. `place` is `file:line` or `file: field`.
    Input {
        /// Where: a file with its line or field, or the name of an option.
        place: String,
        /// What was found and what was expected.
        message: String,
    },
    /// The operating system refused to read or write.
    Io {
        /// The file or folder concerned.
        path: String,
        /// The system's own words.
        source: std::io::Error,
    },
    /// A fault of this program.
    Internal(String),
}

/// Result with the library's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Bad input at a place such as `log.clf:12` or `--sigma-m`.
    pub fn input(place: impl fmt::Display, message: impl fmt::Display) -> Self {
        Error::Input { place: place.to_string(), message: message.to_string() }
    }

    /// Bad input on a line of a text file, counted from 1.
    pub fn line(file: impl fmt::Display, line: usize, message: impl fmt::Display) -> Self {
        Error::input(format_args!("{file}:{line}"), message)
    }

    /// A failed read or write of `path`.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Error::Io { path: path.display().to_string(), source }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Input { place, message } => write!(f, "{place}: {message}"),
            Error::Io { path, source } => match source.kind() {
                ErrorKind::NotFound => write!(f, "{path}: found no such file, expected one that exists"),
                ErrorKind::IsADirectory => write!(f, "{path}: found a folder, expected a file"),
                ErrorKind::NotADirectory => {
                    write!(f, "{path}: found a file within this path, expected folders")
                }
                ErrorKind::PermissionDenied => {
                    write!(f, "{path}: found no permission, expected to be allowed")
                }
                _ => {
                    write!(f, "{path}: found a failing system call ({source}), expected to read or write it")
                }
            },
            Error::Internal(message) => write!(f, "internal error: {message}"),
        }
    }
}

impl std::error::Error for Error {}
