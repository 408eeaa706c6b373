//! docs/RESULTS.md as committed: its summary is there, and no row misses its bound.

use std::fs;
use std::path::Path;

/// The number that a cell begins with, `≤` and a typographic minus allowed.
fn number(cell: &str) -> f64 {
    let cell = cell.trim_start_matches('≤').trim().replace('−', "-");
    let text = cell.split_whitespace().next().unwrap_or_default();
    text.parse().unwrap_or_else(|_| panic!("no number in \"{cell}\""))
}

#[test]
fn every_row_of_the_summary_of_results_md_meets_its_bound() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/RESULTS.md");
    let page = fs::read_to_string(path).expect("docs/RESULTS.md, which `make results` writes");
    let summary = page.split("## ").find(|s| s.starts_with("Summary")).expect("a section \"Summary\"");
    let rows: Vec<Vec<&str>> = summary
        .lines()
        .filter(|l| l.starts_with('|'))
        .skip(2) // head and rule
        .map(|l| l.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 15, "only {} rows", rows.len());
    for row in rows {
        let [claim, measured, bound, met, _] = row[..] else { panic!("{row:?}") };
        assert!(bound.starts_with('≤'), "{claim}: no upper bound in \"{bound}\"");
        assert!(number(measured) <= number(bound), "{claim}: {measured}, expected {bound}");
        assert_eq!(met, "yes", "{claim}");
    }
}
