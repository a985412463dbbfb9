//! Data goes one way: a file uses files of its own folder and of lower floors, never of a higher
//! floor.

use std::fs;
use std::path::{Path, PathBuf};

/// The folders and files at the root of the compiler, from the lowest floor to the highest. A name
/// that a floor re-exports belongs to it.
const COMPILER: &[&str] = &[
    "errors",
    "settings",
    "algebra",
    "catalogue",
    "syntax",
    "model",
    "interpret",
    "scene",
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

/// The folders and files at the root of the runtime.
const RUNTIME: &[&str] = &[
    "angle_addition",
    "power",
    "progress",
    "parameter",
    "readable",
    "time",
    "file",
    "blocking",
    "neighbours",
    "floats",
    "solve",
    "lanes",
    "phase",
    "error",
    "system",
    "mechanics",
    "gauss",
    "noise",
    "rule",
    "scene",
    "method",
    "integrator",
    "fingerprint",
    "table",
    "trajectory",
    "lyapunov",
    "baseline",
    "description",
    "ensemble",
    "study",
    "plot",
    "guide",
    "__private",
    "lib",
];

/// Returns the files below a folder, except tests.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let is_source = |path: &PathBuf| {
        let name = path.file_stem().and_then(|name| name.to_str());
        !name.expect("a name").ends_with("tests")
    };
    paths
        .filter(is_source)
        .flat_map(|path| match path.extension() {
            None => files(&path),
            Some(_) if path.extension().is_some_and(|name| name == "rs") => vec![path],
            Some(_) => Vec::new(),
        })
        .collect()
}

/// Returns the modules at the root that a text names in paths from `crate`. A path to a name of the
/// root itself counts as one to `lib`, and so does a group of names, whose floors are not looked
/// up.
fn used(text: &str) -> impl Iterator<Item = &str> {
    let before_tests = text.split("#[cfg(test)]\nmod tests").next().unwrap_or(text);
    let lines = before_tests.lines().map(str::trim_start);
    let code = lines.filter(|line| !line.starts_with("//") && !line.starts_with("#[doc"));
    let paths = code.flat_map(|line| {
        let is_import = line.starts_with("use ") || line.starts_with("pub use ");
        let paths = line.split("crate::").skip(1);
        paths.map(move |path| (path, is_import))
    });
    paths.filter_map(|(path, is_import)| {
        let end = path.find(|c: char| !c.is_alphanumeric() && c != '_');
        let word = &path[..end.unwrap_or(path.len())];
        match word.chars().next() {
            Some(first) if first.is_lowercase() => Some(word),
            Some(_) => Some("lib"),
            None if is_import => Some("lib"),
            // a text of a message
            None => None,
        }
    })
}

/// Checks the imports of a crate. `least` is a lower bound of their number.
fn assert_imports_go_down(root: &str, floors: &[&str], least: usize) {
    let floor = |module: &str| {
        let found = floors.iter().position(|&floor| floor == module);
        found.unwrap_or_else(|| panic!("`{module}` has no floor: give it a place in the list"))
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
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
    assert!(imports > least, "{imports}");
}

#[test]
fn every_import_of_the_compiler_goes_down() {
    assert_imports_go_down("src", COMPILER, 500);
}

#[test]
fn every_import_of_the_runtime_goes_down() {
    assert_imports_go_down("../../sve-runtime/src", RUNTIME, 800);
}
