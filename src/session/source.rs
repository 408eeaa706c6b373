//! Which map a session is about, and where the session's file lies.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::{Header, read};
use crate::error::{Error, Result};

/// A map's file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Where it is.
    pub path: PathBuf,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

impl Source {
    /// Reads the file for its sum.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read.
    pub fn of(path: &Path) -> Result<Source> {
        let mut sum = Sha256::new();
        let mut buffer = vec![0; 1 << 16];
        let mut file = File::open(path).map_err(|e| Error::io(path, e))?;
        loop {
            match file.read(&mut buffer).map_err(|e| Error::io(path, e))? {
                0 => break,
                n => sum.update(&buffer[..n]),
            }
        }
        let mut sha256 = String::with_capacity(64);
        for byte in sum.finalize() {
            // Writing to a string cannot fail.
            let _ = write!(sha256, "{byte:02x}");
        }
        Ok(Source { path: path.into(), sha256 })
    }

    /// The first line of a session about this map, to be written at `log`.
    pub fn header(&self, log: &Path) -> Header {
        let folder = |p: &Path| p.parent().map(Path::to_path_buf).unwrap_or_default();
        let map = if folder(log) == folder(&self.path) {
            PathBuf::from(self.path.file_name().unwrap_or_default())
        } else {
            std::path::absolute(&self.path).unwrap_or_else(|_| self.path.clone())
        };
        Header {
            version: env!("CARGO_PKG_VERSION").into(),
            map: map.display().to_string(),
            sha256: self.sha256.clone(),
        }
    }

    /// Refuses a session that is about another map.
    ///
    /// # Errors
    /// [`Error::Input`] at the session's first line.
    pub fn check(&self, header: &Header, log: &Path) -> Result<()> {
        if header.sha256 == self.sha256 {
            return Ok(());
        }
        let start = |sum: &str| sum.chars().take(12).collect::<String>();
        let message = format_args!(
            "sha256: found a session about {} ({}…), expected one about {} as it is now ({}…)",
            header.map,
            start(&header.sha256),
            self.path.file_name().unwrap_or_default().to_string_lossy(),
            start(&self.sha256)
        );
        Err(Error::line(log.display(), 1, message))
    }
}

/// True if a file is a session: its first line says so.
pub fn is_session(path: &Path) -> bool {
    let mut line = Vec::new();
    let Ok(file) = File::open(path) else { return false };
    BufReader::new(file).take(1 << 16).read_until(b'\n', &mut line).is_ok() && Header::parse(&line).is_ok()
}

/// Where the session of a map lies: `session.jsonl` beside it; if that is another map's, `MAP.session.jsonl`.
pub fn log_path(source: &Source) -> PathBuf {
    let plain = source.path.with_file_name("session.jsonl");
    let is_other = read(&plain).is_ok_and(|content| content.header.sha256 != source.sha256);
    if !is_other {
        return plain;
    }
    let name = source.path.file_name().unwrap_or_default().to_string_lossy();
    source.path.with_file_name(format!("{name}.session.jsonl"))
}
