//! Chapters that were measured, kept in `target/results`, so that a page can be renewed chapter by chapter.

use std::path::PathBuf;

use crate::page::{Claim, Result, Section, project};

/// A chapter as it was measured, and what that took.
pub struct Measured {
    pub section: Section,
    pub seconds: f64,
}

/// Keeps a chapter for later pages.
///
/// # Errors
///
/// If the file cannot be written.
pub fn keep(page: &str, name: &str, measured: &Measured) -> Result<()> {
    let Measured { section, seconds } = measured;
    let claims: Vec<_> =
        section.claims.iter().map(|c| (&c.what, c.measured, c.bound, c.unit, c.decimals, c.why)).collect();
    let text = serde_json::to_string(&(section.title, section.name, &section.body, claims, seconds))?;
    let path = path(page, name);
    std::fs::create_dir_all(path.with_file_name(""))?;
    Ok(std::fs::write(path, text)?)
}

/// A chapter as it was last measured here.
///
/// # Errors
///
/// If it was not.
pub fn last(page: &str, name: &str) -> Result<Measured> {
    type Row = (String, f64, f64, String, usize, String);
    let text = std::fs::read_to_string(path(page, name))
        .map_err(|e| format!("chapter \"{name}\" was not measured here yet: {e}"))?;
    let (title, name, body, rows, seconds): (String, String, String, Vec<Row>, f64) =
        serde_json::from_str(&text)?;
    let claims = rows.into_iter().map(|(what, measured, bound, unit, decimals, why)| Claim {
        what,
        measured,
        bound,
        unit: unit.leak(),
        decimals,
        why: why.leak(),
    });
    // A few names, once in the life of the program: the types of a page are made for constants.
    let section = Section { title: title.leak(), name: name.leak(), body, claims: claims.collect() };
    Ok(Measured { section, seconds })
}

fn path(page: &str, name: &str) -> PathBuf {
    project("target/results").join(format!("{page}-{name}.json"))
}
