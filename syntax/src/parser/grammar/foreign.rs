//! Habits of other languages: each is one finding, and is read as what it stands for.

use super::*;

/// Reads a type of the standard library of C++ as the type of the language that it stands for.
pub(super) fn type_of_cpp(p: &mut Parser<'_>) {
    if !p.at(IDENT) || p.is_reported() {
        return;
    }
    let qualified = p.nth(1) == COLON2 && p.current_text() == "std";
    let last = if qualified { 2 } else { 0 };
    let kind = match p.nth_text(last).as_str() {
        "string" => STRING_KW,
        "optional" if p.nth(last + 1) == L_ANGLE => OPTIONAL_KW,
        "vector" | "array" | "list" | "deque" if p.nth(last + 1) == L_ANGLE => SEQUENCE_KW,
        _ => return,
    };
    p.read_foreign(last + 1, kind);
}

/// Reports `typedef struct { … } NAME;`, whose name belongs behind `struct`.
pub(super) fn anonymous(p: &mut Parser<'_>, typedef: usize) {
    const WORDS: TokenSet = TokenSet::new(&[STRUCT_KW, ENUM_KW]);
    if !p.at_ts(WORDS) || p.nth(1) != L_CURLY || p.is_reported() {
        return;
    }
    let (mut open, start) = (0u32, p.position() + 1);
    let close = (start..start + braces::LOOK_AHEAD).find(|token| {
        match p.input.kind(*token) {
            L_CURLY => open += 1,
            R_CURLY => open -= 1,
            EOF => open = 0,
            _ => {}
        }
        open == 0
    });
    let name = close.map_or(start, |close| close + 1);
    if p.input.kind(name) == IDENT && p.input.kind(name + 1) == SEMICOLON {
        let (word, name_text) = (p.current_text(), p.nth_text_at(name));
        let text = format!("{word} {name_text} {}", p.source(start..name));
        let (word, name_text) = (word.into(), name_text.into());
        p.push_error(start, Parsing::Anonymous { word, name: name_text });
        p.replace(typedef..name + 1, &text, true);
        p.nameless = Some(start);
    }
}

/// Reads `->` before a name as `.`.
pub(super) fn arrow(p: &mut Parser<'_>) -> bool {
    let found = p.at(MINUS) && p.nth(1) == R_ANGLE && p.nth(2) == IDENT && !p.is_reported();
    if found {
        let at = p.position();
        p.push_error(at, Parsing::ForeignSign { found: "`->`".into(), sign: "." });
        p.replace(at..at + 2, ".", true);
        p.skip_tokens(2);
    }
    found
}

/// A line as in another language: a comment after `--`, or `import` with the name of a file.
pub(super) fn line(p: &mut Parser<'_>) -> bool {
    let at = p.position();
    if p.at(MINUS) && p.nth(1) == MINUS && p.is_glued() {
        p.error_here(Parsing::ForeignComment);
        p.replace(at..at + 2, "//", true);
        p.bump_any();
        while !p.at(EOF) && !p.starts_line() {
            p.bump_any();
        }
        return true;
    }
    let word = p.current_text();
    let end = if p.nth(2) == SEMICOLON { 3 } else { 2 };
    let alone = (at == 0 || p.starts_line()) && (p.nth(end) == EOF || p.nth_starts_line(end));
    if !matches!(word.as_str(), "import" | "include") || p.nth(1) != STRING || !alone {
        return false;
    }
    let text = format!("#include {}", p.nth_text(1));
    p.error_here(Parsing::ForeignInclude { word: word.into() });
    p.replace(at..at + end, &text, true);
    (0..end).for_each(|_| p.bump_any());
    true
}

/// Skips a word before the type and the name of a port: `port in puts t p;`.
pub(super) fn extra_word(p: &mut Parser<'_>) {
    const END: TokenSet = TokenSet::new(&[SEMICOLON, L_CURLY]);
    let words = (0..3).all(|n| p.nth(n) == IDENT && !p.nth_starts_line(n));
    if !words || !p.nth_at_ts(3, END) || p.is_reported() {
        return;
    }
    let (at, word) = (p.position(), p.current_text().into());
    p.push_error(at, Parsing::ExtraWord { word });
    p.replace(at..at + 1, "", false);
    p.skip_tokens(1);
}

/// Reads `and` or `or` between two names of a line as a comma.
pub(super) fn joined_by_word(p: &mut Parser<'_>) -> bool {
    let is_word = p.at(IDENT) && p.nth(1) == IDENT && !p.starts_line() && !p.nth_starts_line(1);
    let word = p.current_text();
    if !is_word || !matches!(word.as_str(), "and" | "or") || p.is_reported() {
        return false;
    }
    let at = p.position();
    let text = format!("{},", p.nth_text_at(at - 1));
    p.push_error(at, Parsing::ForeignSign { found: format!("`{word}`").into(), sign: "," });
    p.replace(at - 1..at + 1, &text, true);
    p.skip_tokens(1);
    true
}

/// Reads `pause` and a state without the `::` between them.
pub(super) fn pause_and_state(p: &mut Parser<'_>) -> bool {
    const AFTER: TokenSet = TokenSet::new(&[COMMA, SEMICOLON]);
    let apart = p.at(PAUSE_KW) && p.nth(1) == IDENT && p.nth_at_ts(2, AFTER);
    if !apart || p.nth_starts_line(1) || p.is_reported() {
        return false;
    }
    p.bump(PAUSE_KW);
    let found = p.describe_current().into();
    p.push_error(p.position(), Parsing::SingleColon { found });
    p.insert_behind("::", true);
    true
}
