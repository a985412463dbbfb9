//! Programs with mistakes, and what `#[variational]` says of each of them.
//!
//! The tables are `cases/*.cases`. A table begins with a paragraph about its subject. Each case
//! then is its name, its source as a user writes it, and below each token with a mistake the
//! message:
//!
//! ```text
//! === absolute_value
//! v * v - self.g * q.abs()
//!                    ^^^ `abs` has no derivative at 0: write `x * x` for a square, or
//!                    ... `(x * x + eps * eps).sqrt()` for a smooth modulus
//! ```
//!
//! `...` continues a message. Several messages at a line stand in the order in which the macro
//! reports them. `=== frame` has the lines that all cases below share, up to the next frame; its
//! line `...` is the place of the lines of the case. A case before the first frame is a whole
//! program.
//!
//! Two tests read the tables. The compiler's `messages.rs` expands each case and compares messages
//! and places, without the compiler of Rust; with `MISTAKES=overwrite` in the environment it writes
//! into the tables what it found. `compile_fail.rs` shows all cases to the compiler of Rust at
//! once, which has to report these errors and no other. Messages of the compiler of Rust itself are
//! in `ui`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The start of the line with the name of a case.
const HEADER: &str = "=== ";

/// Name of a section with lines that cases share.
const FRAME: &str = "frame";

/// The start of a line that continues a message, and the line of a frame that stands for those of
/// the case.
const CONTINUATION: &str = "...";

/// Columns of a line of a message.
const WIDTH: usize = 100;

/// Columns before a continued message at most.
const LARGEST_INDENT: usize = 40;

/// The text that the compiler of Rust adds to an error at an attribute as a whole.
const AT_THE_ATTRIBUTE: &str = "  = note: this error originates in the attribute macro `variational` (in Nightly builds, run with -Z macro-backtrace for more info)\n";

/// An error: its text, and the token that it marks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Line of the token in the source of the case, counted from 0.
    pub line: usize,
    /// Characters before the token.
    pub column: usize,
    /// Characters of the token.
    pub width: usize,
    /// The message of the error, in one line.
    pub text: String,
}

/// A program with mistakes.
pub struct Case {
    /// Name of the case, unique in its table.
    pub name: String,
    /// The messages in the table, in the order of their lines.
    pub messages: Vec<Message>,
    /// The program; `own` are the lines of the case, the others those of its frame.
    lines: Vec<String>,
    own: std::ops::Range<usize>,
}

/// A file of cases.
pub struct Table {
    /// Name of the table: that of its file.
    pub name: String,
    path: PathBuf,
    head: String,
    sections: Vec<Section>,
}

enum Section {
    Frame(String),
    Case(Case),
}

/// Returns all tables, by name.
///
/// # Panics
///
/// If a file cannot be read or is no table.
pub fn tables() -> Vec<Table> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    paths.into_iter().map(Table::read).collect()
}

impl Table {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).expect("a file");
        let name = path.file_stem().and_then(|name| name.to_str());
        let name = name.expect("a name").to_owned();
        let separator = format!("\n{HEADER}");
        let mut parts = text.split(&separator);
        let head = parts.next().expect("a paragraph").trim().to_owned();
        let mut sections = Vec::new();
        let mut frame = (Vec::new(), Vec::new());
        for part in parts {
            let (title, text) = part.split_once('\n').expect("a name and lines");
            if title == FRAME {
                frame = halves(text);
                sections.push(Section::Frame(text.trim_end().to_owned()));
            } else {
                sections.push(Section::Case(Case::read(title, text, &frame)));
            }
        }
        Self {
            name,
            path,
            head,
            sections,
        }
    }

    /// Returns the cases in their order.
    pub fn cases(&self) -> impl Iterator<Item = &Case> {
        self.sections.iter().filter_map(|section| match section {
            Section::Case(case) => Some(case),
            Section::Frame(_) => None,
        })
    }

    /// Writes the table with these messages, a list for each case.
    ///
    /// # Panics
    ///
    /// If the file cannot be written.
    pub fn overwrite(&self, messages: &[Vec<Message>]) {
        let mut messages = messages.iter();
        let mut text = self.head.clone() + "\n";
        for section in &self.sections {
            text += "\n";
            match section {
                Section::Frame(lines) => {
                    writeln!(text, "{HEADER}{FRAME}\n{lines}").expect("text");
                }
                Section::Case(case) => {
                    text += &case.written(messages.next().expect("messages of each case"));
                }
            }
        }
        fs::write(&self.path, text).expect("a file that can be written");
    }
}

/// Splits a frame at the place of the lines of a case.
fn halves(text: &str) -> (Vec<String>, Vec<String>) {
    let lines: Vec<String> = text.trim_end().lines().map(str::to_owned).collect();
    let place = lines.iter().position(|line| line.trim() == CONTINUATION);
    let place = place.expect("a frame with a line `...`");
    (lines[..place].to_vec(), lines[place + 1..].to_vec())
}

impl Case {
    fn read(name: &str, text: &str, (before, after): &(Vec<String>, Vec<String>)) -> Self {
        let mut lines = before.clone();
        let mut messages: Vec<Message> = Vec::new();
        for line in text.trim_end().lines() {
            let content = line.trim_start();
            let column = line.len() - content.len();
            if let Some(rest) = content.strip_prefix(CONTINUATION) {
                let text = &mut messages.last_mut().expect("a message to continue").text;
                if !text.is_empty() {
                    text.push(' ');
                }
                text.push_str(rest.trim());
            } else if content.starts_with('^') {
                let text = content.trim_start_matches('^');
                messages.push(Message {
                    line: lines.len() - 1,
                    column,
                    width: content.len() - text.len(),
                    text: text.trim().to_owned(),
                });
            } else {
                lines.push(line.to_owned());
            }
        }
        let own = before.len()..lines.len();
        lines.extend(after.iter().cloned());
        Self {
            name: name.to_owned(),
            messages,
            lines,
            own,
        }
    }

    /// Returns the program.
    pub fn source(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// Returns the case as the table would have it with these messages. Messages at lines of the
    /// frame stand at the end, where the table cannot have them: the case needs the line for
    /// itself.
    pub fn written(&self, messages: &[Message]) -> String {
        let mut out = format!("{HEADER}{}\n", self.name);
        for line in self.own.clone() {
            writeln!(out, "{}", self.lines[line]).expect("text");
            for message in messages.iter().filter(|message| message.line == line) {
                out += &message.written();
            }
        }
        for message in messages {
            if !self.own.contains(&message.line) {
                let line = &self.lines[message.line];
                writeln!(out, "in the frame:\n{line}\n{}", message.written()).expect("text");
            }
        }
        out
    }

    /// Returns the errors as the compiler of Rust prints them of a file in which the program starts
    /// after `offset` lines.
    pub fn printed(&self, file: &str, offset: usize) -> Vec<String> {
        let print = |message: &Message| {
            let Message {
                line,
                column,
                width,
                text,
            } = message;
            let source = &self.lines[*line];
            let number = (line + offset + 1).to_string();
            let margin = " ".repeat(number.len());
            let mark = " ".repeat(*column) + &"^".repeat(*width);
            let mut out = format!(
                "error: {text}\n{margin}--> {file}:{number}:{}\n{margin} |\n{number} | {source}\n{margin} | {mark}\n",
                column + 1
            );
            let is_at_the_attribute = source.starts_with("#[") && *column == 0 && *width > 1;
            if is_at_the_attribute {
                write!(out, "{margin} |\n{}{AT_THE_ATTRIBUTE}", &margin[1..]).expect("text");
            }
            out
        };
        self.messages.iter().map(print).collect()
    }
}

impl Message {
    /// Returns the lines of the message in a table.
    fn written(&self) -> String {
        let mut out = " ".repeat(self.column) + &"^".repeat(self.width);
        let indent = " ".repeat(self.column.min(LARGEST_INDENT));
        let mut columns = out.len();
        for word in self.text.split(' ') {
            let length = word.chars().count();
            if columns + 1 + length > WIDTH {
                write!(out, "\n{indent}{CONTINUATION}").expect("text");
                columns = indent.len() + CONTINUATION.len();
            }
            write!(out, " {word}").expect("text");
            columns += 1 + length;
        }
        out + "\n"
    }
}
