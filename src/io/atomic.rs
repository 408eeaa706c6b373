//! Output files appear whole or not at all: written beside their place under a temporary name, then renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Creates `path` with what `fill` writes. If anything fails, `path` is as it was.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be made or the file cannot be written.
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    write_seekable(path, |out| fill(out))
}

/// Like [`write()`], for formats that come back to what they wrote (zip).
///
/// # Errors
/// As [`write()`].
pub fn write_seekable(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    let place = Place::of(path);
    let attempt = || -> io::Result<()> {
        if let Some(folder) = folder_of(path) {
            fs::create_dir_all(folder)?;
        }
        let mut out = BufWriter::with_capacity(1 << 20, File::create(place.temporary())?);
        fill(&mut out)?;
        let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        match &place {
            Place::File { temporary, target } => {
                file.sync_all()?;
                fs::rename(temporary, target)
            }
            Place::Device(_) => Ok(()),
        }
    };
    attempt().map_err(|source| {
        if let Place::File { temporary, .. } = &place {
            let _ = fs::remove_file(temporary);
        }
        Error::io(path, source)
    })
}

/// Checks that `path` can be written, before hours of work are done for it. Leaves nothing behind, makes no folder.
///
/// # Errors
/// [`Error::Input`] if `path` is a folder, lies in a file, or its folder cannot be written to.
pub fn check(path: &Path) -> Result<()> {
    if path.is_dir() || path.file_name().is_none() {
        return Err(Error::input(path.display(), "found a folder, expected the name of a file to write"));
    }
    let here = Path::new(".");
    let parents = path.ancestors().skip(1).map(|p| if p.as_os_str().is_empty() { here } else { p });
    let Some(nearest) = parents.into_iter().find(|p| p.exists()) else { return Ok(()) };
    if !nearest.is_dir() {
        let message = format!("found the file {}, expected a folder to write into", nearest.display());
        return Err(Error::input(path.display(), message));
    }
    if let Place::File { temporary, target } = Place::of(path) {
        let probe = if target.parent().is_some_and(Path::is_dir) {
            temporary
        } else {
            nearest.join(temporary.file_name().unwrap_or_default())
        };
        if let Err(e) = File::create(&probe).and_then(|_| fs::remove_file(&probe)) {
            let message =
                format!("found that no file can be made there ({e}), expected a folder to write into");
            return Err(Error::input(path.display(), message));
        }
    }
    Ok(())
}

/// Where the bytes go.
enum Place {
    /// A file: replaced as a whole. A link stays, and the file that it leads to is replaced.
    File { temporary: PathBuf, target: PathBuf },
    /// Something that is no file (`/dev/null`, a pipe): written to, never replaced.
    Device(PathBuf),
}

impl Place {
    fn of(path: &Path) -> Self {
        match fs::metadata(path) {
            Ok(found) if !found.is_file() && !found.is_dir() => Place::Device(path.to_path_buf()),
            found => {
                let is_link = found.is_ok() && path.is_symlink();
                let followed = if is_link { fs::canonicalize(path).ok() } else { None };
                let target = followed.unwrap_or_else(|| path.to_path_buf());
                Place::File { temporary: temporary_beside(&target), target }
            }
        }
    }

    fn temporary(&self) -> &Path {
        match self {
            Place::File { temporary, .. } => temporary,
            Place::Device(path) => path,
        }
    }
}

fn folder_of(path: &Path) -> Option<&Path> {
    path.parent().filter(|p| !p.as_os_str().is_empty())
}

fn temporary_beside(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}
