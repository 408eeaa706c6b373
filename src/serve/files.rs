//! Results, as files: every export, the session, the picture.

use std::fs;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::extract::State;
use axum::http::{Uri, header};
use axum::response::IntoResponse;

use super::app::App;
use super::wire::{Answer, Fault, aside};
use crate::error::{Error, Result};
use crate::io::{self, export};
use crate::render::{self, MapPictureOptions};

/// What the page can ask for, and the files' ending.
const FORMATS: [(&str, &str); 8] = [
    ("npz", "npz"),
    ("g2o", "g2o"),
    ("toro", "graph"),
    ("stfs", "stfs.covars"),
    ("tum", "tum"),
    ("clf", "clf"),
    ("ply", "ply"),
    ("pgm", "pgm"),
];

/// `GET /api/export?format=…`: the map as it stands, the corrections or the session. PGM comes with its YAML, zipped.
pub async fn export(State(app): State<Arc<App>>, uri: Uri) -> Answer {
    let wanted = uri.query().and_then(|q| q.split('&').find_map(|p| p.strip_prefix("format=")));
    let wanted = wanted.unwrap_or_default().to_owned();
    aside(app, move |app| {
        let desk = app.read();
        let session = &desk.as_ref().ok_or_else(Fault::nothing_open)?.session;
        let path = &session.source().path;
        let stem = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = stem.split('.').next().filter(|s| !s.is_empty()).unwrap_or("map").to_owned();
        match wanted.as_str() {
            "corrections" => {
                let lines = session.state().corrections.iter().map(io::corrections::to_json_line);
                let text: String = lines.map(|line| line + "\n").collect();
                return Ok(file(&format!("{stem}.corrections.jsonl"), text.into_bytes()));
            }
            "session" => {
                let bytes = fs::read(session.log_path()).map_err(|e| Error::io(session.log_path(), e))?;
                return Ok(file("session.jsonl", bytes));
            }
            _ => {}
        }
        let known = FORMATS.iter().find(|(name, _)| *name == wanted);
        let ending = known.ok_or_else(|| Fault::bad("format: expected one of those on the page"))?.1;
        let map = session.solved().map();
        drop(desk);
        let working = app.begin(format!("writing .{ending}"));
        let scratch = Scratch::new(&app.folder, app.number())?;
        let name = format!("{stem}-corrected.{ending}");
        let written = scratch.0.join(&name);
        export::write(&written, &map, &export::Options::default())?;
        let bytes = if ending == "pgm" {
            let yaml = io::occupancy::yaml_path(&written);
            return Ok(file(&format!("{stem}-corrected-pgm.zip"), zipped(&[&written, &yaml])?));
        } else {
            fs::read(&written).map_err(|e| Error::io(&written, e))?
        };
        drop(working);
        Ok(file(&name, bytes))
    })
    .await
}

/// `GET /api/picture`: before and after, PNG.
pub async fn picture(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let (before, after) = {
            let desk = app.read();
            let solved = desk.as_ref().ok_or_else(Fault::nothing_open)?.session.solved();
            (solved.source_map(), solved.map())
        };
        let png = render::before_after(&before, &after, &MapPictureOptions::default()).to_png();
        Ok(([(header::CONTENT_TYPE, "image/png")], png).into_response())
    })
    .await
}

fn file(name: &str, bytes: Vec<u8>) -> axum::response::Response {
    let safe: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{safe}\"")),
    ];
    (headers, bytes).into_response()
}

fn zipped(files: &[&Path]) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let mut fill = || -> std::io::Result<()> {
        let mut zip = zip::ZipWriter::new(&mut bytes);
        for file in files {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            zip.start_file(name, zip::write::SimpleFileOptions::default())?;
            zip.write_all(&fs::read(file)?)?;
        }
        zip.finish()?;
        Ok(())
    };
    fill().map_err(|e| Error::Internal(e.to_string()))?;
    Ok(bytes.into_inner())
}

/// A folder for files on their way out; removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(folder: &Path, number: u64) -> Result<Scratch> {
        let path = folder.join(format!(".export-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).map_err(|e| Error::io(&path, e))?;
        Ok(Scratch(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
        if let Some(folder) = self.0.parent() {
            // Only if nothing else is in it.
            let _ = fs::remove_dir(folder);
        }
    }
}
