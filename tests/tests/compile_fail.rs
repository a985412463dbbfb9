//! Mistakes, each in a file named after it: the message, its place, and that it is the only one.

#[test]
fn compile_fail() {
    let cases = trybuild::TestCases::new();
    for stage in [
        "parse", "language", "model", "noise", "force", "symmetry", "use",
    ] {
        cases.compile_fail(format!("ui/{stage}/*.rs"));
    }
}
