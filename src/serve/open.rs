//! A map that is dropped on the page, or the demo.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use serde_json::json;
use tokio_stream::StreamExt;

use super::app::App;
use super::demo;
use super::wire::{Answer, Fault, answer, aside};
use crate::error::Error;
use crate::front_end;
use crate::map::{RawLog, SlamMap};
use crate::session::Source;

/// Largest map that is taken, bytes.
const MAX_MAP_BYTES: u64 = 2 << 30;
/// Carries the name of a dropped file, percent-encoded.
const NAME: &str = "x-hitl-name";
/// `scan-match`: a raw log begins as the chain of its matched scans, not of its odometry.
const START: &str = "x-hitl-start";

/// `POST /api/open`: the body is the file. If it is no map, it is thrown away and what was open stays.
pub async fn upload(State(app): State<Arc<App>>, headers: HeaderMap, body: Body) -> Answer {
    let name = headers.get(NAME).and_then(|v| v.to_str().ok()).unwrap_or_default();
    let name = safe_name(name)?;
    let is_matched = headers.get(START).is_some_and(|v| v == "scan-match");
    let folder = app.folder.clone();
    let arriving = folder.join(format!(".arriving-{}-{}", std::process::id(), app.number()));
    let arrived = receive(&folder, &arriving, body).await;
    let result = match arrived {
        Ok(()) => {
            let arriving = arriving.clone();
            aside(app, move |app| take(app, &arriving, &name, is_matched)).await
        }
        Err(fault) => Err(fault),
    };
    let _ = fs::remove_file(&arriving);
    let _ = fs::remove_dir(&folder);
    result
}

/// `POST /api/demo`: the ACES building.
pub async fn demo(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let path = app.folder.join(demo::NAME);
        fs::create_dir_all(&app.folder).map_err(|e| Error::io(&app.folder, e))?;
        if !fs::read(&path).is_ok_and(|bytes| bytes == demo::LOG) {
            crate::io::atomic::write(&path, |out| out.write_all(demo::LOG))?;
        }
        app.open(&path, None)?;
        Ok(answer(&json!({"path": path.display().to_string()})))
    })
    .await
}

/// A file name as it came, if it is one: no path, nothing hidden.
fn safe_name(given: &str) -> Result<String, Fault> {
    let refuse = || Fault::bad("file name: found a path or a strange name, expected a plain file name");
    let mut bytes = Vec::new();
    let mut rest = given.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digits = [rest.next(), rest.next()].map(|d| d.and_then(|d| char::from(d).to_digit(16)));
            let [Some(high), Some(low)] = digits else { return Err(refuse()) };
            bytes.push((high * 16 + low) as u8);
        } else {
            bytes.push(byte);
        }
    }
    let name = String::from_utf8(bytes).map_err(|_| refuse())?;
    let is_strange = name.is_empty()
        || name.len() > 200
        || name.starts_with('.')
        || name.chars().any(|c| c.is_control() || "/\\:*?\"<>|".contains(c));
    if is_strange { Err(refuse()) } else { Ok(name) }
}

async fn receive(folder: &Path, arriving: &Path, body: Body) -> Result<(), Fault> {
    let failed = |e: std::io::Error| Fault::from(Error::io(arriving, e));
    fs::create_dir_all(folder).map_err(failed)?;
    let mut file = BufWriter::new(File::create(arriving).map_err(failed)?);
    let (mut stream, mut size) = (body.into_data_stream(), 0);
    while let Some(chunk) = stream.next().await {
        let chunk = chunk.map_err(|e| Fault::bad(format!("the file did not arrive whole: {e}")))?;
        size += chunk.len() as u64;
        if size > MAX_MAP_BYTES {
            return Err(Fault::new(StatusCode::PAYLOAD_TOO_LARGE, "found more than 2 GiB, expected less"));
        }
        file.write_all(&chunk).map_err(failed)?;
    }
    file.flush().map_err(failed)
}

/// Gives the file its place, unless the very same is there, and opens it; of a raw log, if wanted, the map of its matched
/// scans, which is then written beside it.
fn take(app: &App, arrived: &Path, name: &str, is_matched: bool) -> Answer {
    let renamed = |e: Error| match e {
        // The person knows the file by its own name.
        Error::Input { place, message } => {
            Error::Input { place: place.replace(&arrived.display().to_string(), name), message }
        }
        other => other,
    };
    let (_, read) = crate::io::read(arrived).map_err(renamed)?;
    if let (crate::io::Source::Log(log), true) = (read.value, is_matched) {
        let map = matched(app, &log, name)?;
        crate::io::native::write(arrived, &map)?;
        let stem = name.split('.').next().filter(|s| !s.is_empty()).unwrap_or("map");
        return settle(app, arrived, &format!("{stem}-matched.npz"));
    }
    crate::front_end::open(arrived, crate::io::Indefinite::Refuse).map_err(renamed)?;
    settle(app, arrived, name)
}

/// The chain of a log's matched scans.
fn matched(app: &App, log: &RawLog, name: &str) -> Result<SlamMap, Fault> {
    let working = app.begin(format!("matching the scans of {name}"));
    let options = front_end::Options::for_scan_matching();
    let (of, cancelled) = (log.scans.len(), AtomicBool::new(false));
    // Every scan is looked at twice.
    let before = AtomicUsize::new(0);
    let progress = |done: usize| {
        let all = before.load(Ordering::Relaxed) + done;
        if done == of {
            before.store(of, Ordering::Relaxed);
        }
        if !working.progress(all, 2 * of) {
            cancelled.store(true, Ordering::Relaxed);
        }
    };
    let map = front_end::scan_matched(log, &options, &progress, &cancelled)?;
    map.ok_or_else(|| Fault::new(StatusCode::CONFLICT, "given up: nothing has changed"))
}

/// Gives a sound file its place and opens it.
fn settle(app: &App, arrived: &Path, name: &str) -> Answer {
    let sum = Source::of(arrived)?.sha256;
    let path = (1..).find_map(|k| {
        let path = app.folder.join(numbered(name, k));
        let is_same = || Source::of(&path).is_ok_and(|s| s.sha256 == sum);
        (!path.exists() || is_same()).then_some(path)
    });
    let path: PathBuf = path.ok_or_else(|| Fault::bad("file name: found no free one"))?;
    let is_new = !path.exists();
    if is_new {
        fs::rename(arrived, &path).map_err(|e| Error::io(&path, e))?;
    }
    if let Err(error) = app.open(&path, None) {
        if is_new {
            let _ = fs::remove_file(&path);
        }
        return Err(error.into());
    }
    Ok(answer(&json!({"path": path.display().to_string()})))
}

/// `map.npz`, `map-2.npz`, …
fn numbered(name: &str, k: usize) -> String {
    match (k, name.split_once('.')) {
        (1, _) => name.into(),
        (k, Some((stem, ending))) => format!("{stem}-{k}.{ending}"),
        (k, None) => format!("{name}-{k}"),
    }
}
