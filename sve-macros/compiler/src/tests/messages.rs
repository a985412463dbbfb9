//! The messages of mistakes and their places, as the compiler of Rust prints them. Each file of `tests/mistakes/ui` is expanded here, and its
//! errors are printed and compared with the file's `.stderr`. Errors of the compiler of Rust itself, which have a code, are compared in
//! `tests/mistakes`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{LineColumn, Span, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Attribute, Item, Meta};

use crate::tests::expand;

/// What the compiler of Rust adds to an error at the attribute as a whole.
const AT_THE_ATTRIBUTE: &str = "  = note: this error originates in the attribute macro `variational` (in Nightly builds, run with -Z macro-backtrace for more info)\n";

/// All files with mistakes, in a fixed order.
fn files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/mistakes/ui");
    let entries = |folder: &Path| {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut paths: Vec<_> = entries
            .map(|entry| entry.expect("an entry").path())
            .collect();
        paths.sort();
        paths
    };
    let folders = entries(&root).into_iter().filter(|path| path.is_dir());
    let files = folders.flat_map(|folder| entries(&folder));
    let is_source = |path: &PathBuf| path.extension().is_some_and(|end| end == "rs");
    files.filter(is_source).collect()
}

/// The attributes of an item that a procedural macro can be on.
fn attributes(item: &mut Item) -> Option<&mut Vec<Attribute>> {
    match item {
        Item::Impl(item) => Some(&mut item.attrs),
        Item::Struct(item) => Some(&mut item.attrs),
        Item::Fn(item) => Some(&mut item.attrs),
        _ => None,
    }
}

/// The attribute `#[variational(…)]`: its own tokens, its arguments, and the item without it.
fn annotated(mut item: Item) -> Option<(Attribute, TokenStream, TokenStream)> {
    let all = attributes(&mut item)?;
    let is_ours = |attribute: &Attribute| {
        let path = attribute.path();
        path.segments
            .last()
            .is_some_and(|last| last.ident == "variational")
    };
    let attribute = all.remove(all.iter().position(is_ours)?);
    let arguments = match &attribute.meta {
        Meta::List(list) => list.tokens.clone(),
        _ => TokenStream::new(),
    };
    Some((attribute, arguments, item.into_token_stream()))
}

/// An error of an expansion: the message, and the first token that it is about, which is what the compiler of Rust marks.
struct Mistake {
    message: String,
    token: Span,
}

/// The `compile_error!("…")` of an expansion.
fn mistakes(expansion: TokenStream) -> Vec<Mistake> {
    let tokens: Vec<TokenTree> = expansion.into_iter().collect();
    let is_error =
        |token: &TokenTree| matches!(token, TokenTree::Ident(word) if word == "compile_error");
    let errors = (0..tokens.len()).filter(|&at| is_error(&tokens[at]));
    let mistake = |at: usize| {
        let TokenTree::Group(group) = &tokens[at + 2] else {
            panic!("no message: {}", tokens[at]);
        };
        let message: syn::LitStr = syn::parse2(group.stream()).expect("a message");
        Mistake {
            // tokens outside of the compiler of Rust are printed with a space before a comma
            message: message.value().replace(" ,", ","),
            token: tokens[at].span(),
        }
    };
    errors.map(mistake).collect()
}

/// The end of the token or group that starts at a place. A span of several tokens is here that of all, and in the compiler of Rust
/// that of the first.
fn end_of_token(tokens: TokenStream, start: LineColumn) -> Option<LineColumn> {
    tokens.into_iter().find_map(|token| {
        if token.span().start() == start {
            return Some(token.span().end());
        }
        match token {
            TokenTree::Group(group) => end_of_token(group.stream(), start),
            _ => None,
        }
    })
}

/// A file: its name in messages, its text and its tokens.
struct Source {
    name: String,
    text: String,
    tokens: TokenStream,
}

/// The error as the compiler of Rust prints it for this file.
fn printed(mistake: &Mistake, attribute: &Attribute, file: &Source) -> String {
    let Source { name, text, .. } = file;
    let of_nothing = LineColumn { line: 1, column: 0 };
    // a span of no token is that of the attribute as a whole
    let at_the_attribute = mistake.token.start() == of_nothing;
    let (start, end) = if at_the_attribute {
        let [first, last] = [
            attribute.pound_token.span,
            attribute.bracket_token.span.close(),
        ];
        (first.start(), last.end())
    } else {
        let start = mistake.token.start();
        let end = end_of_token(file.tokens.clone(), start);
        (start, end.expect("a token").min(mistake.token.end()))
    };
    let line = text.lines().nth(start.line - 1).expect("a line");
    assert_eq!(start.line, end.line, "{name}: an error over several lines");
    let margin = " ".repeat(start.line.to_string().len());
    let mark = " ".repeat(start.column) + &"^".repeat(end.column - start.column);
    let mut out = format!(
        "error: {}\n{margin}--> {name}:{}:{}\n{margin} |\n{} | {line}\n{margin} | {mark}\n",
        mistake.message,
        start.line,
        start.column + 1,
        start.line,
    );
    if at_the_attribute {
        write!(out, "{margin} |\n{}{AT_THE_ATTRIBUTE}", &margin[1..]).expect("text");
    }
    out
}

/// All errors of a file.
fn errors(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a file");
    let tokens: TokenStream = text.parse().expect("tokens");
    let items = syn::parse2::<syn::File>(tokens.clone())
        .expect("Rust")
        .items;
    let folder = path.parent().and_then(Path::file_name).expect("a folder");
    let own = path.file_name().expect("a name");
    let file = Source {
        name: format!("ui/{}/{}", folder.display(), own.display()),
        text,
        tokens,
    };
    let blocks = items.into_iter().filter_map(annotated);
    let texts = blocks.flat_map(|(attribute, arguments, item)| {
        let all = mistakes(expand(&arguments, &item));
        let print = |mistake: &Mistake| printed(mistake, &attribute, &file);
        all.iter().map(print).collect::<Vec<_>>()
    });
    texts.collect::<Vec<_>>().join("\n")
}

#[test]
fn mistakes_have_their_messages_at_their_tokens() {
    let files = files();
    assert!(files.len() > 200, "{}", files.len());
    let mut wrong = Vec::new();
    for path in &files {
        let expected = fs::read_to_string(path.with_extension("stderr")).expect("the message");
        // errors with a code are those of the compiler of Rust
        let expected = if expected.contains("error[") {
            String::new()
        } else {
            expected
        };
        let found = errors(path);
        if found != expected {
            wrong.push(format!("{}:\n{found}\nnot\n{expected}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
