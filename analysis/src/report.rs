//! Every diagnostic of a unit, with places in files.
//!
//! The layers report in their own terms; here ids become ranges, configured severities are applied, and mere
//! consequences of another problem are left out.

mod consequential;
mod text;

use std::sync::Arc;

use camino::Utf8Path;

use dotgen_syntax::{SyntaxKind, TextRange};
use rustc_hash::FxHashSet;

use crate::{
    base::{Db, SourceFile, lexed},
    codes,
    diagnostic::{Diagnostic, Fix, FixKind, Reference, Severity, Tag},
    finding::{Finding, FindingKind, Near, files::FileProblem, lints::LintWarning},
    fixes::{FixSite, TextFix, trial},
    model::Src,
    queries::{body_findings, elab_findings, lint_unused},
    source_map::{bytes, ptr, text_range},
    spelling::Spelling,
    suppress::suppressions,
    unit::{
        self, FileKey, UnitKey, Visits, parsed, preprocessed, roots_of, serving_visit,
        unit_of_root, visits, walk::WalkId,
    },
};

use consequential::UnreadParts;
use text::{expanded_from, macro_call_at, related_at, text_report};

/// Maximum number of units whose diagnostics of a file are merged.
const MAX_UNITS: usize = 16;

/// All diagnostics of a unit, by file and place.
#[salsa::tracked(lru = 0)]
pub(crate) fn unit_report<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Vec<Diagnostic>> {
    let mut report =
        Reporter { db, visits: visits(db, unit), missing: UnreadParts::default(), out: Vec::new() };
    let mut seen = FxHashSet::default();
    for (i, visit) in report.visits.all().iter_enumerated() {
        if visit.reached && seen.insert(visit.key) {
            report.missing.add(db, visit.key);
            report.text(i, visit.key);
        }
    }
    let bodies = body_findings(db, unit);
    for finding in elab_findings(db, unit).iter().chain(&bodies.checks) {
        report.finding(finding);
    }
    let rejected = report.out.iter().any(|diagnostic| diagnostic.severity == Severity::Error);
    report.lints(&bodies.lints, rejected);
    report.lints(lint_unused(db, unit), rejected);
    report.suppress();
    let mut out = report.out;
    configure(db, &mut out);
    sort_and_dedup(&mut out);
    Arc::new(out)
}

/// Sets the maximum number of units with cached reports.
pub(crate) fn keep(db: &mut dyn Db, count: usize) {
    unit_report::set_lru_capacity(db, count);
}

/// Diagnostics of one file, over the units that contain it.
pub(crate) fn file_diagnostics(db: &dyn Db, file: SourceFile) -> Vec<Diagnostic> {
    let path = file.path(db);
    let mut out = Vec::new();
    for &root in roots_of(db, file).iter().take(MAX_UNITS) {
        let report = unit_report(db, unit_of_root(db, root));
        let start = report.partition_point(|report| report.path.as_str() < path.as_str());
        out.extend(report[start..].iter().take_while(|report| report.path == *path).cloned());
    }
    if file.status(db).is_text()
        && let Some((_, key)) = serving_visit(db, unit::serving_unit(db, file), file)
    {
        out.extend(inactive_hints(db, key));
    }
    sort_and_dedup(&mut out);
    out
}

/// Hints on excluded text, in the unit that serves the file.
pub(crate) fn inactive_hints<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Vec<Diagnostic> {
    let path = key.file(db).path(db);
    let hint = |&range: &TextRange| Diagnostic {
        tags: vec![Tag::Unnecessary],
        ..shown(&FileProblem::Inactive.into(), None, None, path, range)
    };
    let mut out: Vec<Diagnostic> = preprocessed(db, key).inactive.iter().map(hint).collect();
    configure(db, &mut out);
    out
}

/// Merges diagnostics of several units.
pub(crate) fn sort_and_dedup(diagnostics: &mut Vec<Diagnostic>) {
    diagnostics.sort_by(|a, b| a.sort_key().cmp(&b.sort_key()));
    diagnostics.dedup_by(|a, b| a.sort_key() == b.sort_key());
}

struct Reporter<'db> {
    db: &'db dyn Db,
    visits: &'db Visits<'db>,
    /// The text that could not be read.
    missing: UnreadParts,
    out: Vec<Diagnostic>,
}

impl<'db> Reporter<'db> {
    /// Adds the diagnostics of one file's text.
    fn text(&mut self, visit: WalkId, key: FileKey<'db>) {
        for report in text_report(self.db, key).iter() {
            self.out.push(report.clone());
            if report.code == dotgen_syntax::codes::AT_END {
                self.included_from(visit);
            }
        }
    }

    /// Adds the place at which the includer of a visit continues.
    fn included_from(&mut self, visit: WalkId) {
        let Some((by, ordinal)) = self.visits.all()[visit].includer else {
            return;
        };
        let by = self.visits.all()[by].key;
        if let Some(include) = preprocessed(self.db, by).includes.get(ordinal) {
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

    fn finding(&mut self, finding: &Finding) {
        let Some((key, range)) = self.place(finding.at) else {
            return;
        };
        if self.missing.explains(self.db, key, finding, range) {
            return;
        }
        let file = key.file(self.db);
        let near = finding.near.as_ref();
        let path = file.path(self.db);
        // Mistakes in stand-ins by dotgen are not reported.
        if unit::is_standin(path) {
            return;
        }
        let mut out = shown(&finding.kind, near, finding.because, path, range);
        out.severity = finding.severity;
        if let (Some(src), Some(reference)) = (finding.compiler_at, &mut out.reference)
            && let Some((said, range)) = self.place(src)
            && said == key
        {
            reference.at = usize::from(range.start());
        }
        let mut related = Vec::new();
        for (src, role) in &finding.related {
            if let Some((other, range)) = self.place(*src) {
                let at = related_at(self.db, other.file(self.db), range, role.to_string());
                if at.path == *path {
                    related.push(range);
                }
                out.related.push(at);
            }
        }
        out.related.extend(expanded_from(self.db, key, range));
        out.fixes.extend(near.and_then(|near| self.change(near)));
        let fixes = fixes_at(self.db, key, &finding.kind, range, &related);
        out.fixes.extend(fixes);
        self.out.push(out);
    }

    /// In a rejected unit, missing parts may be in unreadable text: rules about absence do not run.
    fn lints(&mut self, found: &[Finding], rejected: bool) {
        for finding in found {
            let Some(code) = codes::lints::find(finding.code()) else {
                continue;
            };
            if (rejected && code.absence) || (!code.on && !is_configured(self.db, finding.code())) {
                continue;
            }
            let before = self.out.len();
            self.finding(finding);
            if code.unnecessary {
                self.out[before..]
                    .iter_mut()
                    .for_each(|diagnostic| diagnostic.tags.push(Tag::Unnecessary));
            }
        }
    }

    /// Removes findings that comments allow, and reports comments that allow nothing.
    fn suppress(&mut self) {
        let mut seen = FxHashSet::default();
        for visit in self.visits.all() {
            if !visit.reached || !seen.insert(visit.key) {
                continue;
            }
            let file = visit.key.file(self.db);
            let path = file.path(self.db);
            for suppression in suppressions(self.db, visit.key).iter() {
                let mut unused: Vec<&(String, TextRange)> = suppression.codes.iter().collect();
                self.out.retain(|found| {
                    let inside = found.path == *path
                        && found.severity != Severity::Error
                        && bytes(suppression.scope).contains(&found.range.start);
                    let allowed =
                        inside && suppression.codes.iter().any(|(code, _)| code == found.code);
                    if allowed {
                        unused.retain(|(code, _)| code != found.code);
                    }
                    !allowed
                });
                // Another unit may need the comments of an included file.
                if visit.includer.is_some() {
                    continue;
                }
                for (code, range) in unused {
                    // Findings about codels are not known here: see `unused_allowances`.
                    if is_switched_off(self.db, code) || code.starts_with(codes::CODEL) {
                        continue;
                    }
                    let known = codes::find(code).is_some();
                    self.remark(visit.key, unused_allowance(code, known), *range);
                }
                if !suppression.has_reason {
                    self.remark(visit.key, LintWarning::NoReason, suppression.comment);
                }
            }
        }
    }

    /// Reports something about a comment.
    fn remark(&mut self, key: FileKey<'db>, kind: LintWarning, range: TextRange) {
        self.out.push(remark(self.db, key, kind, range));
    }

    fn place(&self, src: Src) -> Option<(FileKey<'db>, TextRange)> {
        let key = self.visits.of(src.visit)?.key;
        Some((key, unit::ranges(self.db, key).get(ptr(src))?))
    }

    /// Replaces the misspelt token by the intended name. `None` if a macro made the token.
    fn change(&self, near: &Near) -> Option<Fix> {
        let (key, range) = self.place(near.at)?;
        if macro_call_at(self.db, key, range).is_some() {
            return None;
        }
        let title = format!("Change to `{}`", near.name);
        let kind = FixKind::of(near.plain && !has_odd_quote(self.db, key.file(self.db)));
        let fix = TextFix { kind, ..TextFix::guess(title, range, near.text.as_str()) };
        Some(fix.within(key.file(self.db).path(self.db)))
    }
}

/// A finding as every front end shows it, at its place in a file.
pub(crate) fn shown(
    kind: &FindingKind,
    near: Option<&Near>,
    because: Option<&str>,
    path: &Utf8Path,
    range: TextRange,
) -> Diagnostic {
    let wording = kind.wording(near, because);
    Diagnostic {
        reference: Some(Reference { text: kind.reference(), at: usize::from(range.start()) }),
        ..Diagnostic::new(
            kind.code(),
            kind.severity(),
            wording.to_string(),
            path.to_owned(),
            bytes(range),
        )
    }
}

/// The style of the file's author for words with two spellings.
#[salsa::tracked(returns(copy))]
fn spelling(db: &dyn Db, file: SourceFile) -> Spelling {
    Spelling::of(file.text(db))
}

/// The fixes of a finding that are made from the text around it.
pub(crate) fn fixes_at<'db>(
    db: &'db dyn Db,
    key: FileKey<'db>,
    kind: &FindingKind,
    range: TextRange,
    related: &[TextRange],
) -> Vec<Fix> {
    // A place from a macro cannot be edited.
    if macro_call_at(db, key, range).is_some() {
        return Vec::new();
    }
    let parse = parsed(db, key);
    let root = parse.syntax();
    let here = FixSite {
        root: &root,
        broken: !parse.errors.is_empty(),
        range,
        related,
        source: key.file(db).text(db),
        spelling: &|| spelling(db, key.file(db)),
    };
    let path = key.file(db).path(db);
    let fixes = kind.fixes(&here).into_iter();
    let mut fixes: Vec<Fix> = fixes.map(|fix| fix.within(path)).collect();
    let is_doubtful = |fix: &Fix| fix.kind == FixKind::Plain && has_odd_quote(db, key.file(db));
    for fix in fixes.iter_mut().filter(|fix| is_doubtful(fix)) {
        fix.kind = FixKind::Guess;
    }
    fixes
}

/// See [`crate::host::Analysis::trials`].
pub(crate) fn trials(db: &dyn Db, of: &Diagnostic, all: &[Diagnostic]) -> Vec<Fix> {
    let is_parse = |diagnostic: &&Diagnostic| {
        dotgen_syntax::codes::find(diagnostic.code).is_some()
            && diagnostic.severity == Severity::Error
            && !codes::is_environment(diagnostic.code)
    };
    if of.severity != Severity::Error {
        return Vec::new();
    }
    let text = db.file(&of.path).text(db);
    let line = |at: usize| text.get(..at).map(|text| text.matches('\n').count());
    // Other errors on the same line are consequences and disappear with it.
    let here = all.iter().filter(|diagnostic| diagnostic.path == of.path).filter(is_parse);
    let mut here = here.filter(|diagnostic| line(diagnostic.range.start) == line(of.range.start));
    let Some(cause) = Some(of).filter(is_parse).or_else(|| here.next()) else {
        return Vec::new();
    };
    let repairs = trial::repairs(text, text_range(&cause.range));
    repairs.into_iter().map(|repair| repair.within(&of.path)).collect()
}

/// Returns true if a quote is missing somewhere in a file: a literal is not closed, or a string begins like
/// the text after one. From there on text and strings may be exchanged, and apparent errors may be in the
/// words of the author.
#[salsa::tracked(returns(copy))]
fn has_odd_quote(db: &dyn Db, file: SourceFile) -> bool {
    let text = file.text(db);
    let raw = &lexed(db, file).raw;
    (0..raw.len()).any(|i| match raw.kind(i) {
        SyntaxKind::OPEN_STRING => true,
        SyntaxKind::STRING => {
            let string = &text[raw.range(i)];
            let inner = string.trim_start_matches('"').trim_start();
            inner.starts_with([';', ',', ')', '}'])
        }
        _ => false,
    })
}

/// A diagnostic about a comment.
fn remark<'db>(
    db: &'db dyn Db,
    key: FileKey<'db>,
    kind: LintWarning,
    range: TextRange,
) -> Diagnostic {
    let kind = FindingKind::from(kind);
    Diagnostic {
        fixes: fixes_at(db, key, &kind, range, &[]),
        ..shown(&kind, None, None, key.file(db).path(db), range)
    }
}

/// The finding for a code that a comment allows but that does not occur.
pub(crate) fn unused_allowance(code: &str, known: bool) -> LintWarning {
    let code = code.into();
    if known {
        LintWarning::UnusedAllowance { code }
    } else {
        LintWarning::UnknownAllowance { code }
    }
}

/// Codes of a layer above (`family`, of which `known` exist) that comments of a root allow but that none of
/// its findings has there. `found` must include the allowed findings.
pub(crate) fn unused_allowances(
    db: &dyn Db,
    path: &Utf8Path,
    family: &str,
    known: &[&str],
    found: &[Diagnostic],
) -> Vec<Diagnostic> {
    let file = db.file(path);
    // Another unit may need the comments of an included file.
    if roots_of(db, file).first() != Some(&file) {
        return Vec::new();
    }
    let unit = unit::serving_unit(db, file);
    let Some((_, key)) = unit::serving_visit(db, unit, file) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for suppression in suppressions(db, key).iter() {
        let scope = bytes(suppression.scope);
        let has = |found: &Diagnostic, code: &str| {
            let related = found.related.iter().map(|related| (&related.path, &related.range));
            let mut places = std::iter::once((&found.path, &found.range)).chain(related);
            found.code == code
                && places.any(|place| place.0 == path && scope.contains(&place.1.start))
        };
        let codes = suppression.codes.iter().filter(|code| code.0.starts_with(family));
        for (code, range) in codes {
            if is_switched_off(db, code) || found.iter().any(|diagnostic| has(diagnostic, code)) {
                continue;
            }
            let kind = unused_allowance(code, known.contains(&code.as_str()));
            out.push(remark(db, key, kind, *range));
        }
    }
    configure(db, &mut out);
    out
}

/// Applies the configured severities to findings of a layer above, and removes allowed ones. A comment at any
/// place of a finding counts.
pub(crate) fn adjust(db: &dyn Db, mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    diagnostics.retain(|diagnostic| {
        let related = diagnostic.related.iter().map(|related| (&related.path, &related.range));
        let mut places = std::iter::once((&diagnostic.path, &diagnostic.range)).chain(related);
        !places.any(|(path, range)| is_allowed(db, path, range.start, diagnostic.code))
    });
    configure(db, &mut diagnostics);
    diagnostics
}

/// Returns true if a comment of a specification allows a code at a place.
fn is_allowed(db: &dyn Db, path: &Utf8Path, at: usize, code: &str) -> bool {
    let file = db.file(path);
    // Sources in other languages are not parsed here.
    if !roots_of(db, file).iter().any(|root| *root != file)
        && !db.workspace().roots(db).iter().any(|root| root == path)
    {
        return false;
    }
    let unit = unit::serving_unit(db, file);
    let Some((_, key)) = unit::serving_visit(db, unit, file) else {
        return false;
    };
    suppressions(db, key).iter().any(|suppression| {
        bytes(suppression.scope).contains(&at)
            && suppression.codes.iter().any(|(allowed, _)| allowed == code)
    })
}

/// The configured severity of a code; `Some(None)` if it is switched off.
fn setting(db: &dyn Db, code: &str) -> Option<Option<Severity>> {
    let configured = db.workspace().severities(db);
    configured.iter().rev().find(|(candidate, _)| candidate == code).map(|setting| setting.1)
}

/// Returns true if the configuration gives a code a severity.
fn is_configured(db: &dyn Db, code: &str) -> bool {
    matches!(setting(db, code), Some(Some(_)))
}

/// Returns true if the configuration switches a code off.
pub(crate) fn is_switched_off(db: &dyn Db, code: &str) -> bool {
    setting(db, code) == Some(None)
}

/// Applies the configured severities. Errors are defined by the language and stay.
fn configure(db: &dyn Db, diagnostics: &mut Vec<Diagnostic>) {
    diagnostics.retain_mut(|diagnostic| {
        let configured =
            setting(db, diagnostic.code).filter(|_| diagnostic.severity != Severity::Error);
        if let Some(Some(severity)) = configured {
            diagnostic.severity = severity;
        }
        configured != Some(None)
    });
}
