//! Text files as streams of lines, decompressed on the way.
//!
//! gzip, bzip2 and xz are recognised by their first bytes, whatever the name says; concatenated streams are read to
//! the end. The file is never held in memory: one line at a time, and a line has at most [`MAX_LINE_BYTES`].

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use crate::error::{Error, Result};

/// Longer lines are not text; the bound keeps a binary file from filling the memory.
pub(crate) const MAX_LINE_BYTES: u64 = 1 << 20;

/// The lines of a text file, with their numbers.
pub(crate) struct Lines {
    file: String,
    reader: Box<dyn BufRead>,
    buffer: Vec<u8>,
    number: usize,
    cut_off: bool,
}

impl Lines {
    /// Opens a text file, compressed or not.
    pub fn open(path: &Path) -> Result<Self> {
        let mut reader = BufReader::with_capacity(1 << 16, File::open(path).map_err(|e| Error::io(path, e))?);
        let head = reader.fill_buf().map_err(|e| Error::io(path, e))?;
        let decoded: Box<dyn BufRead> = if head.starts_with(&[0x1f, 0x8b]) {
            Box::new(buffered(flate2::bufread::MultiGzDecoder::new(reader)))
        } else if head.starts_with(b"BZh") {
            Box::new(buffered(bzip2::bufread::MultiBzDecoder::new(reader)))
        } else if head.starts_with(b"\xfd7zXZ\0") {
            Box::new(buffered(lzma_rust2::XzReader::new(reader, true)))
        } else {
            Box::new(reader)
        };
        let file = path.display().to_string();
        Ok(Lines { file, reader: decoded, buffer: Vec::new(), number: 0, cut_off: false })
    }

    /// Reads the next line; false at the end of the file. The line is then [`Lines::line`].
    pub fn advance(&mut self) -> Result<bool> {
        self.buffer.clear();
        self.number += 1;
        let read = self.reader.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut self.buffer);
        match read {
            Ok(0) => Ok(false),
            Ok(n) if n as u64 == MAX_LINE_BYTES && !self.buffer.ends_with(b"\n") => {
                Err(self.error("found a line of more than 1 MiB, expected a text file"))
            }
            Ok(_) => {
                self.cut_off = !self.buffer.ends_with(b"\n");
                while matches!(self.buffer.last(), Some(b'\n' | b'\r')) {
                    self.buffer.pop();
                }
                Ok(true)
            }
            Err(e) => {
                Err(self.error(format_args!("found damaged or cut-off data ({e}), expected more text")))
            }
        }
    }

    /// The current line without its end.
    pub fn line(&self) -> &[u8] {
        &self.buffer
    }

    /// Number of the current line, from 1.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The name of the file, for messages.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// An error on the current line.
    pub fn error(&self, message: impl std::fmt::Display) -> Error {
        Error::line(&self.file, self.number, message)
    }

    /// An error on an earlier line.
    pub fn error_at(&self, number: usize, message: impl std::fmt::Display) -> Error {
        Error::line(&self.file, number, message)
    }

    /// An error of the file as a whole.
    pub fn file_error(&self, message: impl std::fmt::Display) -> Error {
        Error::input(&self.file, message)
    }

    /// A remark about the current line.
    pub fn remark(&self, message: impl std::fmt::Display) -> String {
        format!("{}:{}: {message}", self.file, self.number)
    }

    /// A remark if the last line has no line end: the only trace that a cut inside the last number leaves.
    pub fn cut_off_remark(&self) -> Option<String> {
        self.cut_off
            .then(|| format!("{}: the last line has no line end: the file may have been cut off", self.file))
    }
}

fn buffered(reader: impl Read + 'static) -> impl BufRead + 'static {
    BufReader::with_capacity(1 << 16, reader)
}
