//! What only the compiler of Rust can show of programs with mistakes: its own errors, and that no other error follows.
//!
//! The messages of all files and their places are compared in `sve-macros/compiler/src/tests/messages.rs`.

use std::fs;
use std::path::Path;

/// Mistakes in the use of a system, and those that the compiler of Rust finds or that depend on what it does with the expansion.
const ALONE: [&str; 11] = [
    "language/constants_of_another_module",
    "language/misspelt_outer_constant",
    "language/mistake_without_prelude",
    "language/unknown_field",
    "parse/no_rules",
    "parse/on_a_function",
    "parse/on_a_struct",
    "parse/on_a_trait_impl",
    "parse/path_of_the_runtime_missing",
    "parse/two_attributes",
    "symmetry/name_is_taken",
];

#[test]
fn the_compiler_says_this_and_nothing_else() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("ui/use/*.rs");
    for name in ALONE {
        cases.compile_fail(format!("ui/{name}.rs"));
    }
    cases.compile_fail("ui/together.rs");
}

/// `ui/together.rs` has every file but those of `use` and those of `ALONE` as a module.
#[test]
fn every_other_file_is_compiled_with_the_rest() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("ui");
    let together = fs::read_to_string(root.join("together.rs")).expect("a file");
    let mut count = 0;
    for stage in [
        "constraint",
        "degenerate",
        "force",
        "language",
        "model",
        "noise",
        "parse",
        "rotation",
        "symmetry",
    ] {
        for entry in fs::read_dir(root.join(stage)).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_none_or(|end| end != "rs") {
                continue;
            }
            let name = path.file_stem().and_then(|name| name.to_str());
            let name = format!("{stage}/{}", name.expect("a name"));
            let is_alone = ALONE.contains(&name.as_str());
            let line = format!("#[path = \"{name}.rs\"]");
            assert_eq!(together.contains(&line), !is_alone, "{name}");
            count += 1;
        }
    }
    assert_eq!(together.matches("#[path").count(), count - ALONE.len());
}
