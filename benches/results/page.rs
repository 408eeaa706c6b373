//! What a section hands over, and the page that is made of them.

use std::fmt::Write;
use std::process::Command;

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// Aims that are known not to be reached yet, by what their claims' names contain: while they are missed they stand in a table
/// of their own, and not among the promises.
const AIMS: [&str; 4] = [
    "our CPU time, share of",
    "slip in the chain",
    "worst moment of the worst seed",
    "seen from the first walker's given start",
];

/// Something that is promised: a measured number and the most that it may be.
pub struct Claim {
    pub what: String,
    pub measured: f64,
    pub bound: f64,
    pub unit: &'static str,
    pub decimals: usize,
    /// Where the bound comes from.
    pub why: &'static str,
}

impl Claim {
    /// Judged as printed, so that a reader comes to the same verdict.
    fn is_met(&self) -> bool {
        let number = |v: f64| printed(v, self.decimals).parse::<f64>().unwrap_or(f64::NAN);
        number(self.measured) <= number(self.bound)
    }

    fn is_missed_aim(&self) -> bool {
        !self.is_met() && AIMS.iter().any(|aim| self.what.contains(aim))
    }

    fn row(&self) -> String {
        let met = if self.is_met() { "yes" } else { "**no**" };
        let Claim { what, measured, bound, unit, decimals, why } = self;
        let (measured, bound) = (printed(*measured, *decimals), printed(*bound, *decimals));
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let row = format!("| {what} | {measured}{unit} | ≤ {bound}{unit} | {met} | {why} |");
        row.replace(" -", " −")
    }
}

/// With so many decimals; in powers of ten what they could not show.
fn printed(value: f64, decimals: usize) -> String {
    let plain = format!("{value:.decimals$}");
    if value != 0.0 && plain.trim_matches(['-', '0', '.']).is_empty() {
        format!("{value:.1e}")
    } else {
        plain
    }
}

/// One chapter of the page.
#[derive(Default)]
pub struct Section {
    pub title: &'static str,
    /// Argument of the program that measures this section alone.
    pub name: &'static str,
    /// Markdown.
    pub body: String,
    pub claims: Vec<Claim>,
}

impl Section {
    pub fn text(&self) -> String {
        let Section { title, name, body, .. } = self;
        format!("## {title}\n\n`cargo bench --bench results -- {name}`\n\n{}\n", body.trim())
    }

    /// Rows of the claims, without or only those of missed aims.
    pub fn rows(&self, missed_aims: bool) -> String {
        let claims = self.claims.iter().filter(|c| c.is_missed_aim() == missed_aims);
        claims.fold(String::new(), |mut rows, claim| {
            let _ = writeln!(rows, "{}", claim.row());
            rows
        })
    }
}

/// The whole page.
pub fn page(sections: &[Section], seconds: f64) -> String {
    let rows: String = sections.iter().map(|s| s.rows(false)).collect();
    let missed: String = sections.iter().map(|s| s.rows(true)).collect();
    let missed = if missed.is_empty() {
        String::new()
    } else {
        format!(
            "## Aims not reached yet\n\n| aim | measured | bound | met | where the bound comes from |\n|---|---|---|---|---|\n{missed}\n"
        )
    };
    let chapters: Vec<String> = sections.iter().map(Section::text).collect();
    format!(
        "# Results\n\nWritten by `make results` (= `cargo bench --bench results`) in {seconds:.0} s; edit nothing here. {}\n\n\
         Every bound is an upper bound. ± is the 95 % interval of the mean (Student's t). ATE: RMSE of the positions after the \
         best SE(2) alignment.\n\n## Summary\n\n| claim | measured | bound | met | where the bound comes from |\n|---|---|---|---|---|\n{rows}\n{missed}{}",
        machine(),
        chapters.join("\n")
    )
}

/// What it was measured on.
pub fn machine() -> String {
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |line: &str| line.split(':').nth(1).map(|v| v.trim().to_owned());
    let model = cpus.lines().find(|l| l.starts_with("model name")).and_then(field);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "Machine: {}, {cores} cores shared with other work; {}; {}.",
        model.as_deref().unwrap_or("unknown CPU"),
        output_of("rustc", &["--version"]),
        output_of("date", &["+%F"]),
    )
}

fn output_of(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output();
    output.map_or(format!("{program} unknown"), |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
}

/// A file or folder of the project.
pub fn project(path: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}
