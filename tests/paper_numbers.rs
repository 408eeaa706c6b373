//! The pages of results as committed: their summaries are there, and no row misses its bound.

use std::fs;
use std::path::Path;

/// The number that a cell begins with, `≤` and a typographic minus allowed.
fn number(cell: &str) -> f64 {
    let cell = cell.trim_start_matches('≤').trim().replace('−', "-");
    let text = cell.split_whitespace().next().unwrap_or_default();
    text.parse().unwrap_or_else(|_| panic!("no number in \"{cell}\""))
}

fn every_row_meets_its_bound(page: &str, least_rows: usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(page);
    let text = fs::read_to_string(path).expect("a page that `make results` writes");
    let summary = text.split("## ").find(|s| s.starts_with("Summary")).expect("a section \"Summary\"");
    let rows: Vec<Vec<&str>> = summary
        .lines()
        .filter(|l| l.starts_with('|'))
        .skip(2) // head and rule
        .map(|l| l.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= least_rows, "{page}: only {} rows", rows.len());
    for row in rows {
        let [claim, measured, bound, met, _] = row[..] else { panic!("{page}: {row:?}") };
        assert!(bound.starts_with('≤'), "{page}, {claim}: no upper bound in \"{bound}\"");
        assert!(number(measured) <= number(bound), "{page}, {claim}: {measured}, expected {bound}");
        assert_eq!(met, "yes", "{page}, {claim}");
    }
}

#[test]
fn every_row_of_the_summary_of_results_md_meets_its_bound() {
    every_row_meets_its_bound("RESULTS.md", 15);
}

#[test]
fn every_row_of_the_summary_of_results_pedestrian_md_meets_its_bound() {
    every_row_meets_its_bound("RESULTS-pedestrian.md", 8);
}
