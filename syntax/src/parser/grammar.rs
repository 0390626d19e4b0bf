//! The grammar of specifications (language reference, section 4), one file per area.
//!
//! Each function reads one rule and makes one node. A function named after a rule is called at its first
//! token; a function that returns `bool` or `Option` checks that token first and reports what is missing.
//!
//! Recovery: a broken item is skipped up to its `;`, up to the `}` of the body around it, or up to a token
//! that can only begin another declaration. A missing token is reported at the token found in its place,
//! which is not consumed. After an error nothing else is reported at the same token, so that one mistake
//! makes one message. Missing and superfluous braces have a file of their own (`braces`).
//!
//! Comments of the form `// test NAME` hold texts that are parsed by the tests, see `tests/parser.rs`.

mod braces;
mod codel;
mod component;
mod expr;
mod foreign;
mod initializer;
mod param;
mod property;
mod service;
mod spec;
mod task;
mod types;

use super::{CompletedMarker, Fragment, Marker, Parser, TokenSet};
use crate::finding::parsing::Parsing;
use crate::kind::SyntaxKind::{self, *};

/// The tokens that may follow a `]`.
const AFTER_BRACKET: TokenSet = TokenSet::new(&[SEMICOLON, COMMA, L_BRACK, R_PAREN, DOT, EQ]);

/// Reads a whole file.
pub(super) fn fragment(p: &mut Parser<'_>, fragment: Fragment) {
    let m = p.start();
    spec::items(p, fragment, None);
    m.complete(p, SOURCE_FILE);
}

/// Reads the words of `#pragma wcet`: a codel and a duration.
pub(super) fn wcet_pragma(p: &mut Parser<'_>) {
    let m = p.start();
    if name_ref(p) && property::quantity(p, property::TIME_UNITS) && !p.at(EOF) {
        let found = p.describe_current().into();
        p.push_error(p.position(), Parsing::MoreInPragma { found });
    }
    while !p.at(EOF) {
        p.bump_any();
    }
    m.complete(p, DIRECTIVE);
}

/// The name of a new declaration.
fn name(p: &mut Parser<'_>) -> bool {
    identifier(p, NAME, "a name")
}

/// A reference to a declared name.
fn name_ref(p: &mut Parser<'_>) -> bool {
    identifier(p, NAME_REF, "a name")
}

fn identifier(p: &mut Parser<'_>, kind: SyntaxKind, what: &str) -> bool {
    if p.at(IDENT) && !begins_line_and_item(p) {
        let m = p.start();
        p.bump(IDENT);
        m.complete(p, kind);
        return true;
    }
    const NUMBER: TokenSet = TokenSet::new(&[INT, FLOAT]);
    if p.at_ts(NUMBER) && p.nth(1) == IDENT && p.is_glued() && !p.is_reported() {
        let at = p.position();
        let word = p.source(at..at + 2).to_owned();
        let name = word.trim_start_matches(|character: char| !character.is_ascii_alphabetic());
        p.error_here(Parsing::LeadingDigit { word: word.as_str().into() });
        p.replace(at..at + 2, name, false);
        p.skip_tokens(1);
        let m = p.start();
        p.bump(IDENT);
        m.complete(p, kind);
        return true;
    }
    if p.current().is_reserved_word() {
        p.expected_because(what, "reserved words cannot be names");
    } else {
        p.expected(what);
    }
    false
}

/// Returns true at a word on a new line that begins the next item: the item before is not finished. `ids {`
/// with properties is a task or port of that name.
fn begins_line_and_item(p: &Parser<'_>) -> bool {
    let is_body = p.at(IDS_KW) && property::at_body(p, 2);
    p.starts_line() && !is_body && spec::at_item(p)
}

/// `[::]a::b::c`
fn path(p: &mut Parser<'_>) -> bool {
    path_with(p, false)
}

/// Like [`path`], where no single colon can follow: a single colon is read as `::`.
fn path_with(p: &mut Parser<'_>, no_colon: bool) -> bool {
    if !p.at(COLON2) && !p.at(IDENT) {
        return name_ref(p);
    }
    let m = p.start();
    p.eat(COLON2);
    loop {
        if types::at_next(p) {
            p.expected("a name");
            break;
        }
        if !name_ref(p) {
            break;
        }
        if !(p.eat(COLON2) || no_colon && joined_by_other(p, COLON)) {
            break;
        }
    }
    m.complete(p, PATH);
    true
}

/// Reads another sign in the place of `::`, between two names: it is reported and read as `::`.
fn joined_by_other(p: &mut Parser<'_>, sign: SyntaxKind) -> bool {
    if !p.at(sign) || p.nth(1) != IDENT || p.is_reported() {
        return false;
    }
    let found = p.describe_current().into();
    let at = p.position();
    p.push_error(at, Parsing::SingleColon { found });
    p.replace(at..at + 1, "::", true);
    let bad = p.start();
    p.bump_any();
    bad.complete(p, ERROR);
    true
}

/// Reads one or more elements, separated by commas. Stops after the first missing element.
fn comma_list(p: &mut Parser<'_>, mut one: impl FnMut(&mut Parser<'_>) -> bool) {
    const CLOSING: TokenSet = TokenSet::new(&[SEMICOLON, R_CURLY, R_PAREN, R_ANGLE]);
    let mut after_comma = false;
    loop {
        let errors = p.error_count();
        if !one(p) {
            if after_comma && p.error_count() > errors && p.at_ts(CLOSING) {
                let comma = p.position() - 1;
                p.replace(comma..comma + 1, "", true);
            }
            return;
        }
        if !p.eat(COMMA) && !lacks_comma(p) {
            return;
        }
        after_comma = true;
    }
}

/// Returns true if another name is at the place of a comma. The missing comma is reported and assumed.
fn lacks_comma(p: &mut Parser<'_>) -> bool {
    const AFTER: TokenSet = TokenSet::new(&[COMMA, SEMICOLON]);
    if foreign::joined_by_word(p) {
        return true;
    }
    let is_word = p.current_contextual() == IDENT;
    let names = is_word && p.nth_at_ts(1, AFTER);
    if !names || p.is_reported() {
        return false;
    }
    let found = p.describe_current().into();
    p.push_error(p.position(), Parsing::NoComma { found });
    let plain = !p.starts_line();
    p.insert_behind(",", plain);
    true
}

/// Adjacent strings.
fn strings(p: &mut Parser<'_>) -> bool {
    if !p.at(STRING) && !p.at(OPEN_STRING) {
        const SIGNS: TokenSet = TokenSet::new(&[L_CURLY, R_CURLY]);
        let may_be_text = !p.starts_line() && !p.at_ts(SIGNS) && !spec::at_item(p);
        let unquoted = p.rest_of_line().filter(|count| *count > 0 && may_be_text);
        let Some(count) = unquoted else {
            p.expected("a string");
            return false;
        };
        let (at, found) = (p.position(), p.describe_current().into());
        let text = format!("\"{}\"", p.source(at..at + count).trim_matches('\''));
        if p.error_here(Parsing::NoQuotes { found }) && !text.trim_matches('"').contains('"') {
            p.replace(at..at + count, &text, true);
            p.skip_tokens(count);
        }
        return false;
    }
    let m = p.start();
    while p.at(STRING) || p.at(OPEN_STRING) {
        string_token(p);
    }
    m.complete(p, LITERAL);
    true
}

fn string_token(p: &mut Parser<'_>) {
    if p.at(OPEN_STRING) {
        p.error_here(Parsing::OpenLiteral);
        p.bump_any();
        // The string extends to the end of the file.
        p.mark_reported();
        return;
    }
    p.bump_any();
}

/// The `;` at the end of a declaration. A missing one is reported at the current token, and assumed.
fn semicolon(p: &mut Parser<'_>, after: &str) {
    semicolon_or(p, after, "");
}

/// Like [`semicolon`], if other tokens may follow too.
fn semicolon_or(p: &mut Parser<'_>, after: &str, others: &'static str) {
    if p.is_reported() {
        // The text before the `;` was wrong: the rest of it belongs to this declaration.
        let next = p.at_item_end() || spec::at_item(p) || types::at_member(p);
        if !p.eat(SEMICOLON) && !next {
            spec::skip_to_semicolon(p);
        }
        return;
    }
    if p.eat(SEMICOLON) {
        return;
    }
    let after = after.into();
    let kind = if p.at(EOF) {
        Parsing::NoSemicolonAtEnd { after, others }
    } else {
        let found = p.describe_current().into();
        if p.is_after_long_literal() && !spec::at_item(p) {
            p.mark_exchanged();
            // The missing quote is at the start of the string.
            p.error_before(Parsing::NoSemicolonOrQuote { after, others, found });
            return;
        }
        Parsing::NoSemicolon { after, others, found }
    };
    let another = spec::at_item(p) || types::begins_member(p);
    if p.error_here(kind) {
        p.show_behind();
        if another || p.at(R_CURLY) || p.at(EOF) {
            p.insert_behind(";", another && p.starts_line());
        }
    }
}

impl Parser<'_> {
    /// At a token that ends any item: `;`, `}` or the end of the file.
    fn at_item_end(&self) -> bool {
        const END: TokenSet = TokenSet::new(&[SEMICOLON, R_CURLY, EOF]);
        self.at_ts(END)
    }
}
