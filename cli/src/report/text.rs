//! `--format text`: for people, in the style of rustc.

use std::io::Write;
use std::ops::Range;

use annotate_snippets::{
    Annotation, AnnotationKind, Group, Level, Origin, Patch, Renderer, Snippet,
};
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Fix, Severity};
use dotgen_analysis::parallel;
use dotgen_analysis::terminal;
use dotgen_syntax::encoding;

use super::{Compared, FileReports};
use crate::session::{self, Texts};
use crate::width::{with_titles_broken, with_titles_broken_for_errors};
use dotgen_lsp_server::protocol::convert::Lines;
use dotgen_platform::panic;

/// Maximum length of a line that is shown, in bytes.
const LONGEST_LINE: usize = 1000;
/// Maximum distance in lines at which an explanation in the same file shares a snippet.
const MAX_SNIPPET_LINES: u32 = 40;

/// Prints diagnostics and a summary line.
pub(crate) fn print(report: &FileReports) -> anyhow::Result<()> {
    let mut out = std::io::BufWriter::new(anstream::AutoStream::auto(std::io::stdout().lock()));
    let (texts, cores) = (&report.texts, parallel::cores());
    // In parts: there may be many texts.
    for some in report.diagnostics.chunks(1024) {
        let parts: Vec<&[Diagnostic]> = some.chunks(some.len().div_ceil(4 * cores)).collect();
        let one = |part: &&[Diagnostic]| -> String {
            let all = part.iter().map(|part| render(part, texts) + "\n\n");
            all.collect()
        };
        for text in parallel::map(&parts, || (), one, |(), part| one(part)) {
            let text = encoding::shown(&text);
            out.write_all(with_titles_broken(&terminal::styled(&text)).as_bytes())?;
        }
    }
    let in_part = |comparison: &&Compared| !comparison.coverage.is_complete();
    for comparison in report.compared.iter().filter(in_part) {
        let (file, component) =
            (terminal::name(&comparison.file), terminal::text(&comparison.component));
        writeln!(out, "{file}: {component}: {}", comparison.coverage)?;
    }
    // If nothing could be checked, the errors give the reason.
    if report.checked > 0 || !report.diagnostics.is_empty() {
        writeln!(out, "{}", summary(report))?;
    }
    Ok(out.flush()?)
}

/// Prints the errors, on standard error.
pub(crate) fn print_errors(diagnostics: &[Diagnostic], texts: &Texts) -> anyhow::Result<()> {
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
    print_to_stderr(errors, texts)
}

/// Prints some diagnostics, on standard error.
pub(crate) fn print_to_stderr<'d>(
    diagnostics: impl IntoIterator<Item = &'d Diagnostic>,
    texts: &Texts,
) -> anyhow::Result<()> {
    let mut out = anstream::AutoStream::auto(std::io::stderr().lock());
    for diagnostic in diagnostics {
        let text = render(diagnostic, texts);
        let text = encoding::shown(&text);
        writeln!(out, "{}\n", with_titles_broken_for_errors(&terminal::styled(&text)))?;
    }
    Ok(())
}

/// `checked 3 files: 2 errors, 1 warning; 2 names wait for openrobots2-idl`
fn summary(report: &FileReports) -> String {
    let counted = |count: usize, one: &str, many: &str| match count {
        1 => format!("1 {one}"),
        _ => format!("{count} {many}"),
    };
    let mut found: Vec<String> = [
        (Severity::Error, "error", "errors"),
        (Severity::Warning, "warning", "warnings"),
        (Severity::Information, "remark", "remarks"),
        (Severity::Hint, "hint", "hints"),
    ]
    .into_iter()
    .map(|(severity, one, many)| (report.count(severity), one, many))
    .filter(|(count, ..)| *count > 0)
    .map(|(count, one, many)| counted(count, one, many))
    .collect();
    if report.incomplete > 0 {
        found.push(counted(report.incomplete, "file lacks codels", "files lack codels"));
    }
    let files = counted(report.checked, "file", "files");
    let mut out = if found.is_empty() {
        format!("checked {files}: no problems")
    } else {
        format!("checked {files}: {}", found.join(", "))
    };
    for waiting in &report.waiting {
        let (names, wait) = match waiting.names.len() {
            1 => ("1 name".to_owned(), "waits"),
            count => (format!("{count} names"), "wait"),
        };
        out += &format!("; {names} {wait} for {}", terminal::text(&waiting.missing.join(", ")));
    }
    out
}

/// Renders one diagnostic. The output stream removes colours if necessary.
fn render(diagnostic: &Diagnostic, texts: &Texts) -> String {
    let render = || {
        let mut groups = vec![main_group(diagnostic, texts)];
        groups.extend(diagnostic.fixes.first().and_then(|fix| fix_group(fix, texts)));
        Renderer::styled().render(&groups)
    };
    // The snippet library may panic on a text. The diagnostic is then printed without a snippet.
    panic::isolate(render).unwrap_or_else(|_| {
        let position = texts
            .get(&diagnostic.path)
            .map(|text| text.position(diagnostic.range.start))
            .unwrap_or_default();
        format!(
            "{}[{}]: {}\n  --> {}:{}:{}",
            name(diagnostic.severity),
            diagnostic.code,
            terminal::text(&diagnostic.message.to_string()),
            shown(&diagnostic.path),
            position.line + 1,
            position.character + 1,
        )
    })
}

fn name(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Information => "info",
        Severity::Hint => "hint",
    }
}

fn level(severity: Severity) -> Level<'static> {
    match severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Information => Level::INFO,
        Severity::Hint => Level::NOTE.with_name("hint"),
    }
}

/// Returns a path for a terminal. The snippet library escapes messages and sources.
fn shown(path: &Utf8Path) -> String {
    terminal::name(&session::display(path)).into_owned()
}

/// Ranges of one file that are shown together.
struct Excerpt<'d> {
    path: &'d Utf8PathBuf,
    marks: Vec<(Range<usize>, Option<String>)>,
}

fn main_group<'d>(diagnostic: &'d Diagnostic, texts: &'d Texts) -> Group<'d> {
    let mut excerpts =
        vec![Excerpt { path: &diagnostic.path, marks: vec![(diagnostic.range.clone(), None)] }];
    let line = |path: &Utf8Path, offset| texts.get(path).map(|text| text.position(offset).line);
    for related in &diagnostic.related {
        let at = line(&related.path, related.range.start);
        let near = |excerpt: &&mut Excerpt<'_>| {
            let first = excerpt.marks.first().and_then(|mark| line(excerpt.path, mark.0.start));
            excerpt.path == &related.path
                && first.zip(at).is_some_and(|(a, b)| a.abs_diff(b) <= MAX_SNIPPET_LINES)
        };
        let mark = (related.range.clone(), Some(related.message.to_string()));
        match excerpts.iter_mut().find(near) {
            Some(excerpt) => excerpt.marks.push(mark),
            None => excerpts.push(Excerpt { path: &related.path, marks: vec![mark] }),
        }
    }
    let mut group = level(diagnostic.severity)
        .primary_title(diagnostic.message.to_string())
        .id(diagnostic.code)
        .elements(Vec::<Origin<'_>>::new());
    for (index, excerpt) in excerpts.iter().enumerate() {
        group = add_excerpt(group, excerpt, index == 0, texts);
    }
    group
}

fn add_excerpt<'d>(
    group: Group<'d>,
    excerpt: &Excerpt<'d>,
    is_primary: bool,
    texts: &'d Texts,
) -> Group<'d> {
    let path = shown(excerpt.path);
    let Some(lines) = texts.get(excerpt.path) else {
        return group.element(Origin::path(path));
    };
    let ranges = excerpt.marks.iter().map(|mark| mark.0.clone());
    let Some(window) = Window::around(lines, ranges) else {
        let start = excerpt.marks.first().map_or(0, |mark| mark.0.start);
        let at = lines.position(start);
        let origin =
            Origin::path(path).line(at.line as usize + 1).char_column(at.character as usize + 1);
        return group.element(origin);
    };
    let marks = excerpt.marks.iter().enumerate();
    let annotations = marks.map(|(index, (range, label))| {
        let kind = if index == 0 && is_primary {
            AnnotationKind::Primary
        } else {
            AnnotationKind::Context
        };
        let annotation: Annotation<'_> = kind.span(window.span(lines, range));
        annotation.label(label.as_deref().map(|label| terminal::text(label).into_owned()))
    });
    group.element(
        Snippet::source(window.text(lines))
            .line_start(window.first_line)
            .path(path)
            .annotations(annotations.collect::<Vec<_>>()),
    )
}

/// Returns the title of a fix for use after a colon, without its capital letter.
pub(crate) fn title(of_fix: &str) -> String {
    let mut rest = of_fix.chars();
    let first = rest.next().into_iter().flat_map(char::to_lowercase);
    first.chain(rest).collect()
}

/// Returns the best fix as a patch, if it is in one file.
fn fix_group<'d>(fix: &'d Fix, texts: &'d Texts) -> Option<Group<'d>> {
    let path = &fix.edits.first()?.path;
    let lines = texts.get(path)?;
    let title = terminal::text(&title(&fix.title)).into_owned();
    if fix.edits.iter().any(|edit| edit.path != *path) {
        return Some(Group::with_title(Level::HELP.secondary_title(title)));
    }
    let ranges = fix.edits.iter().map(|edit| edit.range.clone());
    let window = Window::around(lines, ranges)?;
    let patches = fix.edits.iter().map(|edit| {
        let range = edit.range.start - window.bytes.start..edit.range.end - window.bytes.start;
        Patch::new(range, edit.new_text.as_str())
    });
    let snippet = Snippet::source(window.text(lines))
        .line_start(window.first_line)
        .path(shown(path))
        .patches(patches.collect::<Vec<_>>());
    Some(Level::HELP.secondary_title(title).element(snippet))
}

/// Whole lines of a file.
struct Window {
    bytes: Range<usize>,
    /// From 1.
    first_line: usize,
}

impl Window {
    /// Returns the lines in which the ranges begin and the edits end, or `None` if one is too long to show.
    fn around(lines: &Lines, ranges: impl Iterator<Item = Range<usize>>) -> Option<Window> {
        let (mut first, mut last) = (u32::MAX, 0);
        let mut end = 0;
        for range in ranges {
            let line = lines.position(range.start).line;
            first = first.min(line);
            last = last.max(line).max(lines.position(range.end).line);
            end = end.max(range.end);
        }
        let last = last.min(first.saturating_add(2 * MAX_SNIPPET_LINES));
        for line in first..=last {
            if lines.line(line)?.len() > LONGEST_LINE {
                return None;
            }
        }
        Some(Window {
            bytes: lines.line(first)?.start..lines.line(last)?.end,
            first_line: first as usize + 1,
        })
    }

    /// Returns the text, with line ends that the snippet library knows. The length stays.
    fn text(&self, lines: &Lines) -> String {
        let text = &lines.text()[self.bytes.clone()];
        let mut bytes = text.chars().peekable();
        let mut out = String::with_capacity(text.len());
        while let Some(c) = bytes.next() {
            let lone = c == '\r' && bytes.peek() != Some(&'\n');
            out.push(if lone { '\n' } else { c });
        }
        out
    }

    /// Converts a range to one in [`Window::text`]. Of several lines, the first is shown.
    fn span(&self, lines: &Lines, range: &Range<usize>) -> Range<usize> {
        let line = lines.position(range.start).line;
        let line_end = lines.line(line).map_or(range.end, |line| line.end);
        let start = range.start.min(line_end);
        let end = range.end.min(line_end).max(start);
        start - self.bytes.start..end - self.bytes.start
    }
}

#[cfg(test)]
mod tests;
