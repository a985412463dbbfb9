//! Data goes one way: a file uses files of its own folder and of the floors below, never of a floor above.

use std::fs;
use std::path::{Path, PathBuf};

/// The folders and files at the root, from the lowest floor to the highest. A name that a floor re-exports belongs to it.
const FLOORS: [&str; 19] = [
    "errors",
    "settings",
    "algebra",
    "catalogue",
    "syntax",
    "model",
    "interpret",
    "system",
    "rules",
    "discretise",
    "structure",
    "linearise",
    "program",
    "derivation",
    "explain",
    "backend",
    "driver",
    "operations",
    "lib",
];

/// The files below a folder, but for those of tests.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let sources = paths.filter(|path| path.file_stem().is_none_or(|name| name != "tests"));
    sources
        .flat_map(|path| {
            if path.is_dir() {
                files(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

/// The floor of a module at the root.
fn floor(module: &str) -> usize {
    let found = FLOORS.iter().position(|&floor| floor == module);
    found.unwrap_or_else(|| panic!("`{module}` has no floor: give it a place in the list"))
}

/// The modules at the root that a text names in paths from `crate`.
fn used(text: &str) -> impl Iterator<Item = &str> {
    let before_tests = text.split("#[cfg(test)]\nmod tests").next().unwrap_or(text);
    let lines = before_tests.lines().map(str::trim_start);
    let code = lines.filter(|line| !line.starts_with("//"));
    let paths = code.flat_map(|line| line.split("crate::").skip(1));
    let words = paths.map(|path| {
        path.split(|c: char| !c.is_alphanumeric() && c != '_')
            .next()
    });
    words
        .flatten()
        .filter(|word| word.starts_with(char::is_lowercase))
}

#[test]
fn every_import_goes_down() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut imports = 0;
    for path in files(&root) {
        let inside = path.strip_prefix(&root).expect("below the root");
        let module = inside.iter().next().and_then(|part| part.to_str());
        let module = module.expect("a name").trim_end_matches(".rs");
        for used in used(&fs::read_to_string(&path).expect("a text")) {
            let goes_down = floor(used) <= floor(module);
            assert!(
                goes_down,
                "{} uses `{used}`, a floor above",
                inside.display()
            );
            imports += 1;
        }
    }
    assert!(imports > 500, "{imports}");
}
