//! What the tree may look like. The table of allowed dependencies is the one in ARCHITECTURE.md: read from there, so
//! that the page and the law are one.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below a folder with one of these endings, sorted.
fn files(folder: &str, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root().join(folder)];
    while let Some(path) = open.pop() {
        let Ok(entries) = fs::read_dir(&path) else { continue };
        for entry in entries.flatten().map(|e| e.path()) {
            let ending = entry.extension().unwrap_or_default().to_string_lossy().into_owned();
            if entry.is_dir() {
                open.push(entry);
            } else if endings.contains(&ending.as_str()) {
                found.push(entry);
            }
        }
    }
    found.sort();
    found
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// `| module | may use |` rows between the two markers of ARCHITECTURE.md.
fn allowed() -> BTreeMap<String, Vec<String>> {
    let page = text(&root().join("ARCHITECTURE.md"));
    let table = page.split("<!-- layers -->").nth(1).expect("ARCHITECTURE.md has no <!-- layers --> table");
    let names =
        |cell: &str| -> Vec<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
    let mut rules = BTreeMap::new();
    for row in table.lines().filter(|l| l.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').collect();
        for module in names(cells[1]) {
            rules.insert(module, names(cells[2]));
        }
    }
    rules
}

/// The top-level module that a file of `src/` belongs to.
fn module_of(path: &Path) -> String {
    let inner = path.strip_prefix(root().join("src")).expect("a file of src");
    let first = inner.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_owned()
}

#[test]
fn every_module_uses_only_what_architecture_md_allows() {
    let rules = allowed();
    let mut wrong = Vec::new();
    for path in files("src", &["rs"]) {
        let module = module_of(&path);
        if ["lib", "main", "error"].contains(&module.as_str()) {
            continue;
        }
        let Some(may_use) = rules.get(&module) else {
            wrong.push(format!(
                "{}: module `{module}` is not in the table of ARCHITECTURE.md",
                path.display()
            ));
            continue;
        };
        let prefix = if module == "cli" { "hitl_slam::" } else { "crate::" };
        for (number, line) in text(&path).lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            for rest in code.split(prefix).skip(1) {
                let used: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let known = rules.contains_key(&used) || used == "error";
                if known && used != module && used != "error" && !may_use.contains(&used) {
                    wrong.push(format!("{}:{}: `{module}` uses `{used}`", path.display(), number + 1));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn the_table_lists_every_module_and_no_other() {
    let mut modules: Vec<String> = files("src", &["rs"]).iter().map(|p| module_of(p)).collect();
    modules.sort();
    modules.dedup();
    modules.retain(|m| !["lib", "main", "error"].contains(&m.as_str()));
    assert_eq!(modules, allowed().into_keys().collect::<Vec<_>>());
}

#[test]
fn the_core_does_not_print_nor_look_at_its_surroundings() {
    let forbidden = ["println!", "eprintln!", "print!(", "dbg!(", "std::env", "clap::", "process::exit"];
    for path in files("src", &["rs"]).iter().filter(|p| !["cli", "main"].contains(&module_of(p).as_str())) {
        for (number, line) in text(path).lines().enumerate() {
            let found =
                forbidden.iter().find(|word| line.contains(*word) && !line.trim_start().starts_with("//"));
            assert!(found.is_none(), "{}:{}: {found:?}", path.display(), number + 1);
        }
    }
}

#[test]
fn no_file_is_longer_than_400_lines() {
    for folder in ["src", "tests", "cpp", "benches", "page/src", "page/tests"] {
        for path in files(folder, &["rs", "cc", "h", "ts", "mjs", "css"]) {
            let lines = text(&path).lines().count();
            assert!(lines <= 400, "{}: {lines} lines", path.display());
        }
    }
}

#[test]
fn nothing_is_left_open_and_nothing_panics_on_purpose_in_the_source() {
    let forbidden = ["todo!(", "unimplemented!(", "FIXME", "XXX", ".unwrap()", "panic!("];
    for path in files("src", &["rs"]) {
        for (number, line) in text(&path).lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let found = forbidden.iter().find(|word| code.contains(*word));
            assert!(found.is_none(), "{}:{}: {found:?}", path.display(), number + 1);
        }
    }
}
