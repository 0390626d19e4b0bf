//! Every diagnostic of a unit, brought to places in files.
//!
//! The layers report in their own terms; here ids become ranges, configured severities are applied,
//! and what only follows from another problem is left out.

mod consequence;
mod text;

use std::sync::Arc;

use camino::Utf8Path;

use dotgen_syntax::TextRange;
use rustc_hash::FxHashSet;

use crate::{
    base::{Db, SourceFile},
    check, codes,
    diagnostic::{Diagnostic, FileEdit, Fix, Severity, Tag},
    elab::{self, ElabDiagnostic},
    fixes::{self, Finding},
    ide::FileView,
    lint,
    model::Src,
    queries::{WRAPPER, body_count, check_body, elab_diagnostics, lint_body, lint_unused},
    source_map::{bytes, ptr},
    suppress::suppressions,
    unit::{
        self, FileKey, UnitKey, Visits, parsed, preprocessed, roots_of, unit_of_root,
        visits,
    },
};

use consequence::Missing;
use text::{expanded_from, macro_call_at, related_at, text_report};

/// Units of which the diagnostics of a file are brought together.
const MAX_UNITS: usize = 16;

/// Text left out by a conditional.
const INACTIVE: &str = "inactive-code";

/// All diagnostics of a unit, by file and place.
#[salsa::tracked(lru = 0)]
pub(crate) fn unit_report<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Vec<Diagnostic>> {
    let mut report = Report {
        db,
        visits: visits(db, unit),
        missing: Missing::default(),
        out: Vec::new(),
    };
    let mut seen = FxHashSet::default();
    for (i, visit) in report.visits.visits.iter().enumerate() {
        if visit.reached && seen.insert(visit.key) {
            report.missing.add(db, visit.key);
            report.text(i, visit.key);
        }
    }
    for it in elab_diagnostics(db, unit).iter() {
        report.elab(it);
    }
    for body in 0..body_count(db, unit) {
        for it in check_body(db, unit, body).iter() {
            report.elab(it);
        }
    }
    let rejected = report.out.iter().any(|it| it.severity == Severity::Error);
    for body in 0..body_count(db, unit) {
        report.lints(lint_body(db, unit, body), rejected);
    }
    report.lints(lint_unused(db, unit), rejected);
    report.suppress();
    report.attach_fixes();
    let mut out = report.out;
    configure(db, &mut out);
    sort_and_dedup(&mut out);
    Arc::new(out)
}

/// Keeps the reports of `count` units at most.
pub(crate) fn keep(db: &mut dyn Db, count: usize) {
    unit_report::set_lru_capacity(db, count);
}

/// Diagnostics of one file, over the units that contain it.
pub(crate) fn file_diagnostics(db: &dyn Db, file: SourceFile) -> Vec<Diagnostic> {
    let path = file.path(db);
    let mut out = Vec::new();
    for &root in roots_of(db, file).iter().take(MAX_UNITS) {
        let report = unit_report(db, unit_of_root(db, root));
        let start = report.partition_point(|it| it.path.as_str() < path.as_str());
        out.extend(
            report[start..]
                .iter()
                .take_while(|it| it.path == *path)
                .cloned(),
        );
    }
    if let Some(view) = FileView::new(db, file) {
        out.extend(inactive_hints(db, view.key));
    }
    sort_and_dedup(&mut out);
    out
}

/// Hints on the text that is left out, as the unit that serves the file sees it.
pub(crate) fn inactive_hints<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Vec<Diagnostic> {
    let path = key.file(db).path(db);
    let hint = |&range: &TextRange| Diagnostic {
        code: INACTIVE,
        severity: Severity::Hint,
        message: "left out by the preprocessor: the condition above does not hold".into(),
        path: path.clone(),
        range: bytes(range),
        related: Vec::new(),
        tags: vec![Tag::Unnecessary],
        fixes: Vec::new(),
    };
    let mut out: Vec<Diagnostic> = preprocessed(db, key).inactive.iter().map(hint).collect();
    configure(db, &mut out);
    out
}

/// Brings diagnostics of several units together.
pub(crate) fn sort_and_dedup(diagnostics: &mut Vec<Diagnostic>) {
    diagnostics.sort_by(|a, b| a.sort_key().cmp(&b.sort_key()));
    diagnostics.dedup_by(|a, b| a.sort_key() == b.sort_key());
}

struct Report<'db> {
    db: &'db dyn Db,
    visits: &'db Visits<'db>,
    /// What could not be read.
    missing: Missing,
    out: Vec<Diagnostic>,
}

impl<'db> Report<'db> {
    fn push_with(
        &mut self,
        file: SourceFile,
        code: &'static str,
        severity: Severity,
        range: TextRange,
        message: String,
    ) {
        self.out.push(Diagnostic {
            code,
            severity,
            message,
            path: file.path(self.db).clone(),
            range: bytes(range),
            related: Vec::new(),
            tags: Vec::new(),
            fixes: Vec::new(),
        });
    }

    /// What the text of one file gives.
    fn text(&mut self, visit: usize, key: FileKey<'db>) {
        for it in text_report(self.db, key).iter() {
            self.out.push(it.clone());
            if it.code == "syntax-eof" {
                self.included_from(visit);
            }
        }
    }

    /// Says where the includer of a visit goes on.
    fn included_from(&mut self, visit: usize) {
        let Some((by, ordinal)) = self.visits.visits[visit].includer else {
            return;
        };
        let by = self.visits.visits[by as usize].key;
        if let Some(include) = preprocessed(self.db, by).includes.get(ordinal as usize) {
            let message = "included here; a declaration must end in the file in which it begins";
            self.related(by.file(self.db), include.range, message.into());
        }
    }

    /// Adds related information to the last diagnostic.
    fn related(&mut self, file: SourceFile, range: TextRange, message: String) {
        let related = related_at(self.db, file, range, message);
        if let Some(last) = self.out.last_mut() {
            last.related.push(related);
        }
    }

    fn elab(&mut self, it: &ElabDiagnostic) {
        let Some((key, range)) = self.place(it.at) else {
            return;
        };
        if self.missing.explains(self.db, key, it.code, range) {
            return;
        }
        let severity = it.severity;
        self.push_with(
            key.file(self.db),
            it.code,
            severity,
            range,
            it.message.clone(),
        );
        for (src, message) in &it.related {
            if let Some((key, range)) = self.place(*src) {
                self.related(key.file(self.db), range, message.clone());
            }
        }
        let expanded = expanded_from(self.db, key, range);
        if let Some(last) = self.out.last_mut() {
            last.related.extend(expanded);
        }
        let fix = it.fix.as_ref().and_then(|it| self.fix(it));
        if let (Some(fix), Some(last)) = (fix, self.out.last_mut()) {
            last.fixes.push(fix);
        }
    }

    /// In a rejected unit, what is missing may be what could not be read: rules about absence wait.
    fn lints(&mut self, found: &[ElabDiagnostic], rejected: bool) {
        for it in found {
            let Some(code) = lint::codes::find(it.code) else {
                continue;
            };
            if (rejected && code.absence) || (!code.on && !is_configured(self.db, it.code)) {
                continue;
            }
            let before = self.out.len();
            self.elab(it);
            if code.unnecessary {
                self.out[before..]
                    .iter_mut()
                    .for_each(|it| it.tags.push(Tag::Unnecessary));
            }
        }
    }

    /// Adds the fixes that are made from the text.
    fn attach_fixes(&mut self) {
        let mut seen = FxHashSet::default();
        for visit in self.visits.visits.iter().filter(|it| it.reached) {
            if !seen.insert(visit.key) {
                continue;
            }
            let path = visit.key.file(self.db).path(self.db);
            let wanting =
                |it: &&mut Diagnostic| it.path == *path && fixes::has_fixes(it.code, &it.message);
            let mut root = None;
            for found in self.out.iter_mut().filter(wanting) {
                // A place that a macro made cannot be edited.
                let at = text_range(&found.range);
                if macro_call_at(self.db, visit.key, at).is_some() {
                    continue;
                }
                let root = root.get_or_insert_with(|| parsed(self.db, visit.key).syntax());
                attach_fixes(root, found);
            }
        }
    }

    /// Removes what comments allow, and reports comments that allow nothing.
    fn suppress(&mut self) {
        let mut seen = FxHashSet::default();
        for visit in &self.visits.visits {
            if !visit.reached || !seen.insert(visit.key) {
                continue;
            }
            let file = visit.key.file(self.db);
            let path = file.path(self.db);
            for it in suppressions(self.db, visit.key).iter() {
                let mut unused: Vec<&(String, TextRange)> = it.codes.iter().collect();
                self.out.retain(|found| {
                    let inside = found.path == *path
                        && found.severity != Severity::Error
                        && bytes(it.scope).contains(&found.range.start);
                    let allowed = inside && it.codes.iter().any(|(code, _)| code == found.code);
                    if allowed {
                        unused.retain(|(code, _)| code != found.code);
                    }
                    !allowed
                });
                // Another unit may need what an included file allows.
                if visit.includer.is_some() {
                    continue;
                }
                for (code, range) in unused {
                    // What codels differ in is not known here: see `unused_allowances`.
                    if is_switched_off(self.db, code) || code.starts_with(codes::CODEL) {
                        continue;
                    }
                    let known =
                        lint::codes::find(code).is_some() || check::codes::find(code).is_some();
                    let message = unused_allowance(code, known);
                    self.push_with(
                        file,
                        lint::codes::UNUSED_SUPPRESSION,
                        Severity::Hint,
                        *range,
                        message,
                    );
                }
                if !it.has_reason {
                    let message = "say why this is allowed, after the parenthesis".to_owned();
                    self.push_with(
                        file,
                        lint::codes::NO_REASON,
                        Severity::Hint,
                        it.comment,
                        message,
                    );
                }
            }
        }
    }

    fn place(&self, src: Src) -> Option<(FileKey<'db>, TextRange)> {
        let visit = src.visit.checked_sub(WRAPPER + 1)?;
        let key = self.visits.visits.get(visit as usize)?.key;
        Some((key, unit::ranges(self.db, key).get(ptr(src))?))
    }

    /// `None` if the text to change is not the text that was meant, because a macro made it.
    fn fix(&self, fix: &elab::Fix) -> Option<Fix> {
        let (at, text, title) = match fix {
            elab::Fix::Replace { at, text, title } => (*at, text.as_str(), title),
            elab::Fix::InsertBefore { at, text, title } => (*at, text.as_str(), title),
            elab::Fix::Remove { at, title } => (*at, "", title),
        };
        let (key, range) = self.place(at)?;
        if macro_call_at(self.db, key, range).is_some() {
            return None;
        }
        let range = match fix {
            elab::Fix::InsertBefore { .. } => TextRange::empty(range.start()),
            _ => range,
        };
        Some(Fix {
            title: title.clone(),
            edits: vec![FileEdit {
                path: key.file(self.db).path(self.db).clone(),
                range: bytes(range),
                new_text: text.to_owned(),
            }],
        })
    }
}

fn text_range(range: &std::ops::Range<usize>) -> TextRange {
    let offset = crate::source_map::offset;
    TextRange::new(offset(range.start), offset(range.end.max(range.start)))
}

/// Adds to a diagnostic of a file the fixes that are made from its text.
fn attach_fixes(root: &dotgen_syntax::SyntaxNode, found: &mut Diagnostic) {
    let path = &found.path;
    let related = found.related.iter().filter(|it| it.path == *path);
    let related: Vec<TextRange> = related.map(|it| text_range(&it.range)).collect();
    let finding = Finding {
        code: found.code,
        message: &found.message,
        range: text_range(&found.range),
        related: &related,
    };
    let fixes = fixes::fixes(root, &finding).into_iter();
    let fixes: Vec<Fix> = fixes.map(|it| it.within(path)).collect();
    found.fixes.extend(fixes);
}

/// What is said of a code that a comment allows and that nothing has.
pub(crate) fn unused_allowance(code: &str, known: bool) -> String {
    match known {
        true => format!("nothing here is reported as `{code}`: remove it from the comment"),
        false => format!("`{code}` is no code of a diagnostic"),
    }
}

/// Codes of a layer above (`family`, of which `known` exist) that comments of a root allow, and that
/// none of its findings has there: those that comments allow are among `found`.
pub(crate) fn unused_allowances(
    db: &dyn Db,
    path: &Utf8Path,
    family: &str,
    known: &[&str],
    found: &[Diagnostic],
) -> Vec<Diagnostic> {
    let file = db.file(path);
    // Another unit may need what an included file allows.
    if roots_of(db, file).first() != Some(&file) {
        return Vec::new();
    }
    let unit = unit::serving_unit(db, file);
    let Some((_, key)) = unit::serving_visit(db, unit, file) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for it in suppressions(db, key).iter() {
        let scope = bytes(it.scope);
        let has = |found: &Diagnostic, code: &str| {
            let related = found.related.iter().map(|it| (&it.path, &it.range));
            let mut places = std::iter::once((&found.path, &found.range)).chain(related);
            found.code == code && places.any(|it| it.0 == path && scope.contains(&it.1.start))
        };
        let codes = it.codes.iter().filter(|it| it.0.starts_with(family));
        for (code, range) in codes {
            if is_switched_off(db, code) || found.iter().any(|it| has(it, code)) {
                continue;
            }
            out.push(Diagnostic {
                code: lint::codes::UNUSED_SUPPRESSION,
                severity: Severity::Hint,
                message: unused_allowance(code, known.contains(&code.as_str())),
                path: path.to_owned(),
                range: bytes(*range),
                related: Vec::new(),
                tags: Vec::new(),
                fixes: Vec::new(),
            });
        }
    }
    if !out.is_empty() {
        let root = parsed(db, key).syntax();
        out.iter_mut().for_each(|it| attach_fixes(&root, it));
    }
    configure(db, &mut out);
    out
}

/// Applies the configured severities, and removes what comments allow, from findings of a layer
/// above. A comment at any place of a finding counts.
pub(crate) fn adjust(db: &dyn Db, mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    diagnostics.retain(|it| {
        let related = it.related.iter().map(|it| (&it.path, &it.range));
        let mut places = std::iter::once((&it.path, &it.range)).chain(related);
        !places.any(|(path, range)| is_allowed(db, path, range.start, it.code))
    });
    configure(db, &mut diagnostics);
    diagnostics
}

/// Whether a comment of a specification allows a code at a place.
fn is_allowed(db: &dyn Db, path: &Utf8Path, at: usize, code: &str) -> bool {
    let file = db.file(path);
    // Of sources in other languages nothing is parsed here.
    if !roots_of(db, file).iter().any(|it| *it != file)
        && !db.workspace().roots(db).iter().any(|it| it == path)
    {
        return false;
    }
    let unit = unit::serving_unit(db, file);
    let Some((_, key)) = unit::serving_visit(db, unit, file) else {
        return false;
    };
    suppressions(db, key).iter().any(|it| {
        bytes(it.scope).contains(&at) && it.codes.iter().any(|(allowed, _)| allowed == code)
    })
}

/// Whether the configuration gives a code a severity.
fn is_configured(db: &dyn Db, code: &str) -> bool {
    let configured = db.workspace().severities(db);
    configured
        .iter()
        .rev()
        .find(|(it, _)| it == code)
        .is_some_and(|(_, to)| to.is_some())
}

/// Whether the configuration switches a code off.
pub(crate) fn is_switched_off(db: &dyn Db, code: &str) -> bool {
    let configured = db.workspace().severities(db);
    configured
        .iter()
        .rev()
        .find(|(it, _)| it == code)
        .is_some_and(|(_, to)| to.is_none())
}

/// Applies the configured severities. Errors are what the language says and stay.
fn configure(db: &dyn Db, diagnostics: &mut Vec<Diagnostic>) {
    let configured = db.workspace().severities(db);
    if configured.is_empty() {
        return;
    }
    diagnostics.retain_mut(|it| {
        let setting = configured.iter().rev().find(|(code, _)| code == it.code);
        match setting {
            Some(_) if it.severity == Severity::Error => true,
            Some((_, None)) => false,
            Some((_, Some(severity))) => {
                it.severity = *severity;
                true
            }
            None => true,
        }
    });
}
