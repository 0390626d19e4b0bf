//! Edits that write execution times into specifications and scenarios, and change nothing else.

use std::ops::Range;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model::{Codel, CodelRef, ComponentId};
use dotgen_analysis::source_map::Locations;
use dotgen_syntax::encoding::LineEnd;
use dotgen_timing::scn::ast::{Item, Scenario};
use rustc_hash::FxHashMap;

use crate::proposal::written;

/// The form of a new execution time (language reference, section 17.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WcetForm {
    /// `wcet 1 ms` in the declaration of the codel.
    Clause,
    /// `#pragma wcet CODEL 1 ms`, which the reference compiler ignores.
    Pragma,
}

/// An execution time to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NewWcet {
    /// Index into [`dotgen_analysis::model::Spec::components`].
    pub component: ComponentId,
    pub codel: CodelRef,
    /// Execution time, in microseconds.
    pub micros: u64,
}

/// The reason why an execution time was not written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// The codel, or its present time, comes from a macro.
    Macro,
    /// Its present time contains a comment.
    Comment,
}

/// The edits for a text, and the execution times that must be changed by hand.
#[derive(Debug, Default)]
pub struct WcetEdits {
    /// Edits that do not overlap, by file, in order.
    pub edits: Vec<FileEdit>,
    /// Functions whose time must be changed by hand, with the reason.
    pub refused: Vec<(String, Refusal)>,
}

/// One use of a function.
struct CodelUse<'u> {
    codel: &'u Codel,
    path: Utf8PathBuf,
    range: Range<usize>,
    /// Place of its present time.
    time: Option<(Utf8PathBuf, Range<usize>)>,
    wanted: Option<u64>,
}

/// Returns the edits for one specification. A present time is changed in its place and form. A pragma applies
/// to a function, so it gets the greatest time of all uses of the function.
pub fn specification(
    unit: &UnitResult,
    text: &dyn Fn(&Utf8Path) -> Option<Arc<str>>,
    wanted: &[NewWcet],
    form: WcetForm,
) -> WcetEdits {
    let place = |src| unit.locations.locate(src).map(|location| (location.path, location.range));
    let mut uses: Vec<CodelUse<'_>> = Vec::new();
    for (index, component) in unit.spec.components.iter_enumerated() {
        for of in component.all_codels() {
            let codel = component.codel(of);
            let mut times = wanted.iter().filter(|wcet| wcet.component == index);
            let time = times.find(|time| time.codel == of).map(|time| time.micros);
            let Some((path, range)) = place(codel.node) else {
                continue;
            };
            // A service of an interface is declared once, however many components provide it.
            let same = |usage: &&mut CodelUse<'_>| usage.path == path && usage.range == range;
            if let Some(known) = uses.iter_mut().find(same) {
                known.wanted = known.wanted.max(time);
                continue;
            }
            uses.push(CodelUse {
                codel,
                path,
                range,
                time: codel.wcet.as_ref().and_then(|wcet| place(wcet.src)),
                wanted: time,
            });
        }
    }
    let mut functions: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
    for (number, usage) in uses.iter().enumerate() {
        functions.entry(&usage.codel.name).or_default().push(number);
    }
    let mut names: Vec<&str> = functions.keys().copied().collect();
    names.sort_unstable();
    let mut out = WcetEdits::default();
    for name in names {
        let of = functions.get(name).into_iter().flatten();
        let of: Vec<&CodelUse<'_>> = of.filter_map(|&function| uses.get(function)).collect();
        if of.iter().all(|usage| usage.wanted.is_none()) {
            continue;
        }
        match function(name, &of, text, form) {
            Ok(edits) => out.edits.extend(edits),
            Err(why) => out.refused.push((name.to_owned(), why)),
        }
    }
    out.edits.sort_by(|a, b| (&a.path, a.range.start).cmp(&(&b.path, b.range.start)));
    out
}

/// Adds the edits for all uses of one function.
fn function(
    name: &str,
    uses: &[&CodelUse<'_>],
    text: &dyn Fn(&Utf8Path) -> Option<Arc<str>>,
    form: WcetForm,
) -> Result<Vec<FileEdit>, Refusal> {
    let slice = |path: &Utf8Path, range: &Range<usize>| {
        text(path).and_then(|text| text.get(range.clone()).map(str::to_owned))
    };
    let greatest = uses.iter().filter_map(|usage| usage.wanted).max();
    let stands = |usage: &CodelUse<'_>| usage.time.clone();
    let pragma = uses.iter().filter_map(|usage| stands(usage)).find(|(path, range)| {
        slice(path, range).is_some_and(|slice| slice.trim_start().starts_with('#'))
    });
    if let (Some((path, range)), Some(micros)) = (pragma, greatest) {
        let old = slice(&path, &range).ok_or(Refusal::Macro)?;
        // The name may come from a macro as well. Such a pragma must not be replaced.
        if !old.split_whitespace().any(|word| word == name) {
            return Err(Refusal::Macro);
        }
        if has_comment(&old) {
            return Err(Refusal::Comment);
        }
        let kept = old.trim_end().len();
        return Ok(vec![FileEdit {
            path,
            range: range.start..range.start + kept,
            new_text: format!("#pragma wcet {name} {}", written(micros)),
        }]);
    }
    let clauses = uses.iter().any(|usage| usage.time.is_some());
    if form == WcetForm::Pragma && !clauses {
        let first = uses.iter().find(|usage| usage.wanted.is_some());
        let (Some(first), Some(micros)) = (first, greatest) else {
            return Ok(Vec::new());
        };
        let text = text(&first.path).ok_or(Refusal::Macro)?;
        return Ok(vec![insert_pragma_above(first, &text, name, micros)]);
    }
    let mut edits = Vec::new();
    for usage in uses {
        let Some(micros) = usage.wanted else { continue };
        let declaration = slice(&usage.path, &usage.range).unwrap_or_default();
        if !declaration.contains(name) || !declaration.contains('(') {
            return Err(Refusal::Macro);
        }
        let (range, new_text) = match &usage.time {
            None => {
                let end = usage.range.start + declaration.trim_end().len();
                (end..end, format!(" wcet {}", written(micros)))
            }
            Some((path, range)) => {
                let old = slice(path, range).unwrap_or_default();
                let inside = *path == usage.path && usage.range.start <= range.start;
                let word = old.starts_with("wcet");
                let bare = old.starts_with(|character: char| character.is_ascii_digit());
                if !inside || range.end > usage.range.end || !(word || bare) {
                    return Err(Refusal::Macro);
                }
                if has_comment(&old) {
                    return Err(Refusal::Comment);
                }
                let word = if word { "wcet " } else { "" };
                (range.clone(), format!("{word}{}", written(micros)))
            }
        };
        edits.push(FileEdit { path: usage.path.clone(), range, new_text });
    }
    Ok(edits)
}

/// Returns true if a text may contain a comment.
fn has_comment(text: &str) -> bool {
    text.contains("//") || text.contains("/*")
}

/// Adds a pragma above a declaration. If the declaration does not begin its line, the pragma goes to the end
/// of the file, where it has the same meaning.
fn insert_pragma_above(usage: &CodelUse<'_>, text: &str, name: &str, micros: u64) -> FileEdit {
    let end = LineEnd::of(text).as_str();
    let pragma = format!("#pragma wcet {name} {}{end}", written(micros));
    let before = text.get(..usage.range.start).unwrap_or_default();
    let line = before.rfind('\n').map_or(0, |end| end + 1);
    let between = before.get(line..).unwrap_or_default();
    // The words that begin the declaration of a codel.
    let begins =
        between.split_whitespace().all(|word| matches!(word, "async" | "validate" | "codel"));
    // A line that a backslash joins to the previous line is not a line of its own.
    let joined =
        before.get(..line).is_some_and(|text| text.trim_end_matches(['\n', '\r']).ends_with('\\'));
    let (at, new_text) = if begins && !joined {
        (line, pragma)
    } else if text.is_empty() || text.ends_with('\n') {
        (text.len(), pragma)
    } else {
        (text.len(), format!("{end}{pragma}"))
    };
    FileEdit { path: usage.path.clone(), range: at..at, new_text }
}

/// Returns the edits for a scenario: `duration PATH [0,N] us;` for each codel. A present statement for the
/// codel is replaced.
pub fn scenario(
    path: &Utf8Path,
    text: &str,
    scenario: &Scenario,
    times: &[(String, u64)],
) -> Vec<FileEdit> {
    let edit = |range, new_text| FileEdit { path: path.to_owned(), range, new_text };
    let statement_end = |from: usize| {
        let rest = text.get(from..).unwrap_or_default();
        rest.find(';').map(|rest| from + rest)
    };
    let mut edits = Vec::new();
    let mut fresh = Vec::new();
    for (codel, micros) in times {
        let known = scenario.items.iter().find_map(|item| match item {
            Item::Duration(path, interval, unit) if path.text() == *codel => {
                Some((path.range().end, interval.lower, unit))
            }
            _ => None,
        });
        match known.and_then(|(from, lower, unit)| Some((from, statement_end(from)?, lower, unit)))
        {
            // Replacing this statement would lose a comment in it, or the text after its first semicolon.
            Some((from, end, ..)) if has_comment(text.get(from..end).unwrap_or_default()) => {}
            Some((from, end, lower, unit)) => {
                let unit = unit.seconds();
                let lower = unit * num_rational::Ratio::from_integer(i128::from(lower) * 1_000_000);
                // Rounded down: a smaller least time only adds runs.
                let lower = u64::try_from(lower.to_integer()).unwrap_or(0).min(*micros);
                edits.push(edit(from..end, format!(" [{lower},{micros}] us")));
            }
            None => fresh.push(format!("duration {codel} [0,{micros}] us;")),
        }
    }
    let last = scenario.items.iter().filter_map(|item| match item {
        Item::Use(file) => Some(file.range.end),
        Item::Duration(path, ..) => Some(path.range().end),
        _ => None,
    });
    let last = last.max().and_then(statement_end).map(|statement_end| statement_end + 1);
    // A comment behind a statement belongs to the statement.
    let last = last.map(|at| {
        let rest = text.get(at..).unwrap_or_default();
        let line = rest.lines().next().unwrap_or_default();
        let comment = line.trim_start();
        let ends = comment.is_empty() || comment.starts_with("//");
        if ends { at + line.len() } else { at }
    });
    if let (Some(at), false) = (last, fresh.is_empty()) {
        let before = text.get(..at).unwrap_or_default();
        let line = before.rfind('\n').map_or(0, |end| end + 1);
        let line = before.get(line..).unwrap_or_default();
        let blanks: String =
            line.chars().take_while(|character| matches!(character, ' ' | '\t')).collect();
        let end = LineEnd::of(text).as_str();
        let lines = fresh.iter().map(|text| format!("{end}{blanks}{text}"));
        edits.push(edit(at..at, lines.collect()));
    }
    edits.sort_by_key(|edit| edit.range.start);
    edits
}

/// Applies edits to a text. The edits must be in order and must not overlap.
pub fn apply_edits<'e>(text: &str, edits: impl IntoIterator<Item = &'e FileEdit>) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        out.push_str(text.get(at..edit.range.start).unwrap_or_default());
        out.push_str(&edit.new_text);
        at = edit.range.end;
    }
    out.push_str(text.get(at..).unwrap_or_default());
    out
}
