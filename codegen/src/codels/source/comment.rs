//! Comments above functions, and the sentences of the skeleton in them.

use smol_str::SmolStr;
use tree_sitter::Node;

use super::{Span, ctype::source};

/// A comment; consecutive `//` lines are one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Comment {
    /// The place of the comment.
    pub span: Span,
    /// The sentences of the skeleton, if it is about a codel.
    pub generated: Option<Generated>,
}

/// `Codel NAME of OWNER. Triggered by … . Yields to … . Throws … .`
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Generated {
    /// The name of the codel.
    pub codel: SmolStr,
    /// `task`, `service`, `activity`, `function` or `attribute`.
    pub owner_kind: SmolStr,
    /// The name of the task or service.
    pub owner: SmolStr,
    /// `Validation codel`
    pub validation: bool,
    /// Names after `Triggered by`; `None` without this sentence.
    pub triggers: Option<Vec<SmolStr>>,
    /// Names after `Yields to`.
    pub yields: Option<Vec<SmolStr>>,
    /// Names after `Throws`.
    pub throws: Option<Vec<SmolStr>>,
    /// `Codel NAME of KIND OWNER`
    pub header: Span,
    /// From the first to the last of these sentences: the part that an update replaces. Empty, at the end of
    /// the header, if there are none.
    pub sentences: Span,
}

/// Comments between a function and the preceding declaration, nearest first.
pub(super) fn comments_above(function: Node<'_>, text: &str) -> Vec<Comment> {
    let mut out: Vec<Comment> = Vec::new();
    let mut below = function.start_byte();
    let mut node = function;
    while let Some(above) = node.prev_sibling().filter(|sibling| sibling.kind() == "comment") {
        let span = above.byte_range();
        let gap = text.get(span.end..below).unwrap_or("x");
        if !gap.trim().is_empty() || out.len() > 16 {
            break;
        }
        let line = source(above, text).starts_with("//");
        match out.last_mut() {
            Some(last)
                if line
                    && gap.matches('\n').count() <= 1
                    && text[last.span.clone()].starts_with("//") =>
            {
                last.span.start = span.start;
            }
            _ => out.push(Comment { span: span.clone(), generated: None }),
        }
        below = span.start;
        node = above;
    }
    for comment in &mut out {
        comment.generated = generated(text, &comment.span);
    }
    out
}

/// Reads the sentences of a comment of the skeleton; `None` for any other comment.
pub(crate) fn generated(text: &str, span: &Span) -> Option<Generated> {
    let mut words = words(text, span).into_iter().peekable();
    let mut out = Generated::default();
    // `Codel NAME of KIND NAME.`, the first words of the comment.
    let (first, start) = words.next()?;
    match first {
        "Validation" => {
            out.validation = true;
            if words.next()?.0 != "codel" {
                return None;
            }
        }
        "Codel" => {}
        _ => return None,
    }
    out.codel = words.next()?.0.into();
    if words.next()?.0 != "of" {
        return None;
    }
    out.owner_kind = words.next()?.0.into();
    let (owner, at) = words.next()?;
    let owner = owner.trim_end_matches('.');
    out.owner = owner.into();
    out.header = start.start..at.start + owner.len();
    let mut sentences: Option<Span> = None;
    while let Some((word, at)) = words.next() {
        let list = match (word, words.peek().map(|word| word.0)) {
            ("Triggered", Some("by")) => &mut out.triggers,
            ("Yields", Some("to")) => &mut out.yields,
            ("Throws", _) => &mut out.throws,
            ("Returns", Some("genom_ok." | ".")) => &mut None,
            _ => continue,
        };
        if word != "Throws" {
            words.next();
        }
        let mut names = Vec::new();
        let mut end = at.end;
        if word == "Returns" {
            end = at.start + text.get(at.start..).and_then(|text| text.find('.')).unwrap_or(0) + 1;
        } else {
            let mut closed = false;
            for (name, at) in words.by_ref() {
                end = at.end;
                let last = name.ends_with('.');
                let name = name.trim_end_matches(['.', ',']);
                names.extend(name.split(',').filter(|part| !part.is_empty()).map(SmolStr::from));
                if last {
                    closed = true;
                    break;
                }
            }
            // A sentence without a full stop is ordinary prose.
            if !closed {
                return None;
            }
        }
        list.get_or_insert(names);
        let span = sentences.get_or_insert(at.start..end);
        span.end = end;
    }
    out.sentences = sentences.unwrap_or(out.header.end..out.header.end);
    Some(out)
}

/// Words of a comment with their places, comment marks left out.
fn words<'t>(text: &'t str, span: &Span) -> Vec<(&'t str, Span)> {
    let mut out = Vec::new();
    let Some(all) = text.get(span.clone()) else {
        return out;
    };
    let mut at = span.start;
    for line in all.split_inclusive('\n') {
        let mut first = true;
        for word in line.split_whitespace() {
            // The word is a part of `line`, so the distance is its place.
            let start = at + (word.as_ptr() as usize - line.as_ptr() as usize);
            let marks = word.chars().all(|c| matches!(c, '/' | '*' | '!' | '<'));
            if (first || word.ends_with("*/")) && marks {
                first = false;
                continue;
            }
            first = false;
            out.push((word, start..start + word.len()));
        }
        at += line.len();
    }
    out
}
