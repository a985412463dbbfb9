//! The cost of compiling a scene: times of `cargo check` and `cargo build --release` of a crate
//! that contains only the scene, with its dependencies already built; and the time of a step of the
//! program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The folder in which crates are written and built.
const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// The root of the workspace.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A crate that holds one scene at a time.
pub(super) struct Crate {
    root: PathBuf,
}

/// Times in seconds; the time of a step in nanoseconds.
pub(super) struct Built {
    pub(super) check: f64,
    pub(super) release: f64,
    pub(super) step: f64,
}

impl Crate {
    /// Returns a crate whose dependencies are built.
    pub(super) fn new() -> Result<Self, String> {
        let root = Path::new(SCRATCH).join("scene");
        let runtime = Path::new(ROOT).join("sve-runtime");
        let manifest = format!(
            "[package]\nname = \"scene\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\nsve-runtime = {{ path = \"{}\" }}\n\n[workspace]\n",
            runtime.display()
        );
        let written = fs::create_dir_all(root.join("src"))
            .and_then(|()| fs::write(root.join("Cargo.toml"), manifest))
            .and_then(|()| fs::copy(Path::new(ROOT).join("Cargo.lock"), root.join("Cargo.lock")));
        written.map_err(|error| format!("{}: {error}", root.display()))?;
        let built = Self { root };
        built.write("fn main() {}")?;
        built.cargo(&["check"])?;
        built.cargo(&["build", "--release"])?;
        Ok(built)
    }

    /// Builds and runs a program.
    pub(super) fn build(&self, program: &str) -> Result<Built, String> {
        self.write(program)?;
        let check = self.cargo(&["check"])?;
        let release = self.cargo(&["build", "--release"])?;
        let step = output(&mut Command::new(self.root.join("target/release/scene")))?;
        let step = step
            .trim()
            .parse()
            .map_err(|_| format!("not a time: {step}"))?;
        Ok(Built {
            check,
            release,
            step,
        })
    }

    fn write(&self, program: &str) -> Result<(), String> {
        fs::write(self.root.join("src/main.rs"), program).map_err(|error| error.to_string())
    }

    /// Returns the seconds that a command of cargo takes.
    fn cargo(&self, arguments: &[&str]) -> Result<f64, String> {
        let mut command = Command::new("cargo");
        command
            .args(arguments)
            .args(["--quiet", "--target-dir", "target"])
            .current_dir(&self.root);
        let start = Instant::now();
        output(&mut command)?;
        Ok(start.elapsed().as_secs_f64())
    }
}

/// Returns the output of this benchmark when it is compiled without optimisation, as macros are in
/// a user's build.
pub(super) fn unoptimised(arguments: &[String]) -> Result<String, String> {
    let mut command = Command::new("cargo");
    command
        .args([
            "bench",
            "--quiet",
            "-p",
            "sve-compiler",
            "--bench",
            "expansion",
        ])
        .args(["--config", "profile.bench.opt-level=0"])
        .arg("--target-dir")
        .arg(Path::new(SCRATCH).join("unoptimised"))
        .args(["--", "--times"])
        .args(arguments)
        .current_dir(ROOT);
    output(&mut command)
}

/// Returns the number of lines of tokens, with one line for each statement and two for each block.
/// The formatter itself overflows its stack on large systems.
pub(super) fn lines(tokens: TokenStream) -> usize {
    let of_tree = |tree| match tree {
        TokenTree::Punct(mark) => usize::from(mark.as_char() == ';'),
        TokenTree::Group(group) => {
            let braces = group.delimiter() == Delimiter::Brace;
            2 * usize::from(braces) + lines(group.stream())
        }
        _ => 0,
    };
    tokens.into_iter().map(of_tree).sum()
}

/// Returns the standard output of a command.
fn output(command: &mut Command) -> Result<String, String> {
    let described = format!("{command:?}");
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("{described}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{described}: {}", output.status))
    }
}
