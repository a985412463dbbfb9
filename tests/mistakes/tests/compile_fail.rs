//! Errors that only the compiler of Rust shows in programs with mistakes; no other error follows
//! those of the macro.
//!
//! The messages of the macro and their places are compared in
//! `sve-macros/compiler/src/tests/messages.rs`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use sve_tests_mistakes::tables;

/// Writes all cases of the tables as modules of one program, and beside it the errors that the
/// compiler of Rust has to report. Returns the path of the program.
fn all_cases() -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("all_cases.rs");
    let name = path.to_str().expect("a path").to_owned();
    let (mut program, mut errors) = (String::new(), Vec::new());
    for table in tables() {
        for case in table.cases() {
            writeln!(program, "mod {}_{} {{", table.name, case.name).expect("text");
            errors.extend(case.printed(&name, program.lines().count()));
            writeln!(program, "{}}}", case.source()).expect("text");
        }
    }
    program += "fn main() {}\n";
    fs::write(&path, program).expect("a file");
    fs::write(path.with_extension("stderr"), errors.join("\n")).expect("a file");
    name
}

#[test]
fn the_compiler_says_this_and_nothing_else() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("ui/*.rs");
    cases.compile_fail(all_cases());
}
