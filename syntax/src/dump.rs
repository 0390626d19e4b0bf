//! Trees as text, for tests and `dotgen tree`.

use std::fmt::Write as _;

use rowan::{NodeOrToken, WalkEvent};

use crate::{Parse, encoding};

/// One line for each node and token, indented, with its byte range; the errors below.
///
/// A token that comes out of a macro is shown with the text it stands for after an arrow.
pub fn dump(parse: &Parse) -> String {
    let mut out = String::new();
    let mut depth = 0;
    for event in parse.syntax().preorder_with_tokens() {
        let element = match event {
            WalkEvent::Enter(element) => element,
            WalkEvent::Leave(element) => {
                depth -= usize::from(element.as_node().is_some());
                continue;
            }
        };
        let _ = write!(
            out,
            "{:indent$}{:?}@{:?}",
            "",
            element.kind(),
            element.text_range(),
            indent = depth * 2
        );
        match element {
            NodeOrToken::Node(_) => depth += 1,
            NodeOrToken::Token(token) => {
                let _ = match parse.expansion.virtual_token(&token) {
                    Some(token) => write!(out, " -> {:?}", token.text),
                    None => write!(out, " {:?}", encoding::shown(token.text())),
                };
            }
        }
        out.push('\n');
    }
    for error in &parse.errors {
        let _ = writeln!(
            out,
            "{:?} {:?} {}: {}",
            error.severity,
            error.range,
            error.code(),
            error.wording()
        );
        if let Some((range, what)) = &error.related {
            let _ = writeln!(out, "  {range:?}: {what}");
        }
    }
    out
}
