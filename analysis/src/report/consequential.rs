//! Consequences of other errors, which are left out: one cause, one diagnostic.

use dotgen_syntax::{Fragment, NodeOrToken, SyntaxKind, SyntaxNode, TextRange};
use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use crate::{
    base::Db,
    codes::{self, Cause},
    finding::{Finding, values::ValueProblem},
    source_map::bytes,
    unit::{DirectiveEffect, FileKey, include_fragments, parsed, text_facts},
};

/// The parts of a unit that could not be read, so that names may be missing.
#[derive(Default)]
pub(super) struct UnreadParts {
    /// Declarations of any kind: see [`is_incomplete`].
    incomplete: bool,
    /// Packages, or files that are included where components are declared: see [`lacks_files`].
    files: bool,
    /// See [`lacks_name`].
    nameless: bool,
    /// See [`unparsed_words`].
    unparsed: FxHashSet<SmolStr>,
}

impl UnreadParts {
    /// Adds the missing parts of a file.
    pub(super) fn add(&mut self, db: &dyn Db, key: FileKey<'_>) {
        self.incomplete |= is_incomplete(db, key);
        self.files |= lacks_files(db, key);
        self.nameless |= lacks_name(db, key);
        self.unparsed.extend(unparsed_words(db, key).iter().cloned());
    }

    /// Returns true if a finding at a place is only a consequence.
    pub(super) fn explains(
        &self,
        db: &dyn Db,
        key: FileKey<'_>,
        finding: &Finding,
        range: TextRange,
    ) -> bool {
        let inside_out = text_facts(db, key).inside_out;
        let around = |other: &TextRange| other.contains_range(range);
        inside_out.is_some_and(|from| range.start() >= from)
            || self.files && finding.kind.may_be_in_a_package(finding.near.is_some())
            || finding.kind == ValueProblem::DelayRange.into() && has_error_on_line(db, key, range)
            || codes::follows(finding.code()).iter().any(|cause| match cause {
                Cause::NamelessDeclaration => self.nameless,
                Cause::OpenMachine => open_machines(db, key).iter().any(around),
                Cause::BrokenMachine => broken_machines(db, key).iter().any(around),
                Cause::UnreadText => self.incomplete || self.names_lost_word(db, key, range),
            })
    }

    /// Returns true if a range mentions a word whose declaration may not have been parsed.
    fn names_lost_word(&self, db: &dyn Db, key: FileKey<'_>, range: TextRange) -> bool {
        let text = key.file(db).text(db);
        let text = text.get(bytes(range)).unwrap_or_default();
        !self.unparsed.is_empty()
            && text
                .split(|character: char| !(character.is_alphanumeric() || character == '_'))
                .any(|part| self.unparsed.contains(part))
    }
}

/// Returns true if some text that may contain any declaration was not read or parsed.
fn is_incomplete(db: &dyn Db, key: FileKey<'_>) -> bool {
    let facts = text_facts(db, key);
    if facts.inside_out.is_some() || facts.bad_include || facts.misplaced_includes {
        return true;
    }
    let includes = key.outcomes(db).iter().filter_map(|outcome| match outcome {
        DirectiveEffect::Include(result) => Some(result.is_err()),
        DirectiveEffect::Requires(_) => None,
    });
    let fragments = include_fragments(db, key);
    let in_body = |ordinal: usize| fragments.get(ordinal) != Some(&Some(Fragment::Specification));
    let mut failed = includes.enumerate().filter(|(_, failed)| *failed);
    failed.any(|(ordinal, _)| in_body(ordinal)) || !key.file(db).status(db).is_text()
}

/// Returns true if packages or files are missing, which can contain types, constants and interfaces. They
/// cannot contain a task, a state, a codel or a member of a known type: elaboration knows the contents of
/// missing interfaces as gaps.
fn lacks_files(db: &dyn Db, key: FileKey<'_>) -> bool {
    key.outcomes(db).iter().any(|outcome| match outcome {
        DirectiveEffect::Include(result) => result.is_err(),
        DirectiveEffect::Requires(result) => result.is_err(),
    })
}

/// Returns true if some data, task or service has no name yet: codels may mention its future name.
#[salsa::tracked]
fn lacks_name<'db>(db: &'db dyn Db, key: FileKey<'db>) -> bool {
    use SyntaxKind::*;
    let parse = parsed(db, key);
    let is_nameless = |node: SyntaxNode| {
        let name = match node.kind() {
            PORT | SERVICE | TASK => NAME,
            LOCAL_PROPERTY | MEMBER | TYPED_PARAM => DECLARATOR,
            // A body whose first line is missing.
            ERROR => return node.children().any(|child| child.kind() == BODY),
            _ => return false,
        };
        !node.children().any(|child| child.kind() == name)
    };
    !parse.errors.is_empty() && parse.syntax().descendants().any(is_nameless)
}

/// Tasks and services that contain text without a parse, or that end early: a codel may be lost in the text.
#[salsa::tracked]
fn broken_machines<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Vec<TextRange> {
    let parse = parsed(db, key);
    if parse.errors.is_empty() {
        return Vec::new();
    }
    let text = key.file(db).text(db);
    // A declaration without its `;` is complete if it has braces.
    let is_lost = |node: &SyntaxNode| {
        let range = node.text_range();
        let ended = node.last_token();
        let ended = ended.is_some_and(|token| token.kind() == SyntaxKind::SEMICOLON);
        let whole = node.children().any(|child| child.kind() == SyntaxKind::BODY);
        parse.errors.iter().any(|error| {
            let inside = range.contains(error.range.start());
            let between = TextRange::new(range.end(), error.range.start().max(range.end()));
            let behind = !ended
                && error.range.start() >= range.end()
                && text.get(bytes(between)).is_some_and(|text| text.trim().is_empty());
            match error.code() {
                "missing-semicolon" => behind && !whole,
                _ => inside || behind,
            }
        })
    };
    let nodes = parse.syntax().descendants();
    nodes
        .filter(|node| matches!(node.kind(), SyntaxKind::TASK | SyntaxKind::SERVICE))
        .filter(is_lost)
        .map(|node| node.text_range())
        .collect()
}

/// Tasks and services with a codel whose list of yields may go on: the codel lacks its `;` and the clause
/// that follows the list.
#[salsa::tracked]
fn open_machines<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Vec<TextRange> {
    let parse = parsed(db, key);
    if parse.errors.is_empty() {
        return Vec::new();
    }
    let goes_on = |codel: &SyntaxNode| {
        let last = codel.last_token().map(|token| token.kind());
        codel.kind() == SyntaxKind::CODEL
            && last != Some(SyntaxKind::SEMICOLON)
            && codel.children().all(|child| child.kind() != SyntaxKind::WCET)
    };
    let nodes = parse.syntax().descendants();
    nodes
        .filter(|node| matches!(node.kind(), SyntaxKind::TASK | SyntaxKind::SERVICE))
        .filter(|node| node.descendants().any(|codel| goes_on(&codel)))
        .map(|node| node.text_range())
        .collect()
}

/// Returns true if some text on the line of a place does not parse: a time without its unit is in seconds.
fn has_error_on_line(db: &dyn Db, key: FileKey<'_>, range: TextRange) -> bool {
    let text = key.file(db).text(db);
    let line = |at: usize| text.get(..at).map(|text| text.matches('\n').count());
    let here = line(usize::from(range.start()));
    let mut errors = parsed(db, key).errors.iter();
    errors.any(|error| line(usize::from(error.range.start())) == here)
}

/// Words in text that does not match the grammar: a declaration of them may be lost in it.
#[salsa::tracked]
fn unparsed_words<'db>(db: &'db dyn Db, key: FileKey<'db>) -> FxHashSet<SmolStr> {
    let parse = parsed(db, key);
    if parse.errors.is_empty() {
        return FxHashSet::default();
    }
    let root = parse.syntax();
    let lost = root.descendants().filter(|node| node.kind() == SyntaxKind::ERROR);
    lost.flat_map(|node| node.descendants_with_tokens())
        .filter_map(NodeOrToken::into_token)
        .filter(|token| token.kind() == SyntaxKind::IDENT)
        .map(|token| parse.expansion.text(&token))
        .collect()
}
