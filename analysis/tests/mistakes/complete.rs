//! What completion offers is legal: taking an item brings no error that was not there.
//!
//! A place is a boundary of tokens of a right text: in front of a token, or in a word of which a few letters are typed.
//! The item is inserted as an editor does it, and the text must have no error that it has not without the item.
//!
//! * In a word, the item takes the place of the word; all that stands behind stays, and nothing is added.
//! * In front of a token, the item begins something new, which may be completed by a name and a separator; in the middle
//!   of an element, it may be meant for the name or type that follows.
//! * In the first word of a statement, the item may also begin one in front of it.
//! * Where the item is only the beginning of something (`port`, `in`, `pause::`), one of the items that are offered
//!   behind it must do.
//!
//! `COMPLETIONS=400` tries so many places with all their items, `COMPLETIONS=all` every place.

use std::collections::BTreeMap;

use dotgen_analysis::{
    host::{Analysis, Change, Config},
    ide::{CompletionItem, FilePosition, plain_snippet},
};

use super::{mutate::Random, *};

/// Places tried in the suite, and items of each.
const PLACES: usize = 260;
const ITEMS: usize = 3;

/// How many errors of each code.
type Errors = BTreeMap<String, usize>;

/// One component in an analysis whose text is changed again and again.
struct Bench<'a> {
    component: &'a Component,
    host: AnalysisHost,
    right: Errors,
}

impl<'a> Bench<'a> {
    fn new(component: &'a Component) -> Bench<'a> {
        let loader = Overlay {
            path: component.path.clone(),
            text: component.text.clone(),
            packages: component.includes.clone(),
        };
        let mut host = AnalysisHost::new(Arc::new(loader));
        host.apply(Change {
            roots: Some(vec![component.path.clone()]),
            config: Some(Config {
                include_dirs: component.includes.clone(),
                ..Config::default()
            }),
            ..Change::default()
        });
        let mut bench = Bench {
            component,
            host,
            right: Errors::new(),
        };
        bench.right = bench.errors(&component.text);
        bench
    }

    fn with(&mut self, text: &str) -> Analysis {
        self.host.apply(Change {
            files: vec![(self.component.path.clone(), Some(text.to_owned()))],
            ..Change::default()
        });
        self.host.analysis()
    }

    fn errors(&mut self, text: &str) -> Errors {
        let path = self.component.path.clone();
        let all = self.with(text).root_diagnostics(&path).unwrap();
        let mut out = Errors::new();
        // Two uses of one codel must agree: while one of them is changed, they cannot.
        let own = |it: &&Diagnostic| it.code != "codel-conflict";
        for it in all
            .iter()
            .filter(|it| it.severity == Severity::Error)
            .filter(own)
        {
            *out.entry(it.code.to_string()).or_default() += 1;
        }
        out
    }

    fn items(&mut self, text: &str, offset: usize) -> Vec<CompletionItem> {
        let path = self.component.path.clone();
        let at = FilePosition { path, offset };
        self.with(text).completions(&at).unwrap()
    }
}

/// Where something may be typed.
struct Place {
    /// Everything before the cursor, with the letters typed.
    before: String,
    /// How many letters.
    typed: usize,
    /// Where the right text goes on.
    rest: usize,
    /// The cursor is in or at a word, which an item takes the place of.
    in_word: bool,
}

/// A text up to the cursor behind an item, and how much of what follows it takes the place of.
fn taken(before: &str, item: &CompletionItem) -> (String, usize) {
    let mut out = before[..item.replace.start.min(before.len())].to_owned();
    match item.snippet {
        true => out.push_str(&plain_snippet(&item.insert)),
        false => out.push_str(&item.insert),
    }
    (out, item.replace.end.saturating_sub(before.len()))
}

/// Ends of what an item may take the place of: nothing, or the word, path or type that begins behind the cursor, if the
/// cursor is in the middle of an element.
fn ends(tokens: &[(std::ops::Range<usize>, String)], place: &Place) -> Vec<usize> {
    let mut out = vec![place.rest];
    let at = tokens.partition_point(|it| it.0.start < place.rest);
    let begins = at == 0 || matches!(tokens[at - 1].1.as_str(), "," | ";" | "{" | "}" | "(" | "<");
    if place.in_word || begins {
        return out;
    }
    let is_word = |it: &str| it.starts_with(|it: char| it.is_ascii_alphanumeric() || it == '_');
    let (mut depth, mut path) = (0, false);
    for (i, (range, text)) in tokens[at..].iter().enumerate() {
        match text.as_str() {
            "<" if i > 0 => depth += 1,
            ">" if depth > 0 => depth -= 1,
            "::" | ":" => path = true,
            _ if depth > 0 => {}
            "unsigned" | "long" => path = true,
            it if is_word(it) && (i == 0 || path) => path = false,
            _ => break,
        }
        if depth == 0 && !path {
            out.push(range.end);
        }
    }
    out
}

/// Whether a text with what follows has no new error. Where an element begins, it may be completed.
fn goes_on(
    bench: &mut Bench<'_>,
    text: &str,
    rest: usize,
    glue: &[&str],
    allowed: &Errors,
) -> bool {
    glue.iter().any(|glue| {
        let whole = format!("{text}{glue}{}", &bench.component.text[rest..]);
        let errors = bench.errors(&whole);
        errors
            .iter()
            .all(|(code, count)| *count <= allowed.get(code).copied().unwrap_or_default())
    })
}

fn is_legal(
    bench: &mut Bench<'_>,
    place: &Place,
    item: &CompletionItem,
    tokens: &[(std::ops::Range<usize>, String)],
) -> bool {
    // What is wrong anyway while somebody is typing here.
    let untyped = &place.before[..place.before.len() - place.typed];
    let hole = format!("{untyped}{}", &bench.component.text[place.rest..]);
    let mut allowed = bench.errors(&hole);
    for (code, count) in &bench.right {
        let known = allowed.entry(code.clone()).or_default();
        *known = (*known).max(*count);
    }
    let completed: &[&str] = &["", ";", ",", " zz;", " zz,", " zz"];
    let mut ways: Vec<(usize, &[&str])> = Vec::new();
    for rest in ends(tokens, place) {
        ways.push((rest, if place.in_word { &[""] } else { completed }));
    }
    // A new statement in front of the one that begins with the word.
    let at = tokens.partition_point(|it| it.0.end < place.rest);
    let begins = at == 0 || matches!(tokens[at - 1].1.as_str(), ";" | "{" | "}" | "#");
    if let Some(word) = tokens.get(at).filter(|_| place.in_word && begins) {
        ways.push((word.0.start, &[" ", " zz; ", "\n#"]));
    }
    for (rest, glue) in ways {
        let (text, more) = taken(&place.before, item);
        // What it replaces begins where the cursor is, whatever is left out.
        let rest = rest.max(place.rest + more);
        if goes_on(bench, &text, rest, glue, &allowed) {
            return true;
        }
        // The beginning of something: one of what is offered next has to be legal.
        for joint in [" ", ""] {
            let begun = format!("{text}{joint}");
            let behind = format!("{begun}{}", &bench.component.text[rest..]);
            let next = bench.items(&behind, begun.len());
            for it in next.iter().take(8) {
                let (text, more) = taken(&begun, it);
                if goes_on(bench, &text, rest + more, glue, &allowed) {
                    return true;
                }
            }
        }
    }
    false
}

/// The places of a text.
fn places(text: &str, tokens: &[(std::ops::Range<usize>, String)]) -> Vec<Place> {
    let mut out = Vec::new();
    for (range, word) in tokens {
        out.push(Place {
            before: format!("{} ", text[..range.start].trim_end_matches(' ')),
            typed: 0,
            rest: range.start,
            in_word: false,
        });
        let is_word = word.starts_with(|it: char| it.is_ascii_alphabetic());
        for typed in [0, 1, 3, word.len()] {
            if is_word && typed <= word.len() {
                out.push(Place {
                    before: text[..range.start + typed].to_owned(),
                    typed,
                    rest: range.end,
                    in_word: true,
                });
            }
        }
    }
    out
}

fn tokens(text: &str) -> Vec<(std::ops::Range<usize>, String)> {
    let root = dotgen_syntax::parse_text(text).syntax();
    let all = root
        .descendants_with_tokens()
        .filter_map(|it| it.into_token());
    let live = all.filter(|it| !it.kind().is_trivia() && !it.text_range().is_empty());
    let ranges = live.map(|it| std::ops::Range::<usize>::from(it.text_range()));
    ranges.map(|it| (it.clone(), text[it].to_owned())).collect()
}

#[test]
fn what_is_offered_is_legal() {
    let wanted = std::env::var("COMPLETIONS").ok();
    let (count, items) = match wanted.as_deref() {
        Some("all") => (usize::MAX, usize::MAX),
        Some(it) => (it.parse().unwrap_or(PLACES), usize::MAX),
        None => (PLACES, ITEMS),
    };
    let mut components = examples();
    components.extend(super::components(
        &root().join("analysis/tests/data/model"),
        &[],
    ));
    components.extend(published());
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let (mut tried, mut visited) = (0, 0);
    let mut bad: BTreeMap<String, (usize, String)> = BTreeMap::new();
    for component in &components {
        let mut bench = Bench::new(component);
        let text = &component.text;
        let tokens = tokens(text);
        let all = places(text, &tokens);
        let share = (count / components.len()).max(1);
        let chosen: Vec<usize> = match share >= all.len() {
            true => (0..all.len()).collect(),
            false => (0..share).map(|_| random.below(all.len())).collect(),
        };
        for place in chosen.into_iter().map(|it| &all[it]) {
            visited += 1;
            let now = format!("{}{}", place.before, &text[place.rest..]);
            let typed = place.before[place.before.len() - place.typed..].to_lowercase();
            let mut offered = bench.items(&now, place.before.len());
            offered.retain(|it| it.label.to_lowercase().starts_with(&typed));
            while offered.len() > items {
                offered.swap_remove(random.below(offered.len()));
            }
            for item in offered {
                tried += 1;
                if !is_legal(&mut bench, place, &item, &tokens) {
                    let line = now[..place.before.len()]
                        .rsplit('\n')
                        .next()
                        .unwrap_or_default();
                    let after = now[place.before.len()..].lines().next().unwrap_or_default();
                    let name = component.path.file_name().unwrap_or_default();
                    let what = format!("{:?}: `{}`", item.kind, item.label);
                    let (taken, more) = taken(&place.before, &item);
                    let taken = taken + &text[place.rest + more..];
                    let errors: Vec<String> = bench.errors(&taken).into_keys().collect();
                    let example = format!("{name}: {} | {after} {errors:?}", line.trim_start());
                    bad.entry(what).or_insert((0, example)).0 += 1;
                }
            }
        }
    }
    println!("{tried} items at {visited} places");
    let lines = bad
        .iter()
        .map(|(what, (times, example))| format!("{times} x {what} in {example}"));
    let lines: Vec<String> = lines.collect();
    assert!(
        lines.is_empty(),
        "{} of {tried} items:\n{}",
        lines.len(),
        lines.join("\n")
    );
    assert!(tried > PLACES, "only {tried} items");
}
