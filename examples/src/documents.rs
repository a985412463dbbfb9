//! What the documents of the project say of it, compared with the project: numbers, paths, the plan of the readme's first example.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use sve_runtime::prelude::*;

/// Kubo oscillator: a rotation whose speed is noisy.
#[derive(Clone, Debug)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0].powi(2) / (2.0 * self.a) - self.a / 2.0 * q[0].powi(2)
    }

    #[h1]
    fn jitter(&self, q: [f64; 1], p: [f64; 1]) -> f64 {
        self.sigma / 2.0 * (q[0].powi(2) + p[0].powi(2))
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    let text = fs::read_to_string(root().join(path));
    text.unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The numbers of `docs/numbers/README.md`: rows "| `name` | value | what |".
fn numbers(page: &str) -> HashMap<&str, &str> {
    let number = |line: &'_ str| -> Option<(usize, usize, usize)> {
        let rest = line.strip_prefix("| `")?;
        let name = rest.find("` | ")?;
        let value = rest[name + 4..].find(" | ")?;
        Some((3, name, value))
    };
    let row = |line| {
        let (start, name, value) = number(line)?;
        let after = start + name + 4;
        Some((&line[start..start + name], &line[after..after + value]))
    };
    page.lines().filter_map(row).collect()
}

/// A template with `{name}` replaced by its value.
fn filled(template: &str, numbers: &HashMap<&str, &str>) -> String {
    let mut text = String::new();
    let mut parts = template.split('{');
    text.push_str(parts.next().unwrap_or_default());
    for part in parts {
        let (name, rest) = part.split_once('}').expect("a closed brace");
        let value = numbers.get(name);
        text.push_str(
            value.unwrap_or_else(|| panic!("no number {name} in docs/numbers/README.md")),
        );
        text.push_str(rest);
    }
    text
}

#[test]
fn the_readme_quotes_the_numbers_that_were_measured() {
    let (readme, page, quotes) = (
        read("README.md"),
        read("docs/numbers/README.md"),
        read("docs/numbers/quotes.md"),
    );
    let numbers = numbers(&page);
    assert!(numbers.len() > 100, "{} numbers", numbers.len());
    let mut templates = HashMap::new();
    for part in quotes.split("\n## ").skip(1) {
        let (name, template) = part.split_once('\n').expect("a part with a body");
        templates.insert(name.trim(), template.trim());
    }
    let mut quoted = Vec::new();
    for part in readme.split("<!-- numbers: ").skip(1) {
        let (name, rest) = part.split_once(" -->\n").expect("a marker");
        let (body, _) = rest
            .split_once("\n<!-- end of numbers -->")
            .expect("the end of a quote");
        let template = templates
            .get(name)
            .unwrap_or_else(|| panic!("no part {name} in docs/numbers/quotes.md"));
        assert_eq!(
            body,
            filled(template, &numbers),
            "{name}: run `docs/numbers/run --quote`"
        );
        quoted.push(name);
    }
    assert_eq!(quoted.len(), templates.len(), "quoted are {quoted:?}");
}

#[test]
fn the_readme_shows_the_plan_of_its_example() {
    let kubo = Integrator::new(Kubo { a: 1.0, sigma: 1.0 }, Midpoint);
    let plan = kubo.plan().to_string();
    let readme = read("README.md");
    assert!(
        readme.contains(&format!("```text\n{}\n```", plan.trim_end())),
        "the readme's plan is not\n{plan}"
    );
}

/// Where paths in ARCHITECTURE.md start: at the root, or in the folder that their part is about.
const FOLDERS: [&str; 4] = [
    "",
    "sve-macros/compiler/src",
    "sve-runtime/src",
    "tests/tests",
];

#[test]
fn the_files_that_the_architecture_names_are_there() {
    let architecture = read("ARCHITECTURE.md");
    let inline = |line: &str| -> Vec<String> {
        let quoted = line.split('`').skip(1).step_by(2);
        quoted.map(str::to_owned).collect()
    };
    let file = |name: &String| {
        let plain = name
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
        let ending = [".rs", ".py", ".md", ".toml", "/"];
        plain && ending.iter().any(|end| name.ends_with(end))
    };
    let names: Vec<String> = architecture.lines().flat_map(inline).filter(file).collect();
    assert!(names.len() > 80, "{} names", names.len());
    let missing: Vec<&String> = names
        .iter()
        .filter(|name| {
            !FOLDERS
                .iter()
                .any(|folder| root().join(folder).join(name).exists())
        })
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// The package outside of the workspace cannot inherit from its manifest.
#[test]
fn packages_name_the_same_repository() {
    let repository = |path: &str| -> String {
        let manifest = read(path);
        let line = manifest
            .lines()
            .find(|line| line.starts_with("repository = "));
        line.unwrap_or_else(|| panic!("{path} names a repository"))
            .to_owned()
    };
    assert_eq!(
        repository("Cargo.toml"),
        repository("sve-runtime/mpi/Cargo.toml")
    );
}

/// Licences travel with each package.
#[test]
fn packages_contain_the_licences() {
    for package in [
        "sve-macros",
        "sve-macros/compiler",
        "sve-runtime",
        "sve-runtime/mpi",
    ] {
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            assert_eq!(read(&format!("{package}/{licence}")), read(licence));
        }
    }
}
