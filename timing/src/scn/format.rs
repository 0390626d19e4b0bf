//! Formatting: one item per line, two blanks per level. Comments, blank lines and lines of a long check are
//! kept.

use std::ops::Range;

use super::lexer::{Kind, lex};

/// Words before which a line break of the author is kept.
const CONTINUES: &[&str] = &["=>", "->", "then", "and", "or", "via"];

/// Returns the edits of blanks that format a text, in text order, or `None` if the text has errors.
pub fn format_edits(text: &str) -> Option<Vec<(Range<usize>, String)>> {
    let formatted = format(text)?;
    let (old, new) = (gaps(text), gaps(&formatted));
    // The formatter keeps every token. If it did not, the whole text would be one edit.
    if old.len() != new.len() {
        return Some(vec![(0..text.len(), formatted)]);
    }
    let changed = old.into_iter().zip(new);
    let changed = changed.filter(|(old, new)| text[old.clone()] != formatted[new.clone()]);
    Some(changed.map(|(old, new)| (old, formatted[new].to_owned())).collect())
}

/// The ranges between the tokens of a text, which contain only blanks. Blanks after a comment do not belong
/// to the comment.
fn gaps(text: &str) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut end = 0;
    for token in lex(text) {
        if token.kind != Kind::Space {
            out.push(end..token.range.start);
            end = token.range.start + text[token.range].trim_end().len();
        }
    }
    out.push(end..text.len());
    out
}

/// Returns the formatted text, or `None` if the text has errors.
pub fn format(text: &str) -> Option<String> {
    if !super::parse(text).errors.is_empty() {
        return None;
    }
    let mut out = String::new();
    let mut level = 0usize;
    let mut fresh = true;
    let mut before: Option<Kind> = None;
    let mut newlines = 0;
    let indented = |out: &mut String, fresh: &mut bool, level: usize| {
        if *fresh {
            out.push_str(&"  ".repeat(level));
            *fresh = false;
            true
        } else {
            false
        }
    };
    for token in lex(text) {
        let piece = &text[token.range.clone()];
        match token.kind {
            Kind::Space => {
                newlines = piece.matches('\n').count();
                continue;
            }
            Kind::LineComment | Kind::BlockComment => {
                if newlines > 0 && !fresh {
                    out.push('\n');
                    fresh = true;
                }
                if fresh && newlines > 1 && !out.is_empty() && !out.ends_with("{\n") {
                    out.push('\n');
                }
                // A comment after an item stays on its line.
                if newlines == 0 && fresh && out.ends_with('\n') && before.is_some() {
                    out.pop();
                    out.push(' ');
                    fresh = false;
                    out.push_str(piece.trim_end());
                } else {
                    if !indented(&mut out, &mut fresh, level) {
                        out.push(' ');
                    }
                    out.push_str(piece.trim_end());
                }
                if token.kind == Kind::LineComment {
                    out.push('\n');
                    fresh = true;
                }
                newlines = 0;
                continue;
            }
            _ => {}
        }
        if token.kind == Kind::CloseBrace {
            level = level.saturating_sub(1);
            if !fresh {
                out.push('\n');
                fresh = true;
            }
        } else if fresh && newlines > 1 && !out.is_empty() && !out.ends_with("{\n") {
            out.push('\n');
        }
        if before == Some(Kind::CloseBrace) && piece == "or" && out.ends_with('\n') {
            out.truncate(out.trim_end().len());
            out.push(' ');
            fresh = false;
        } else if newlines > 0 && !fresh && CONTINUES.contains(&piece) {
            out.push('\n');
            out.push_str(&"  ".repeat(level + 1));
        } else if !indented(&mut out, &mut fresh, level) && space_between(before, token.kind) {
            out.push(' ');
        }
        out.push_str(piece);
        match token.kind {
            Kind::OpenBrace => {
                level += 1;
                out.push('\n');
                fresh = true;
            }
            Kind::CloseBrace | Kind::Semicolon => {
                out.push('\n');
                fresh = true;
            }
            _ => {}
        }
        before = Some(token.kind);
        newlines = 0;
    }
    if !out.ends_with('\n') && !out.is_empty() {
        out.push('\n');
    }
    Some(out)
}

fn space_between(before: Option<Kind>, now: Kind) -> bool {
    let tight_after =
        matches!(before, None | Some(Kind::Dot | Kind::OpenParen | Kind::OpenBracket));
    let tight_before = matches!(
        now,
        Kind::Semicolon
            | Kind::Dot
            | Kind::Colon
            | Kind::CloseParen
            | Kind::CloseBracket
            | Kind::Comma
    );
    !tight_after && !tight_before
}
