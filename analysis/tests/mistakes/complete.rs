//! All completion items are legal: inserting an item causes no new error.
//!
//! A place is a boundary of tokens of a correct text: before a token, or inside a word of which a few letters
//! are typed. An item is illegal if the text has new errors with it for every continuation: with the text
//! that follows, without the next tokens, without the rest of the element or statement, or with one more item
//! behind it if the item is only the beginning of something (`port`, `in`, `pause::`).
//!
//! The environment variable `DOTGEN_TIMES` multiplies the number of places.

use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicUsize, Ordering},
};

use dotgen_analysis::{
    host::{Analysis, Change, Config},
    ide::{CompletionItem, FilePosition, plain_snippet},
};
use dotgen_syntax::NodeOrToken;

use super::*;

/// Number of places tried in the suite, each with all its items.
const PLACES: u64 = 120;

/// The number of errors of each code.
type Errors = BTreeMap<String, usize>;

/// One component in an analysis whose text is changed repeatedly.
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
            config: Some(Config { include_dirs: component.includes.clone(), ..Config::default() }),
            ..Change::default()
        });
        let mut bench = Bench { component, host, right: Errors::new() };
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
        for diagnostic in all.iter().filter(|diagnostic| diagnostic.severity == Severity::Error) {
            *out.entry(diagnostic.code.to_string()).or_default() += 1;
        }
        out
    }

    fn items(&mut self, text: &str, offset: usize) -> Vec<CompletionItem> {
        let path = self.component.path.clone();
        let at = FilePosition { path, offset };
        self.with(text).completions(&at).unwrap()
    }
}

/// A place for typing.
struct Place {
    /// The text before the cursor, with the typed letters.
    before: String,
    /// Number of typed letters.
    typed: usize,
    /// The offset at which the correct text continues.
    rest: usize,
    /// The word at the place, if one is replaced.
    word: String,
    /// True in an interface: a component must implement its declarations.
    in_interface: bool,
}

/// A text after inserting an item, and the offset of its cursor.
fn taken(before: &str, item: &CompletionItem) -> String {
    let mut out = before[..item.replace.start.min(before.len())].to_owned();
    if item.snippet {
        out.push_str(&plain_snippet(&item.insert));
    } else {
        out.push_str(&item.insert);
    }
    out
}

/// Ends of text that may be left out after a place: nothing, some tokens, the statement.
fn ends(tokens: &[(std::ops::Range<usize>, String)], from: usize) -> Vec<usize> {
    let after: Vec<_> = tokens.iter().filter(|token| token.0.start >= from).collect();
    let mut out = vec![from];
    let mut depth = 0_i32;
    for (i, (range, text)) in after.iter().enumerate() {
        match text.as_str() {
            "(" | "{" | "[" | "<" => depth += 1,
            ")" | "}" | "]" | ">" => depth -= 1,
            _ => {}
        }
        if depth < 0 && i > 0 {
            out.push(range.start);
            break;
        }
        if depth <= 0 && (text == "," || text == ";") {
            out.push(range.start);
        }
        // A type is left out together with its brackets, and so is a path.
        let closes = depth == 0 && matches!(text.as_str(), ")" | "}" | "]" | ">");
        let in_path = i > 0 && after[i - 1].1 == "::";
        if i < 4 || closes || in_path || depth == 0 && text == ";" {
            out.push(range.end);
        }
        if depth <= 0 && text == ";" {
            break;
        }
    }
    out.dedup();
    out
}

/// Errors about the consistency of two declarations. Another type for a variable that two services share, or
/// a service of an interface that a component of the file must still implement, is a legal item: the rest of
/// the work is elsewhere.
const OF_TWO: [&str; 10] = [
    "codel-conflict",
    "async/shared-attribute",
    "async/shared-resource",
    // A type that was chosen before its value; a port that an interface reverses.
    "const-convert",
    "param-read-only-port",
    // A `#pragma wcet` that repeats the clause.
    "wcet-pragma",
    "activity-start",
    "activity-task",
    "fsm/duplicate-state",
    "prop-duplicate",
];

/// Errors of an incomplete directive that has only its first word.
const OF_DIRECTIVES: [&str; 5] = [
    "pp-include-bad",
    "pragma-masquerade-syntax",
    "wcet-pragma",
    "pp-cond-unterminated",
    "syntax-eof",
];

/// Returns true if an error does not make an item illegal at a place.
fn is_beside(code: &str, place: &Place) -> bool {
    let line = place.before.rsplit('\n').next().unwrap_or_default();
    if line.trim_start().starts_with('#') {
        OF_DIRECTIVES.contains(&code)
    } else {
        OF_TWO[..if place.in_interface { 10 } else { 6 }].contains(&code)
    }
}

/// The new errors of the best continuation of a text: empty if one continuation has none.
fn goes_on(
    bench: &mut Bench<'_>,
    place: &Place,
    text: &str,
    rest: &[usize],
    allowed: &Errors,
) -> Vec<String> {
    let right = bench.component.text.clone();
    let same = format!(" {}", place.word);
    let mut best: Option<Vec<String>> = None;
    for &end in rest {
        for glue in ["", ";", ",", " zz", " zz;", " yield", &same] {
            let errors = bench.errors(&format!("{text}{glue}{}", &right[end..]));
            let new = errors.into_iter().filter(|(code, count)| {
                *count > allowed.get(code).copied().unwrap_or_default() && !is_beside(code, place)
            });
            let new: Vec<String> = new.map(|error| error.0).collect();
            if new.is_empty() {
                return new;
            }
            if best.as_ref().is_none_or(|string| new.len() < string.len()) {
                best = Some(new);
            }
        }
    }
    best.unwrap_or_default()
}

/// The errors of an item at a place for every continuation: empty if it is legal.
fn faults(
    bench: &mut Bench<'_>,
    place: &Place,
    item: &CompletionItem,
    tokens: &[(std::ops::Range<usize>, String)],
) -> Vec<String> {
    let right = bench.component.text.clone();
    // Errors that any text being typed here has.
    let hole =
        format!("{}{}", &place.before[..place.before.len() - place.typed], &right[place.rest..]);
    let mut allowed = bench.errors(&hole);
    for (code, count) in &bench.right {
        let known = allowed.entry(code.clone()).or_default();
        *known = (*known).max(*count);
    }
    let rest = ends(tokens, place.rest);
    let text = taken(&place.before, item);
    let faults = goes_on(bench, place, &text, &rest, &allowed);
    if faults.is_empty() {
        return faults;
    }
    // The beginning of something: one of the next items must be legal.
    for joint in [" ", "::", ""] {
        let begun = format!("{text}{joint}");
        let next = bench.items(&format!("{begun}{}", &right[place.rest..]), begun.len());
        for completion_item in next.iter().take(8) {
            if goes_on(bench, place, &taken(&begun, completion_item), &rest, &allowed).is_empty() {
                return Vec::new();
            }
        }
    }
    faults
}

/// The places of a text.
fn places(text: &str, tokens: &[(std::ops::Range<usize>, String)]) -> Vec<Place> {
    let mut out = Vec::new();
    let mut in_interface = false;
    for (range, word) in tokens {
        match word.as_str() {
            "interface" => in_interface = true,
            "component" => in_interface = false,
            _ => {}
        }
        out.push(Place {
            before: format!("{} ", text[..range.start].trim_end_matches(' ')),
            typed: 0,
            rest: range.start,
            word: String::new(),
            in_interface,
        });
        let is_word = word.starts_with(|character: char| character.is_ascii_alphabetic());
        for typed in [0, 1, 3, word.len()] {
            if is_word && typed <= word.len() {
                out.push(Place {
                    before: text[..range.start + typed].to_owned(),
                    typed,
                    rest: range.end,
                    word: word.clone(),
                    in_interface,
                });
            }
        }
    }
    out
}

fn tokens(text: &str) -> Vec<(std::ops::Range<usize>, String)> {
    let root = dotgen_syntax::parse_text(text).syntax();
    let all = root.descendants_with_tokens().filter_map(NodeOrToken::into_token);
    let live = all.filter(|token| !token.kind().is_trivia() && !token.text_range().is_empty());
    let ranges = live.map(|token| std::ops::Range::<usize>::from(token.text_range()));
    ranges.map(|range| (range.clone(), text[range].to_owned())).collect()
}

/// The results for a component's completions: places, items, and the number of illegal ones with an example.
#[derive(Default)]
struct Tried {
    places: usize,
    items: usize,
    illegal: BTreeMap<String, (usize, String)>,
}

/// Tries the items at `count` places of a component, or at all of them if it has fewer.
fn tried(component: &Component, count: usize, random: &mut fastrand::Rng) -> Tried {
    let mut bench = Bench::new(component);
    let text = &component.text;
    let tokens = tokens(text);
    let all = places(text, &tokens);
    let chosen: Vec<usize> = if count >= all.len() {
        (0..all.len()).collect()
    } else {
        (0..count).map(|_| random.usize(..all.len().max(1))).collect()
    };
    let mut tried = Tried::default();
    for place in chosen.into_iter().map(|place| &all[place]) {
        tried.places += 1;
        let now = format!("{}{}", place.before, &text[place.rest..]);
        let typed = place.before[place.before.len() - place.typed..].to_lowercase();
        let mut offered = bench.items(&now, place.before.len());
        offered.retain(|completion_item| completion_item.label.to_lowercase().starts_with(&typed));
        for item in offered {
            tried.items += 1;
            let faults = faults(&mut bench, place, &item, &tokens);
            if faults.is_empty() {
                continue;
            }
            let before = now[..place.before.len()].rsplit('\n').next();
            let after = now[place.before.len()..].lines().next();
            let (before, after) = (before.unwrap_or_default(), after.unwrap_or_default());
            let name = component.path.file_name().unwrap_or_default();
            let text = &item.insert;
            let example = format!("{name}: {} | {after} {faults:?} {text:?}", before.trim_start());
            let what = format!("{:?}: `{}`", item.kind, item.label);
            tried.illegal.entry(what).or_insert((0, example)).0 += 1;
        }
    }
    tried
}

#[test]
fn what_is_offered_is_legal() {
    let count = dotgen_loaders::times(PLACES) as usize;
    let mut components = examples();
    components.extend(super::components(&root().join("analysis/tests/data/model"), &[]));
    components.extend(published());
    let share = (count / components.len()).max(1);
    // Each component is tried separately, with its own analysis and random numbers, on all cores.
    let next = AtomicUsize::new(0);
    let work = || {
        let mut all = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(component) = components.get(at) else {
                return all;
            };
            let mut random = fastrand::Rng::with_seed(0x2545_f491_4f6c_dd1d + at as u64);
            all.push(tried(component, share, &mut random));
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let all: Vec<Tried> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        let results = workers.into_iter().flat_map(|worker| worker.join().unwrap());
        results.collect()
    });
    let places: usize = all.iter().map(|scope| scope.places).sum();
    let items: usize = all.iter().map(|scope| scope.items).sum();
    println!("{items} items at {places} places");
    let illegal = all.iter().flat_map(|scope| &scope.illegal);
    let lines: Vec<String> =
        illegal.map(|(what, (times, example))| format!("{times} x {what} in {example}")).collect();
    assert!(lines.is_empty(), "{} of {items} items:\n{}", lines.len(), lines.join("\n"));
    assert!(items > places, "only {items} items at {places} places");
}
