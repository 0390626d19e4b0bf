//! What only follows from something else that is wrong, and is left out: one cause, one diagnostic.

use dotgen_syntax::{SyntaxKind, SyntaxNode, TextRange};
use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use crate::{
    base::Db,
    source_map::bytes,
    unit::{FileKey, Outcome, lowered, parsed, preprocessed},
};

/// What of a unit could not be read, so that names may well be missing.
#[derive(Default)]
pub(super) struct Missing {
    /// Whole files or declarations: see [`is_incomplete`].
    incomplete: bool,
    /// See [`lacks_name`].
    nameless: bool,
    /// See [`unparsed_words`].
    unparsed: FxHashSet<SmolStr>,
}

impl Missing {
    /// Adds what is missing in a file.
    pub(super) fn add(&mut self, db: &dyn Db, key: FileKey<'_>) {
        self.incomplete |= is_incomplete(db, key);
        self.nameless |= lacks_name(db, key);
        self.unparsed
            .extend(unparsed_words(db, key).iter().cloned());
    }

    /// Whether a report at a place only follows from it.
    pub(super) fn explains(
        &self,
        db: &dyn Db,
        key: FileKey<'_>,
        code: &str,
        range: TextRange,
    ) -> bool {
        let inside_out = parsed(db, key).inside_out;
        let around = |it: &TextRange| it.contains_range(range);
        inside_out.is_some_and(|from| range.start() >= from)
            || self.nameless && is_about_names_in_components(code)
            || is_about_machines(code) && broken_machines(db, key).iter().any(around)
            || follows_from_missing_text(code)
                && (self.incomplete || self.names_lost_word(db, key, range))
    }

    /// Whether a range mentions a word whose declaration may not have been understood.
    fn names_lost_word(&self, db: &dyn Db, key: FileKey<'_>, range: TextRange) -> bool {
        let text = key.file(db).text(db);
        let text = text.get(bytes(range)).unwrap_or_default();
        !self.unparsed.is_empty()
            && text
                .split(|it: char| !(it.is_alphanumeric() || it == '_'))
                .any(|it| self.unparsed.contains(it))
    }
}

/// Whether something that the text relies on was not read, so that names may well be missing.
fn is_incomplete(db: &dyn Db, key: FileKey<'_>) -> bool {
    let errors = &preprocessed(db, key).errors;
    if parsed(db, key).inside_out.is_some()
        || errors.iter().any(|it| it.kind.code() == "pp-include-bad")
    {
        return true;
    }
    let failed = key.outcomes(db).iter().any(|it| match it {
        Outcome::Include(result) => result.is_err(),
        Outcome::Requires(result) => result.is_err(),
    });
    failed || !key.file(db).status(db).is_text() || !lowered(db, key).misplaced.is_empty()
}

/// Whether some data, task or service has no name yet: codels may well mention the one it is to get.
#[salsa::tracked]
fn lacks_name<'db>(db: &'db dyn Db, key: FileKey<'db>) -> bool {
    use SyntaxKind::*;
    let parse = parsed(db, key);
    let is_nameless = |it: SyntaxNode| {
        let name = match it.kind() {
            PORT | SERVICE | TASK => NAME,
            LOCAL_PROPERTY | MEMBER | TYPED_PARAM => DECLARATOR,
            // A body whose first line is missing.
            ERROR => return it.children().any(|it| it.kind() == BODY),
            _ => return false,
        };
        !it.children().any(|it| it.kind() == name)
    };
    !parse.errors.is_empty() && parse.syntax().descendants().any(is_nameless)
}

/// Whether a report is about the name of some data, task or service.
fn is_about_names_in_components(code: &str) -> bool {
    code.starts_with("param-unknown")
        || matches!(
            code,
            "param-member" | "param-no-ids" | "service-unknown" | "task-unknown"
        )
}

/// Whether a report can be the mere consequence of a declaration that was not read.
fn follows_from_missing_text(code: &str) -> bool {
    code.contains("unknown")
        || matches!(
            code,
            "activity-start"
                | "activity-task"
                | "const-operand"
                | "forward-undefined"
                | "fsm/stop-without-ether"
                | "fsm/undefined-state"
                | "fsm/unreachable-state"
                | "init-member"
                | "param-member"
                | "param-no-ids"
                | "pragma-masquerade-type"
                | "throw-not-exception"
                | "throw/undeclared-use"
                | "unused-task"
                | "wcet-pragma"
        )
}

/// Whether a report is about the states of a task or activity as a whole.
fn is_about_machines(code: &str) -> bool {
    matches!(
        code,
        "activity-start"
            | "activity-task"
            | "fsm/missing-stop"
            | "fsm/no-termination"
            | "fsm/stop-without-ether"
            | "fsm/undefined-state"
            | "fsm/unreachable-state"
    )
}

/// Tasks and services with something in them that was not understood, or that break off: it may be a codel.
#[salsa::tracked]
fn broken_machines<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Vec<TextRange> {
    let parse = parsed(db, key);
    if parse.errors.is_empty() {
        return Vec::new();
    }
    let text = key.file(db).text(db);
    // What lacks its `;` is understood, if it has braces.
    let is_lost = |node: &SyntaxNode| {
        let range = node.text_range();
        let ended = node.last_token();
        let ended = ended.is_some_and(|it| it.kind() == SyntaxKind::SEMICOLON);
        let whole = node.children().any(|it| it.kind() == SyntaxKind::BODY);
        parse.errors.iter().any(|it| {
            let inside = range.contains(it.range.start());
            let between = TextRange::new(range.end(), it.range.start().max(range.end()));
            let behind = !ended
                && it.range.start() >= range.end()
                && text
                    .get(bytes(between))
                    .is_some_and(|it| it.trim().is_empty());
            match it.code() {
                "missing-semicolon" => behind && !whole,
                _ => inside || behind,
            }
        })
    };
    let nodes = parse.syntax().descendants();
    nodes
        .filter(|it| matches!(it.kind(), SyntaxKind::TASK | SyntaxKind::SERVICE))
        .filter(is_lost)
        .map(|it| it.text_range())
        .collect()
}

/// Words in the text that fits no rule of the grammar: a declaration of them may be lost in it.
#[salsa::tracked]
fn unparsed_words<'db>(db: &'db dyn Db, key: FileKey<'db>) -> FxHashSet<SmolStr> {
    let parse = parsed(db, key);
    if parse.errors.is_empty() {
        return FxHashSet::default();
    }
    let root = parse.syntax();
    let lost = root
        .descendants()
        .filter(|it| it.kind() == SyntaxKind::ERROR);
    lost.flat_map(|it| it.descendants_with_tokens())
        .filter_map(|it| it.into_token())
        .filter(|it| it.kind() == SyntaxKind::IDENT)
        .map(|it| parse.expansion.text(&it))
        .collect()
}
