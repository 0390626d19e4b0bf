//! The grammar of specifications (language reference, section 4), one file per area.
//!
//! Each function reads one rule and makes one node. A function named after a rule is called when
//! its first token is there; one that returns `bool` or `Option` looks first and reports what is
//! missing.
//!
//! Recovery: a broken item is passed up to its `;`, up to the `}` of the body around it, or up to
//! something that can only be the beginning of another declaration. A missing token is reported
//! where something else was found, without passing it. After an error nothing is reported at the
//! same token again, so that one mistake makes one message. Braces that are missing or too many have
//! a file of their own (`braces`).
//!
//! Comments of the form `// test NAME` hold texts that are parsed by the tests, see
//! `tests/parser.rs`.

mod braces;
mod codel;
mod component;
mod expr;
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

/// Reads a whole file.
pub(super) fn fragment(p: &mut Parser<'_>, fragment: Fragment) {
    let m = p.start();
    spec::items(p, fragment, None);
    m.complete(p, SOURCE_FILE);
}

/// Reads what follows `#pragma wcet`: a codel and a duration.
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

/// A mention of a declared name.
fn name_ref(p: &mut Parser<'_>) -> bool {
    identifier(p, NAME_REF, "a name")
}

fn identifier(p: &mut Parser<'_>, kind: SyntaxKind, what: &str) -> bool {
    if p.at(IDENT) {
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

/// `[::]a::b::c`
fn path(p: &mut Parser<'_>) -> bool {
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
        if !name_ref(p) || !p.eat(COLON2) {
            break;
        }
    }
    m.complete(p, PATH);
    true
}

/// One or more of something, separated by commas. Stops after the first that is missing.
fn comma_list(p: &mut Parser<'_>, mut one: impl FnMut(&mut Parser<'_>) -> bool) {
    while one(p) && p.eat(COMMA) {}
}

/// Adjacent strings.
fn strings(p: &mut Parser<'_>) -> bool {
    if !p.at(STRING) && !p.at(OPEN_STRING) {
        if p.at(IDENT) {
            p.expected_because("a string", "write the text between double quotes");
        } else {
            p.expected("a string");
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
        // It took the rest of the file with it.
        p.mark_reported();
        return;
    }
    p.bump_any();
}

/// The `;` at the end of a declaration. A missing one is reported at what was found, and assumed.
fn semicolon(p: &mut Parser<'_>, after: &str) {
    semicolon_or(p, after, "");
}

/// Like [`semicolon`], where something else could have followed too.
fn semicolon_or(p: &mut Parser<'_>, after: &str, others: &'static str) {
    if p.is_reported() {
        // Something before the `;` was wrong: what is left of it goes with this declaration.
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
            p.turn_inside_out();
            Parsing::NoSemicolonOrQuote {
                after,
                others,
                found,
            }
        } else {
            Parsing::NoSemicolon {
                after,
                others,
                found,
            }
        }
    };
    p.error_here(kind);
}

impl Parser<'_> {
    /// At a token that ends any item: `;`, `}` or the end of the file.
    fn at_item_end(&self) -> bool {
        const END: TokenSet = TokenSet::new(&[SEMICOLON, R_CURLY, EOF]);
        self.at_ts(END)
    }
}
