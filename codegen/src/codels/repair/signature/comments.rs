//! The comments between the parameters of a prototype.

use rustc_hash::FxHashSet;

use super::{Function, IndexedFile, Pair};

/// The new prototype with the comments between the parameters, each parameter on its own line. `None` if
/// there is no comment.
pub(super) fn with_comments(
    file: &IndexedFile,
    function: &Function,
    pairs: &[Pair],
    prototype: &str,
) -> Option<String> {
    let text = &file.text;
    let last = function.parameters.last()?;
    let list = text.get(function.name_span.end..function.signature_span.end)?;
    if !list.contains("/*") && !list.contains("//") {
        return None;
    }
    // A comment belongs to the next parameter, unless it is on the line where the previous one ends.
    let mut before: Vec<Vec<String>> = vec![Vec::new(); function.parameters.len()];
    let mut behind = before.clone();
    let mut at = function.name_span.end;
    for (index, parameter) in function.parameters.iter().enumerate() {
        let gap = text.get(at..parameter.span.start)?;
        for (comment, own_line) in comments(gap) {
            match index.checked_sub(1).filter(|_| !own_line) {
                Some(previous) => behind[previous].push(comment),
                None => before[index].push(comment),
            }
        }
        at = parameter.span.end;
    }
    let gap = text.get(last.span.end..function.signature_span.end)?;
    behind[function.parameters.len() - 1]
        .extend(comments(gap).into_iter().map(|comment| comment.0));
    let open = prototype.find('(')?;
    let head = &prototype[..=open];
    let column = head.len() - head.rfind('\n').map_or(0, |head| head + 1);
    let indent = " ".repeat(column);
    let declarations = split(prototype[open + 1..].strip_suffix(')')?);
    let mut out = head.to_owned();
    let count = declarations.len();
    let kept: FxHashSet<usize> = pairs.iter().filter_map(|pair| pair.found).collect();
    for (index, declaration) in declarations.into_iter().enumerate() {
        if index > 0 {
            out += &format!("\n{indent}");
        }
        let own = pairs.get(index).and_then(|pair| pair.found);
        for comment in own.iter().flat_map(|&found| &before[found]) {
            out += &format!("{comment}\n{indent}");
        }
        out += &declaration;
        let is_last = index + 1 == count;
        if !is_last {
            out.push(',');
        }
        let mut tail: Vec<&String> = own.iter().flat_map(|&found| &behind[found]).collect();
        if is_last {
            // Comments of removed parameters are kept too.
            let gone = (0..function.parameters.len()).filter(|parameter| !kept.contains(parameter));
            tail.extend(
                gone.flat_map(|parameter| before[parameter].iter().chain(&behind[parameter])),
            );
        }
        for (number, comment) in tail.iter().enumerate() {
            out += &format!(" {comment}");
            let ends_line = comment.starts_with("//");
            if ends_line && (number + 1 < tail.len() || is_last) {
                out += &format!("\n{indent}");
            }
        }
    }
    out.push(')');
    Some(out)
}

/// The comments of a text between parameters. The flag is true for a comment on a later line than the start
/// of the text.
fn comments(gap: &str) -> Vec<(String, bool)> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(found) = gap[at..].find("/*").into_iter().chain(gap[at..].find("//")).min() {
        let start = at + found;
        let length = if gap[start..].starts_with("/*") {
            gap[start..].find("*/").map(|gap| gap + 2)
        } else {
            gap[start..].find('\n')
        };
        let end = length.map_or(gap.len(), |length| start + length);
        out.push((gap[start..end].trim_end().to_owned(), gap[..start].contains('\n')));
        at = end;
    }
    out
}

/// The declarations of a list, split at the commas outside brackets.
pub(super) fn split(list: &str) -> Vec<String> {
    let (mut out, mut depth, mut from) = (Vec::new(), 0i32, 0);
    for (at, c) in list.char_indices() {
        match c {
            '(' | '<' | '[' => depth += 1,
            ')' | '>' | ']' => depth -= 1,
            ',' if depth == 0 => {
                out.push(list[from..at].trim().to_owned());
                from = at + 1;
            }
            _ => {}
        }
    }
    out.push(list[from..].trim().to_owned());
    out
}
