//! The file: append only, every event on disk before it counts, one writer at a time.

use std::fs::{self, File, OpenOptions};
use std::io::{Read as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::{Entry, Header, History};
use crate::error::{Error, Result};
use crate::io::lock;

/// A session's file, open for more.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
    /// Where the last whole event ends. What lies behind it is a leaving of a failed write.
    end: u64,
}

/// What stands in a session's file.
#[derive(Debug, Clone, PartialEq)]
pub struct Content {
    /// Its first line.
    pub header: Header,
    /// The rest.
    pub entries: Vec<Entry>,
    /// That a cut-off last line was left out, if there was one.
    pub remark: Option<String>,
    lines: Vec<usize>,
    whole: u64,
}

/// Reads a session. An event counts once its line end is there: a cut-off last line was never acknowledged.
///
/// # Errors
/// [`Error::Input`] at `file:line`; [`Error::Io`] if it cannot be read.
pub fn read(path: &Path) -> Result<Content> {
    let mut text = Vec::new();
    File::open(path).and_then(|mut f| f.read_to_end(&mut text)).map_err(|e| Error::io(path, e))?;
    content(path, &text)
}

fn content(path: &Path, text: &[u8]) -> Result<Content> {
    let whole = text.iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
    let remark = (whole < text.len()).then(|| {
        let line = text[..whole].iter().filter(|&&b| b == b'\n').count() + 1;
        format!("{}:{line}: dropped a cut-off last line: it was never acknowledged", path.display())
    });
    let mut header = None;
    let (mut entries, mut lines) = (Vec::new(), Vec::new());
    for (k, line) in text[..whole].split(|&b| b == b'\n').enumerate() {
        if line.trim_ascii().is_empty() {
            continue;
        }
        let fault = |message| Error::line(path.display(), k + 1, message);
        if header.is_none() {
            header = Some(Header::parse(line).map_err(fault)?);
        } else {
            entries.push(Entry::parse(line).map_err(fault)?);
            lines.push(k + 1);
        }
    }
    let header = header.ok_or_else(|| {
        Error::input(path.display(), "found no whole line, expected a session: its first line names the map")
    })?;
    Ok(Content { header, entries, remark, lines, whole: whole as u64 })
}

impl Content {
    /// What the events leave.
    ///
    /// # Errors
    /// The line of an event that cannot have happened, and why.
    pub fn history(&self) -> std::result::Result<History, (usize, String)> {
        let mut history = History::default();
        for (k, entry) in self.entries.iter().enumerate() {
            history.take(&entry.event).map_err(|message| (self.lines[k], message))?;
        }
        Ok(history)
    }
}

impl Log {
    /// Opens a session to go on with, or begins one. A cut-off last line is removed from the file.
    ///
    /// # Errors
    /// [`Error::Input`] if another program has it open or it is no session; [`Error::Io`] if it cannot be written.
    pub fn open(path: &Path, begin: &Header) -> Result<(Log, Content)> {
        let io = |e| Error::io(path, e);
        let unwritable = |e| {
            let message = format_args!(
                "found that it cannot be written ({e}), expected a place to write to: --session names another"
            );
            Error::input(path.display(), message)
        };
        if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
            fs::create_dir_all(folder).map_err(unwritable)?;
        }
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = options.map_err(unwritable)?;
        lock::alone(&file, path)?;
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(io)?;
        let mut log = Log { path: path.into(), file, end: 0 };
        if !text.contains(&b'\n') {
            // New, or killed while its first line was written.
            log.line(&begin.to_line())?;
            sync_folder(path);
            let header = begin.clone();
            let content = Content { header, entries: Vec::new(), remark: None, lines: Vec::new(), whole: 0 };
            return Ok((log, content));
        }
        let content = content(path, &text)?;
        log.end = content.whole;
        log.file.set_len(log.end).map_err(io)?;
        Ok((log, content))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends an event. When this returns without an error, the event is on disk.
    ///
    /// # Errors
    /// [`Error::Io`]; the event then does not count, also not after a restart.
    pub fn append(&mut self, entry: &Entry) -> Result<()> {
        self.line(&entry.to_line())
    }

    fn line(&mut self, line: &str) -> Result<()> {
        let bytes = [line.as_bytes(), b"\n"].concat();
        let mut write = || -> std::io::Result<()> {
            self.file.set_len(self.end)?;
            self.file.seek(SeekFrom::Start(self.end))?;
            self.file.write_all(&bytes)?;
            self.file.sync_data()
        };
        if let Err(e) = write() {
            let _ = self.file.set_len(self.end);
            return Err(Error::io(&self.path, e));
        }
        self.end += bytes.len() as u64;
        Ok(())
    }
}

/// Makes a new file's name last through a power cut, where the system can do that.
fn sync_folder(path: &Path) {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
