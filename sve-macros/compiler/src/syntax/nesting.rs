//! A bound on how deeply the input is nested, checked before anything recurses over it.
//!
//! Input: tokens as they come. The parser, and every walk of a syntax tree, recurses once for each
//! bracket and for each token that may open an operand, so a stack overflow is a matter of the
//! source text. No token tree is walked here by recursion.

use proc_macro2::token_stream::IntoIter;
use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};

/// The cost at which the input is refused: an estimate of the height of the syntax tree, in units
/// of a sixth of a term.
const LIMIT: usize = 6_000;

/// A term of a sum or a factor of a product is one level of the tree, but none of the parser's
/// stack.
const TERM: usize = 6;

/// A token of a chain such as `a.b(c)[d]`, which begins anew in each factor.
const LINK: usize = 15;

/// A bracket, or a token that an operand follows: there the parser recurses.
const OPENER: usize = 60;

/// An open bracket, with the cost of what is open in it.
struct Level {
    stream: IntoIter,
    /// Cost of the levels around.
    around: usize,
    /// Since the last separator.
    statement: usize,
    /// Since the last sign between terms.
    product: usize,
    /// Since the last operator.
    chain: usize,
}

impl Level {
    fn new(stream: TokenStream, around: usize) -> Self {
        Self {
            stream: stream.into_iter(),
            around,
            statement: 0,
            product: 0,
            chain: 0,
        }
    }

    fn cost(&self) -> usize {
        let Self {
            stream: _,
            around,
            statement,
            product,
            chain,
        } = self;
        around + statement + product + chain
    }

    /// Counts a token.
    fn count(&mut self, token: &TokenTree, after_operator: bool) {
        match kind(token, after_operator) {
            Kind::Separator => (self.statement, self.product, self.chain) = (0, 0, 0),
            Kind::Opener => self.statement += OPENER,
            Kind::Sign => {
                self.statement += TERM;
                (self.product, self.chain) = (0, 0);
            }
            Kind::Times => {
                self.product += TERM;
                self.chain = 0;
            }
            Kind::Link => self.chain += LINK,
        }
    }
}

/// What a token does to the tree.
enum Kind {
    Separator,
    Opener,
    Sign,
    Times,
    Link,
}

fn kind(token: &TokenTree, after_operator: bool) -> Kind {
    match token {
        TokenTree::Punct(punct) => match punct.as_char() {
            ';' | ',' => Kind::Separator,
            ':' | '.' | '#' => Kind::Link,
            '+' | '-' if !after_operator => Kind::Sign,
            '*' | '/' if !after_operator => Kind::Times,
            _ => Kind::Opener,
        },
        TokenTree::Ident(ident) if is_opener(&ident.to_string()) => Kind::Opener,
        _ => Kind::Link,
    }
}

/// Returns an error where the input is nested too deeply to be read.
pub(crate) fn check(tokens: &TokenStream) -> syn::Result<()> {
    let mut open = vec![Level::new(tokens.clone(), 0)];
    let mut after_operator = true;
    while let Some(level) = open.last_mut() {
        let Some(token) = level.stream.next() else {
            open.pop();
            after_operator = false;
            continue;
        };
        level.count(&token, after_operator);
        after_operator = matches!(token, TokenTree::Punct(_));
        let cost = level.cost();
        if cost > LIMIT {
            return Err(too_deep(token.span()));
        }
        if let TokenTree::Group(group) = token {
            if group.delimiter() == Delimiter::Brace && !continues(level.stream.clone().next()) {
                // a statement ends with it
                (level.statement, level.product, level.chain) = (0, 0, 0);
            }
            open.push(Level::new(group.stream(), cost + OPENER));
            after_operator = true;
        }
    }
    Ok(())
}

/// Returns whether what follows a block belongs to the same expression.
fn continues(next: Option<TokenTree>) -> bool {
    match next {
        Some(TokenTree::Ident(ident)) => ident == "else",
        Some(TokenTree::Punct(punct)) => punct.as_char() != '#',
        _ => false,
    }
}

/// Keywords that an operand follows.
fn is_opener(word: &str) -> bool {
    matches!(
        word,
        "return"
            | "break"
            | "yield"
            | "move"
            | "unsafe"
            | "async"
            | "const"
            | "mut"
            | "dyn"
            | "impl"
            | "fn"
            | "for"
            | "if"
            | "while"
            | "match"
            | "let"
            | "else"
            | "loop"
            | "in"
            | "static"
            | "ref"
            | "box"
    )
}

fn too_deep(span: Span) -> syn::Error {
    syn::Error::new(
        span,
        "this is nested too deeply, or too long, to be read: name parts of it with `let`",
    )
}
