//! Repairs of syntax errors that are found by trial: small changes around an error are tried in turn, and the
//! changes with the fewest remaining errors are kept.
//!
//! The grammar itself knows a repair if it follows from the expected token
//! ([`dotgen_syntax::parser::Repair`]). The other common mistakes are few: a missing, doubled or wrong
//! character, two words in the wrong order, a superfluous word. All of them are tried, the most likely first.

use std::ops::Range;

use dotgen_syntax::{
    Fragment, SyntaxKind, TextRange,
    lexer::{RawTokens, lex},
    parse,
    preproc::{MacroEnv, NoIncludes, PpError, preprocess},
    suggestion::nearest_keyword,
};

use rustc_hash::FxHashSet;

use super::TextFix;
use crate::{codes::is_environment, diagnostic::FixKind, source_map::text_range};

/// Maximum length of a text in bytes: each trial parses all of it.
const MAX_BYTES: usize = 128 * 1024;

/// Maximum number of repairs for an error.
const MOST_KEPT: usize = 4;

/// Number of tokens before an error that are candidates.
const BEFORE: usize = 2;

/// Number of tokens from an error onwards that are candidates.
const BEHIND: usize = 2;

/// Tokens that are often left out, with the side of the error that is tried first.
const INSERTED: [&str; 11] =
    [";", ",", ">", ")", "]", "::", "=", "<", "in ", "yield ", "codel<start> "];

/// Marks that are often confused.
const MARKS: [&str; 12] = [";", ",", ":", "::", ".", "(", ")", "[", "]", "{", "}", ">"];

/// A change to try.
struct CandidateFix {
    title: String,
    edits: Vec<(Range<usize>, String)>,
    /// Lower is more likely.
    cost: u32,
}

/// The repairs of a syntax error at a place of a text, the best first: those after which the fewest errors
/// are left, and fewer than before.
pub(crate) fn repairs(text: &str, at: TextRange) -> Vec<TextFix> {
    if text.len() > MAX_BYTES {
        return Vec::new();
    }
    let before = errors_in(text);
    let mut kept: Vec<(usize, CandidateFix)> = Vec::new();
    // Which one of two equal marks is removed makes no difference.
    let mut seen: FxHashSet<String> = FxHashSet::default();
    let mut trials = trials(text, at);
    trials.sort_by_key(|trial| trial.cost);
    for trial in trials {
        let new = applied(text, &trial.edits);
        let left = errors_in(&new);
        if left < before && seen.insert(new) {
            kept.push((left, trial));
        }
    }
    kept.sort_by_key(|(left, _)| *left);
    let best = kept.first().map(|(left, _)| *left);
    kept.retain(|(left, _)| Some(*left) == best);
    kept.truncate(MOST_KEPT);
    let fix = |(_, trial): (usize, CandidateFix)| TextFix {
        kind: FixKind::Guess,
        title: trial.title,
        edits: trial.edits.into_iter().map(|(range, text)| (text_range(&range), text)).collect(),
    };
    kept.into_iter().map(fix).collect()
}

/// Number of errors of the lexer, the preprocessor and the parser, without those in included files.
fn errors_in(text: &str) -> usize {
    let raw = lex(text);
    let read = preprocess(&"".into(), text, &raw, MacroEnv::default(), &mut NoIncludes);
    let missing = |error: &&PpError| is_environment(error.kind.code());
    let missing = read.errors.iter().filter(missing).count();
    let parse = parse(text, &raw, &read, Fragment::Specification);
    read.errors.len() - missing + parse.errors.len() + usize::from(parse.inside_out.is_some())
}

fn applied(text: &str, edits: &[(Range<usize>, String)]) -> String {
    let mut out = text.to_owned();
    for (range, new) in edits.iter().rev() {
        out.replace_range(range.clone(), new);
    }
    out
}

/// The tokens around an error.
struct Window<'t> {
    text: &'t str,
    raw: RawTokens,
    /// Indexes of tokens that are not trivia, in order.
    tokens: Vec<usize>,
    /// Index into `tokens` of the one at the error.
    at: usize,
}

impl Window<'_> {
    fn range(&self, number: usize) -> Range<usize> {
        self.raw.range(self.tokens[number])
    }

    fn token(&self, number: usize) -> &str {
        &self.text[self.range(number)]
    }

    fn kind(&self, number: usize) -> SyntaxKind {
        self.raw.kind(self.tokens[number])
    }

    fn around(&self) -> Range<usize> {
        let end = (self.at + BEHIND).min(self.tokens.len());
        self.at.saturating_sub(BEFORE).min(end)..end
    }

    /// The distance of a token from the error. It is 0 at the error itself; at equal distance, tokens before
    /// the error are nearer than those after it.
    fn distance(&self, number: usize) -> u32 {
        let far = number.abs_diff(self.at) as u32;
        2 * far + u32::from(number > self.at)
    }

    fn is_mark(&self, number: usize) -> bool {
        !self.token(number).starts_with(|character: char| {
            character.is_alphanumeric() || matches!(character, '_' | '"' | '\'')
        })
    }
}

fn trials(text: &str, at: TextRange) -> Vec<CandidateFix> {
    let raw = lex(text);
    let is_code = |index: &usize| !raw.kind(*index).is_trivia();
    let tokens: Vec<usize> = (0..raw.len()).filter(is_code).collect();
    let start = usize::from(at.start());
    let error = tokens.partition_point(|token| raw.range(*token).end <= start);
    let window = Window { text, raw, at: error, tokens };
    let mut out = Vec::new();
    removals(&window, at, &mut out);
    replacements(&window, &mut out);
    insertions(&window, &mut out);
    exchanges(&window, &mut out);
    c_constructs(&window, &mut out);
    out
}

/// Removals: a mark, a word, or the whole range of the error.
fn removals(window: &Window<'_>, at: TextRange, out: &mut Vec<CandidateFix>) {
    let mut remove = |range: Range<usize>, cost: u32| {
        let title = format!("Remove `{}`", window.text[range.clone()].trim());
        let range = with_blank(window.text, range);
        out.push(CandidateFix { title, edits: vec![(range, String::new())], cost });
    };
    let whole = usize::from(at.start())..usize::from(at.end());
    if !whole.is_empty() && !window.text[whole.clone()].contains('\n') {
        remove(whole, 24);
    }
    for first in window.around() {
        let is_doubled = first > 0 && window.token(first) == window.token(first - 1);
        let base = match window.is_mark(first) {
            true if is_doubled => 4,
            true => 12,
            false => 30,
        };
        for last in first..(first + 3).min(window.tokens.len()) {
            let range = window.range(first).start..window.range(last).end;
            let of_item = last > first && [";", "{", "}"].contains(&window.token(last));
            if of_item || window.text[range.clone()].contains('\n') {
                break;
            }
            remove(range, base + 6 * (last - first) as u32 + window.distance(first));
        }
    }
}

/// Replacements of a word by the keyword near it, of one mark by another, one kind of quotes by the other, or
/// comment marks.
fn replacements(window: &Window<'_>, out: &mut Vec<CandidateFix>) {
    let words = SyntaxKind::spellings().iter().map(|spelling| spelling.1);
    for number in window.around() {
        let (range, token) = (window.range(number), window.token(number));
        let mut replace = |with: &str, cost: u32| {
            out.push(CandidateFix {
                title: format!("Change `{token}` to `{with}`"),
                edits: vec![(range.clone(), with.to_owned())],
                cost: cost + window.distance(number),
            });
        };
        match window.kind(number) {
            SyntaxKind::OPEN_STRING | SyntaxKind::CHAR => {
                let inner = token.trim_matches('\'');
                if token.len() > 2 && token.starts_with('\'') && !inner.contains(['"', '\n']) {
                    replace(&format!("\"{inner}\""), 2);
                }
            }
            SyntaxKind::HASH | SyntaxKind::STRAY if token.starts_with('#') => {
                let before = window.text[..range.start].rsplit('\n').next();
                // A directive begins a line.
                if before.is_some_and(|part| !part.trim().is_empty()) {
                    replace("//", 2);
                }
            }
            SyntaxKind::IDENT => {
                if let Some(word) = nearest_keyword(token, words.clone()) {
                    replace(word, 1);
                }
            }
            _ if window.is_mark(number) => {
                for mark in MARKS.into_iter().filter(|mark| *mark != token) {
                    replace(mark, if is_similar(token, mark) { 3 } else { 14 });
                }
            }
            _ => {}
        }
    }
}

/// Returns true if two marks look similar or are used in similar places.
fn is_similar(a: &str, b: &str) -> bool {
    const LIKE: [&[&str]; 4] =
        [&[";", ":", ","], &[":", "::", "."], &["(", "[", "{", "<"], &[")", "]", "}", ">"]];
    LIKE.iter().any(|all| all.contains(&a) && all.contains(&b))
}

/// Insertions before the error, or before the token before it.
fn insertions(window: &Window<'_>, out: &mut Vec<CandidateFix>) {
    for number in window.around().skip(1).take(BEFORE) {
        let behind = window.range(number - 1).end;
        let before = window.range(number).start;
        for (rank, what) in (0u32..).zip(INSERTED) {
            // A word goes before the text it belongs to, a mark after the text it ends.
            let is_word = what.ends_with(' ');
            if is_word && window.is_mark(number) {
                continue;
            }
            let at = if is_word { before } else { behind };
            let base = if is_word { 2 } else { 8 + rank };
            out.push(CandidateFix {
                title: format!("Insert `{}`", what.trim()),
                edits: vec![(at..at, what.to_owned())],
                cost: base + window.distance(number),
            });
        }
    }
}

/// Exchanges: two neighbours in the wrong order, one word in two pieces, and the length of an array before
/// the name.
fn exchanges(window: &Window<'_>, out: &mut Vec<CandidateFix>) {
    for first in window.around() {
        let Some(second) = Some(first + 1).filter(|second| *second < window.tokens.len()) else {
            break;
        };
        let (a, b) = (window.range(first), window.range(second));
        let (one, other) = (window.token(first), window.token(second));
        let between = &window.text[a.end..b.start];
        if !between.trim().is_empty() {
            continue;
        }
        let is_word =
            |token: &str| token.starts_with(|character: char| character.is_ascii_alphabetic());
        let words = is_word(one) && is_word(other);
        if words {
            out.push(CandidateFix {
                title: format!("Write `{other} {one}`"),
                edits: vec![(a.start..b.end, format!("{other}{between}{one}"))],
                cost: 10 + window.distance(first),
            });
        }
        // Two words are one only if that one exists.
        let joined = format!("{one}{other}");
        let exists = || {
            let is_same = |token: &usize| window.text[window.raw.range(*token)] == joined;
            is_spelling(&joined) || window.tokens.iter().any(is_same)
        };
        if !between.is_empty() && (!words || exists()) {
            out.push(CandidateFix {
                title: format!("Write `{one}{other}`"),
                edits: vec![(a.start..b.end, format!("{one}{other}"))],
                cost: 9 + window.distance(first),
            });
        }
        // `octet[4] code`
        let close =
            (first..window.tokens.len().min(first + 8)).find(|token| window.token(*token) == "]");
        if one == "["
            && let Some(close) = close
            && close + 1 < window.tokens.len()
        {
            let group = a.start..window.range(close).end;
            let name = window.range(close + 1);
            let length = window.text[group.clone()].to_owned();
            out.push(CandidateFix {
                title: format!("Write `{length}` behind `{}`", window.token(close + 1)),
                edits: vec![(group.clone(), String::new()), (name.end..name.end, length)],
                cost: 5,
            });
        }
    }
}

/// Constructs of C: a pointer to characters, `typedef` before a structure, a comment that does not end.
fn c_constructs(window: &Window<'_>, out: &mut Vec<CandidateFix>) {
    for number in window.around() {
        let second = number + 1;
        if window.token(number) == "char"
            && second < window.tokens.len()
            && window.token(second) == "*"
        {
            let range = window.range(number).start..window.range(second).end;
            let glued =
                window.text[range.end..].starts_with(|character: char| !character.is_whitespace());
            out.push(CandidateFix {
                title: "Change `char *` to `string`".to_owned(),
                edits: vec![(range, if glued { "string " } else { "string" }.to_owned())],
                cost: 1,
            });
        }
    }
    let word = (0..window.at.min(window.tokens.len()))
        .rev()
        .find(|token| window.token(*token) == "typedef");
    if let Some(word) = word {
        let range = with_blank(window.text, window.range(word));
        out.push(CandidateFix {
            title: "Remove `typedef`".to_owned(),
            edits: vec![(range, String::new())],
            cost: 20,
        });
    }
    for number in window.around() {
        let (start, token) = (window.range(number).start, window.token(number));
        let line = token.lines().next().unwrap_or_default();
        if window.kind(number) == SyntaxKind::STRING && line.len() < token.len() {
            let text = line.trim_end().trim_end_matches([';', ',', ')', ' ']);
            let at = start + text.len();
            out.push(CandidateFix {
                title: "Close the text with `\"`".to_owned(),
                edits: vec![(at..at, "\"".to_owned())],
                cost: 1,
            });
        }
    }
    for token in 0..window.raw.len() {
        let range = window.raw.range(token);
        if !matches!(window.raw.kind(token), SyntaxKind::BLOCK_COMMENT | SyntaxKind::OPEN_COMMENT) {
            continue;
        }
        if let Some(at) = window.text[range.clone()].find("* /") {
            let at = range.start + at;
            out.push(CandidateFix {
                title: "Change `* /` to `*/`".to_owned(),
                edits: vec![(at..at + 3, "*/".to_owned())],
                cost: 1,
            });
        }
    }
}

/// Returns true for the spelling of a keyword.
fn is_spelling(word: &str) -> bool {
    SyntaxKind::spellings().iter().any(|spelling| spelling.1 == word)
}

/// A range with the blank behind it, or before it at the end of a line.
fn with_blank(text: &str, range: Range<usize>) -> Range<usize> {
    if text[range.end..].starts_with(' ') && text[..range.start].ends_with([' ', '\n', '(', '<']) {
        range.start..range.end + 1
    } else if text[..range.start].ends_with(' ') && !text[range.end..].starts_with(' ') {
        range.start - 1..range.end
    } else {
        range
    }
}
