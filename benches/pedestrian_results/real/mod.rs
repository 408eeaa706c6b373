//! Real walks, where ../shared is: dead reckoning against measured footfalls and closed loops, maps of one floor by
//! several people.

mod humolire;
mod ktu;
mod mat;
mod xio;

use std::path::{Path, PathBuf};

use crate::page::Claim;

/// A folder of the shared data.
fn shared(name: &str) -> Option<PathBuf> {
    let path = crate::page::project("../shared/data").join(name);
    path.exists().then_some(path)
}

/// Dead reckoning against measured footfalls.
pub fn foot(text: &mut String) -> Vec<Claim> {
    where_it_is("foot_ktu", text, ktu::part)
}

/// Dead reckoning around closed loops.
pub fn foot_loops(text: &mut String) -> Vec<Claim> {
    where_it_is("foot_xio", text, xio::part)
}

/// One floor by three people.
pub fn phone(text: &mut String) -> Vec<Claim> {
    where_it_is("humolire", text, humolire::part)
}

fn where_it_is(name: &str, text: &mut String, part: fn(&Path, &mut String) -> Vec<Claim>) -> Vec<Claim> {
    let Some(folder) = shared(name) else {
        text.push_str(&format!("\nReal walks ({name}): not measured, ../shared is absent.\n"));
        return Vec::new();
    };
    part(&folder, text)
}
