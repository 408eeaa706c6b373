//! What a live run keeps on disk: the lines it accepted, and what it answered. Append only.
//!
//! The accepted lines *are* the state: a run that was killed replays them and is where it was. Answers are checked
//! against those that were given before, so that nothing is answered in two ways. A line counts once its line end is
//! there; what lies behind the last line end is a leaving of a killed write and is dropped. Written without waiting for
//! the disk: this outlives the program however it ends; a power cut may take the last moments, of answers and lines alike.

use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{Read as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// File of the accepted lines, in the run's folder; the first line is a header.
pub const LINES: &str = "lines.jsonl";
/// File of the answers.
pub const ANSWERS: &str = "answers.jsonl";

/// The two files; made with the first accepted line.
#[derive(Debug)]
pub struct Journal {
    folder: PathBuf,
    header: String,
    files: Option<[Appended; 2]>,
}

/// What an earlier run left.
#[derive(Debug, Default)]
pub struct Kept {
    /// The accepted lines.
    pub lines: VecDeque<String>,
    /// What was answered.
    pub answers: VecDeque<String>,
}

impl Journal {
    /// Opens the journal of a folder, or prepares to begin one.
    ///
    /// # Errors
    /// [`Error::Input`] if another program has it open or it was begun with other settings; [`Error::Io`].
    pub fn open(folder: &Path, settings: &str) -> Result<(Journal, Kept)> {
        let header = serde_json::json!({
            "live": env!("CARGO_PKG_VERSION"), "settings": settings,
        })
        .to_string();
        let mut journal = Journal { folder: folder.into(), header, files: None };
        let path = folder.join(LINES);
        if !path.exists() {
            return Ok((journal, Kept::default()));
        }
        let (lines, mut kept) = Appended::open(&path)?;
        match kept.pop_front() {
            Some(found) if found != journal.header => {
                let message = format!(
                    "found a run of {found}, expected {}: give the same options, or another folder",
                    journal.header
                );
                return Err(Error::line(path.display(), 1, message));
            }
            Some(_) => {}
            // Killed while the header was written: begun anew.
            None => return Ok((journal, Kept::default())),
        }
        let (answers, answered) = Appended::open(&folder.join(ANSWERS))?;
        journal.files = Some([lines, answers]);
        Ok((journal, Kept { lines: kept, answers: answered }))
    }

    /// Keeps a line that was accepted.
    ///
    /// # Errors
    /// [`Error::Io`]; the line then does not count.
    pub fn accept(&mut self, line: &str) -> Result<()> {
        self.files()?[0].append(line)
    }

    /// Keeps an answer that was given.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn answer(&mut self, line: &str) -> Result<()> {
        self.files()?[1].append(line)
    }

    /// Forgets answers beyond the accepted lines: a power cut may have kept more of one file than of the other.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn forget(&mut self, answers: &VecDeque<String>) -> Result<()> {
        let bytes: usize = answers.iter().map(|a| a.len() + 1).sum();
        match &mut self.files {
            Some([_, file]) if bytes > 0 => file.shorten(bytes as u64),
            _ => Ok(()),
        }
    }

    fn files(&mut self) -> Result<&mut [Appended; 2]> {
        if self.files.is_none() {
            fs::create_dir_all(&self.folder).map_err(|e| Error::io(&self.folder, e))?;
            let (mut lines, _) = Appended::open(&self.folder.join(LINES))?;
            lines.append(&self.header)?;
            let (answers, _) = Appended::open(&self.folder.join(ANSWERS))?;
            self.files = Some([lines, answers]);
        }
        self.files.as_mut().ok_or_else(|| Error::Internal("no journal".into()))
    }
}

/// A file that only grows.
#[derive(Debug)]
struct Appended {
    path: PathBuf,
    file: File,
    end: u64,
}

impl Appended {
    fn open(path: &Path) -> Result<(Appended, VecDeque<String>)> {
        let io = |e| Error::io(path, e);
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(io)?;
        super::lock::alone(&file, path)?;
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(io)?;
        text.truncate(text.iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1));
        let end = text.len() as u64;
        file.set_len(end).map_err(io)?;
        let text = String::from_utf8(text)
            .map_err(|_| Error::input(path.display(), "found bytes that are no text, expected JSON lines"))?;
        Ok((Appended { path: path.into(), file, end }, text.lines().map(str::to_owned).collect()))
    }

    fn append(&mut self, line: &str) -> Result<()> {
        let bytes = [line.as_bytes(), b"\n"].concat();
        let write = |file: &mut File, end: u64| -> std::io::Result<()> {
            file.seek(SeekFrom::Start(end))?;
            file.write_all(&bytes)
        };
        if let Err(e) = write(&mut self.file, self.end) {
            let _ = self.file.set_len(self.end);
            return Err(Error::io(&self.path, e));
        }
        self.end += bytes.len() as u64;
        Ok(())
    }

    fn shorten(&mut self, bytes: u64) -> Result<()> {
        self.end = self.end.saturating_sub(bytes);
        self.file.set_len(self.end).map_err(|e| Error::io(&self.path, e))
    }
}
