//! The formatter behind the editor's requests: a whole file, a range, and formatting while typing.

use std::ops::Range;

use dotgen_syntax::format::{self, Options, Unit};
use dotgen_syntax::line_index::line_start;
use dotgen_syntax::{SyntaxKind, TextRange};

use super::{
    FileView,
    context::{Context, FrameKind, Surroundings, surroundings},
};
use crate::{
    diagnostic::FileEdit,
    source_map::{bytes, offset, text_range},
};

/// The formatting edits for a file, or for the part of it that touches a range.
pub(crate) fn format(
    view: &FileView<'_>,
    within: Option<Range<usize>>,
    options: &Options,
) -> Vec<FileEdit> {
    edits(view, within.map(|range| text_range(&range)), options)
}

fn edits(view: &FileView<'_>, within: Option<TextRange>, options: &Options) -> Vec<FileEdit> {
    let edits = format::format(&view.root(), &view.parse().broken(), within, options);
    let edits = edits.into_iter().map(|edit| FileEdit {
        path: view.file.path(view.db).clone(),
        range: bytes(edit.range),
        new_text: edit.new_text,
    });
    edits.collect()
}

/// The edits that follow from typing `;`, `}` or a line end, just before the cursor.
pub(crate) fn on_type(
    view: &FileView<'_>,
    at: usize,
    typed: char,
    options: &Options,
) -> Vec<FileEdit> {
    if at > view.text().len() || !view.text().is_char_boundary(at) {
        return Vec::new();
    }
    match typed {
        '\n' => indentation(view, at, options).into_iter().collect(),
        _ => statement(view, at, typed, options),
    }
}

/// Formats the statement or body that was just closed, but nothing after the cursor.
fn statement(view: &FileView<'_>, at: usize, typed: char, options: &Options) -> Vec<FileEdit> {
    let root = view.root();
    let token = root.token_at_offset(offset(at)).left_biased();
    let closes = |token: &dotgen_syntax::SyntaxToken| {
        let kind = if typed == '}' { SyntaxKind::R_CURLY } else { SyntaxKind::SEMICOLON };
        token.kind() == kind && usize::from(token.text_range().end()) == at
    };
    let Some(token) = token.filter(closes) else {
        return Vec::new();
    };
    let mut node = token.parent();
    if let Some(body) = node.clone().filter(|node| node.kind() == SyntaxKind::BODY) {
        node = body.parent();
    }
    let Some(node) = node.filter(|node| node.parent().is_some()) else {
        return Vec::new();
    };
    let range = bytes(view.node_range(&node));
    // With the indentation of its first line.
    let line = line_start(view.text(), range.start);
    let blank = view.text()[line..range.start].trim().is_empty();
    let start = if blank { line } else { range.start };
    let mut out = edits(view, Some(text_range(&(start..at))), options);
    out.retain(|edit| line <= edit.range.end && edit.range.end <= at);
    out
}

/// Indents the line of the cursor as the formatter would indent it, or leave it.
fn indentation(view: &FileView<'_>, at: usize, options: &Options) -> Option<FileEdit> {
    let text = view.text();
    if surroundings(view, at) != Surroundings::Code {
        return None;
    }
    let line = line_start(text, at);
    let rest = &text[line..];
    let blanks = rest.len() - rest.trim_start_matches([' ', '\t']).len();
    let content = rest[blanks..].chars().next();
    if matches!(content, Some('#')) {
        return None;
    }
    let own = format::unit_of(&view.root());
    let unit = options.unit.or(own).unwrap_or(options.otherwise);
    let context = Context::new(view, line);
    let top = context.top();
    let column = match top.kind {
        FrameKind::Paren | FrameKind::Bracket => {
            let open = context.tokens[top.open].range.end;
            continuation(text, open, line, unit)
        }
        _ => {
            let bodies = context.frames.iter().skip(1);
            let bodies = bodies
                .filter(|body| matches!(body.kind, FrameKind::Body(_) | FrameKind::Initializers));
            let mut depth = bodies.count();
            if content == Some('}') {
                depth = depth.saturating_sub(1);
            } else if !context.current().is_empty() {
                depth += 1;
            }
            depth * unit.columns()
        }
    };
    let new_text = unit.indentation(column);
    (rest[..blanks] != new_text).then(|| FileEdit {
        path: view.file.path(view.db).clone(),
        range: line..line + blanks,
        new_text,
    })
}

/// Column of a line that continues a list: the column of the line before, if that line continues it as well.
/// A list that begins on the line of its name is indented by two units, to distinguish it from the body.
fn continuation(text: &str, open: usize, line: usize, unit: Unit) -> usize {
    let indentation = |start: usize| {
        let rest = &text[start..];
        let blanks = rest.len() - rest.trim_start_matches([' ', '\t']).len();
        unit.column_of(&rest[..blanks])
    };
    let opens_on = line_start(text, open);
    let before = line_start(text, line.saturating_sub(1));
    if before > opens_on {
        return indentation(before);
    }
    let goes_on = text[open..line].chars().any(|character| !character.is_whitespace());
    let units = if goes_on { 2 } else { 1 };
    indentation(opens_on) + units * unit.columns()
}

#[cfg(test)]
mod tests {
    use dotgen_syntax::format::Options;

    use crate::{ide::speculate::apply, test_support::Fixture};

    #[track_caller]
    fn typed(text: &str, what: char, expected: &str) {
        let fixture = Fixture::new(text);
        let edits =
            fixture.analysis().format_on_type(&fixture.at(), what, &Options::default()).unwrap();
        assert_eq!(apply(&fixture.text("/main.gen"), &edits), expected);
    }

    #[test]
    fn files_and_ranges() {
        let text = "struct   a { long x; };\nstruct  b { long x; };\n";
        let fixture = Fixture::new(text);
        let path = camino::Utf8Path::new("/main.gen");
        let all = fixture.analysis().format(path, None, &Options::default()).unwrap();
        let all = apply(text, &all);
        assert!(all.starts_with("struct a {"), "{all}");
        let second = fixture.analysis().format(path, Some(24..41), &Options::default()).unwrap();
        let second = apply(text, &second);
        assert!(second.starts_with("struct   a { long x; };\n"), "{second}");
        assert!(second.contains("struct b"), "{second}");
    }

    #[test]
    fn a_region_that_does_not_parse_is_left_alone() {
        let text = "struct  a { long ; };\nstruct  b { long x; };\n";
        let fixture = Fixture::new(text);
        let edits = fixture
            .analysis()
            .format(camino::Utf8Path::new("/main.gen"), None, &Options::default())
            .unwrap();
        let out = apply(text, &edits);
        assert!(out.starts_with("struct  a { long ; };\n") && out.contains("struct b"), "{out}");
    }

    #[test]
    fn semicolons_and_braces() {
        typed(
            "component c {\n      version   \"1\" ;$0\n  lang   \"c\";\n};\n",
            ';',
            "component c {\n  version \"1\";\n  lang   \"c\";\n};\n",
        );
        typed(
            "module m {\n   typedef  long  t ;\n   }$0\n",
            '}',
            "module m {\n  typedef long t;\n}\n",
        );
        typed("// a;$0\n", ';', "// a;\n");
    }

    #[test]
    fn new_lines_are_indented() {
        typed("component c {\n$0", '\n', "component c {\n  ");
        typed(
            "component c {\n  task t {\n$0\n  };\n};\n",
            '\n',
            "component c {\n  task t {\n    \n  };\n};\n",
        );
        typed(
            "component c {\n  task t {\n    $0};\n};\n",
            '\n',
            "component c {\n  task t {\n  };\n};\n",
        );
        typed(
            "component c {\n  function f(in long a,\n$0",
            '\n',
            "component c {\n  function f(in long a,\n      ",
        );
        typed(
            "component c {\n  function f(in long a,\n             in long b,\n$0",
            '\n',
            "component c {\n  function f(in long a,\n             in long b,\n             ",
        );
        typed(
            "component c {\n    task t;\n    function f(\n$0",
            '\n',
            "component c {\n    task t;\n    function f(\n        ",
        );
        typed(
            "component c {\n\ttask t {\n$0\n\t};\n};\n",
            '\n',
            "component c {\n\ttask t {\n\t\t\n\t};\n};\n",
        );
        typed(
            "component c {\n  codel<start> f()\n$0",
            '\n',
            "component c {\n  codel<start> f()\n    ",
        );
        typed("/* a\n$0 */", '\n', "/* a\n */");
    }
}
