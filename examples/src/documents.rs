//! The statements of the documents about the project, compared with the project: numbers, links,
//! paths.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    let text = fs::read_to_string(root().join(path));
    text.unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns the numbers of `docs/numbers/README.md`: rows "| `name` | value | what |".
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

/// Returns a template with `{name}` replaced by its value.
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

/// The folders with pages for readers. The guide is a part of the package that shows it in its
/// documentation.
const PAGES: [&str; 2] = ["docs", "sve-runtime/docs/guide"];

/// Returns the documents for readers: the readme and all pages.
fn documents() -> Vec<String> {
    let mut documents = vec!["README.md".to_owned()];
    for folder in PAGES {
        for entry in fs::read_dir(root().join(folder)).expect("a folder") {
            let name = entry.expect("an entry").file_name();
            let name = name.to_str().expect("a name in UTF-8");
            if Path::new(name).extension().is_some_and(|end| end == "md") {
                documents.push(format!("{folder}/{name}"));
            }
        }
    }
    documents
}

#[test]
fn the_documents_quote_the_numbers_that_were_measured() {
    let (page, quotes) = (
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
    for document in documents() {
        for part in read(&document).split("<!-- numbers: ").skip(1) {
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
                "{name} in {document}: run `docs/numbers/run --quote`"
            );
            quoted.push(name.to_owned());
        }
    }
    assert_eq!(quoted.len(), templates.len(), "quoted are {quoted:?}");
}

/// Returns the targets of links between files: targets in parentheses, and targets of definitions.
fn targets(document: &str) -> Vec<&str> {
    let in_parentheses = document.split("](").skip(1);
    let in_parentheses = in_parentheses.filter_map(|rest| rest.split_once(')'));
    let defined = document.lines().filter(|line| line.starts_with('['));
    let defined = defined.filter_map(|line| line.split_once("]: "));
    let all = in_parentheses
        .map(|(target, _)| target)
        .chain(defined.map(|(_, target)| target));
    all.filter(|target| !target.contains("://") && !target.contains(char::is_whitespace))
        .collect()
}

#[test]
fn the_links_of_the_documents_lead_to_files() {
    let (mut all, mut missing) = (0, Vec::new());
    for document in documents() {
        let text = read(&document);
        let folder = root().join(&document);
        let folder = folder.parent().expect("a folder");
        for target in targets(&text) {
            let file = target.split('#').next().unwrap_or_default();
            all += 1;
            if !folder.join(file).exists() {
                missing.push(format!("{target} in {document}"));
            }
        }
    }
    assert!(all > 60, "{all} links");
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn every_page_of_the_guide_is_in_its_contents_and_in_the_documentation() {
    let (contents, links, modules) = (
        read("sve-runtime/docs/guide/README.md"),
        read("sve-runtime/src/guide/links.md"),
        read("sve-runtime/src/guide/mod.rs"),
    );
    for document in documents() {
        let Some(page) = document.strip_prefix("sve-runtime/docs/guide/") else {
            continue;
        };
        let name = page.trim_end_matches(".md");
        if name == "README" {
            continue;
        }
        assert!(
            contents.contains(&format!("[{name}]: {page}")),
            "{page} is not in the contents"
        );
        assert!(
            links.contains(&format!("[{name}]: crate::guide::{name}\n")),
            "{name} has no link in the documentation"
        );
        let is_module = |line: &str| line.trim() == name;
        assert!(
            modules.lines().any(is_module),
            "{name} is not in the module `guide`"
        );
    }
}

/// Documents that name files of the repository.
const MAPS: [&str; 3] = ["ARCHITECTURE.md", "docs/decisions.md", "tests/README.md"];

/// The folders in which their paths start: the root, or the folder that their part describes.
const FOLDERS: [&str; 4] = [
    "",
    "sve-macros/compiler/src",
    "sve-runtime/src",
    "tests/tests",
];

#[test]
fn the_files_that_documents_name_are_there() {
    let maps = MAPS.map(read).concat();
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
    let names: Vec<String> = maps.lines().flat_map(inline).filter(file).collect();
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

/// Checks the package outside of the workspace, which cannot inherit from its manifest.
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

/// Checks that each package contains the licences.
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
