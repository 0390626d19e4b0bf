//! Queries, one after the other.

use super::cursor::Cursor;
use crate::ast::Form;
use crate::error::Res;
use crate::lexer::{Kind, Token, tokens};

/// The queries of a text, each with its byte range. A query ends before the next line that starts one.
pub(crate) fn queries(text: &str) -> Res<Vec<(u32, u32, Form)>> {
    let all = tokens(text)?;
    let mut starts: Vec<usize> = Vec::new();
    for (index, token) in all.iter().enumerate() {
        let first = index == 0 || newline(text, all[index - 1], *token);
        let continues = starts.last().is_some_and(|_| continues(&all, index));
        if token.kind != Kind::End && first && !continues {
            starts.push(index);
        }
    }
    let mut out = Vec::new();
    for (number, start) in starts.iter().enumerate() {
        let from = all[*start].at as usize;
        let next = starts.get(number + 1).map_or(text.len(), |next| all[*next].at as usize);
        let last = starts.get(number + 1).copied().unwrap_or(all.len() - 1) - 1;
        let end = (all[last].at as usize + all[last].text.len()).min(next);
        // Blanks before the query keep the places of errors right.
        let padded: String = text[..from].chars().map(blank).collect::<String>() + &text[from..end];
        out.push((from as u32, end as u32, query(&padded)?));
    }
    Ok(out)
}

/// A blank of the same length in bytes for any character but a line end.
fn blank(character: char) -> String {
    if character == '\n' { "\n".to_owned() } else { " ".repeat(character.len_utf8()) }
}

fn newline(text: &str, before: Token<'_>, token: Token<'_>) -> bool {
    let end = before.at as usize + before.text.len();
    text.get(end..token.at as usize).is_some_and(|between| between.contains('\n'))
}

/// Reports whether the line of a token continues the query before: an operator is next to the line end,
/// or a bracket is open.
fn continues(all: &[Token<'_>], index: usize) -> bool {
    let word = |text: &str| matches!(text, "and" | "or" | "imply" | "not");
    let before = all[index - 1];
    let open = matches!(before.text, "[]" | "<>" | ":" | "(" | "{" | "[" | ",");
    let operator =
        before.kind == Kind::Symbol && !matches!(before.text, ")" | "]" | "}" | ";" | "--" | "++");
    let here = all[index];
    let starts = matches!(here.text, "(" | "!" | "-" | "+");
    open || operator
        || word(before.text)
        || word(here.text)
        || (here.kind == Kind::Symbol && !starts)
}

fn query(text: &str) -> Res<Form> {
    let mut cursor = Cursor::new(text)?;
    let form = form(&mut cursor)?;
    cursor.eat(";");
    match (&form, cursor.peek().kind) {
        (Form::Refused(_), _) | (_, Kind::End) => Ok(form),
        _ => cursor.unexpected("the end of the query"),
    }
}

fn form(cursor: &mut Cursor<'_>) -> Res<Form> {
    let (first, second) = (cursor.peek().text, cursor.ahead(1).text);
    match (first, second) {
        ("A", "[]") => {
            cursor.bump();
            cursor.bump();
            Ok(Form::Always(cursor.expr()?))
        }
        ("E", "<>") => {
            cursor.bump();
            cursor.bump();
            Ok(Form::Reachable(cursor.expr()?))
        }
        ("A", "<>") => {
            Ok(Form::Refused("liveness `A<>` is not supported: only `A[]`, `E<>`, `sup`, `inf`"))
        }
        ("E", "[]") => {
            Ok(Form::Refused("liveness `E[]` is not supported: only `A[]`, `E<>`, `sup`, `inf`"))
        }
        ("Pr" | "simulate", "[" | "{" | "(") | ("E", "[") => Ok(Form::Refused(
            "statistical queries are not supported: only `A[]`, `E<>`, `sup`, `inf`",
        )),
        ("sup" | "inf", "{" | ":") => extremes(cursor),
        _ => {
            cursor.expr()?;
            if cursor.eat("-->") {
                return Ok(Form::Refused(
                    "liveness `-->` is not supported: only `A[]`, `E<>`, `sup`, `inf`",
                ));
            }
            cursor.unexpected("`A[]`, `E<>`, `sup` or `inf` before a predicate, or `-->` after one")
        }
    }
}

fn extremes(cursor: &mut Cursor<'_>) -> Res<Form> {
    let highest = cursor.bump().text == "sup";
    let within = if cursor.eat("{") {
        let predicate = cursor.expr()?;
        cursor.expect("}")?;
        Some(predicate)
    } else {
        None
    };
    cursor.expect(":")?;
    let mut of = vec![cursor.expr()?];
    while cursor.eat(",") {
        of.push(cursor.expr()?);
    }
    Ok(Form::Extremes { highest, within, of })
}
