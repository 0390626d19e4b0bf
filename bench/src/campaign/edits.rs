//! Workspace edits, applied to texts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use super::compare::{ChangedLines, Finding};

/// Words of the comments above codels, which repairs rewrite.
const SKELETON: [&str; 3] = ["Yields to", "Triggered by", "Throws"];

/// One replacement: bytes and lines in the old text, and the new text.
struct Hunk {
    bytes: std::ops::Range<usize>,
    lines: [usize; 2],
    new: String,
}

/// The effect of an edit.
#[derive(Default)]
pub(super) struct Applied {
    /// New texts by file.
    pub(super) texts: BTreeMap<PathBuf, String>,
    /// Changed lines in the new texts.
    pub(super) touched: ChangedLines,
    /// Words that are removed away from findings, and appear nowhere else in the edit.
    pub(super) lost: Vec<String>,
}

/// Applies an edit of the protocol to texts. `text` returns the text of a file; a missing file is empty.
pub(super) fn apply(
    edit: &Value,
    text: impl Fn(&Path) -> Option<String>,
    about: &[(PathBuf, [usize; 2])],
) -> Result<Applied> {
    let mut out = Applied::default();
    let mut words = BTreeMap::<String, isize>::new();
    let mut away = Vec::new();
    for (path, edits) in by_file(edit)? {
        let old = text(&path);
        if old.is_none() && path.exists() {
            bail!("{} is not UTF-8", path.display());
        }
        let old = old.unwrap_or_default();
        let mut hunks = edits.iter().map(|edit| hunk(&old, edit)).collect::<Result<Vec<_>>>()?;
        hunks.sort_by_key(|hunk| (hunk.bytes.start, hunk.bytes.end));
        let mut new = String::new();
        let mut at = 0;
        for hunk in &hunks {
            if hunk.bytes.start < at {
                bail!("edits of {} overlap", path.display());
            }
            new.push_str(&old[at..hunk.bytes.start]);
            let first = new.matches('\n').count();
            new.push_str(&hunk.new);
            let last = new.matches('\n').count();
            out.touched.entry(path.clone()).or_default().push([first, last]);
            at = hunk.bytes.end;
            let removed = &old[hunk.bytes.clone()];
            words_of(removed).for_each(|word| *words.entry(word.to_owned()).or_default() += 1);
            words_of(&hunk.new).for_each(|word| *words.entry(word.to_owned()).or_default() -= 1);
            let line = old.lines().nth(hunk.lines[0]).unwrap_or_default();
            let is_comment = SKELETON.iter().any(|word| line.contains(word));
            let near = is_comment
                || about.iter().any(|(of, lines)| {
                    of == &path && lines[0] <= hunk.lines[1] + 1 && hunk.lines[0] <= lines[1] + 1
                });
            if !near && words_of(removed).count() > words_of(&hunk.new).count() {
                away.extend(words_of(removed).map(str::to_owned));
            }
        }
        new.push_str(&old[at..]);
        out.texts.insert(path, new);
    }
    if words.values().sum::<isize>() > 0 {
        away.retain(|text| words.get(text).is_some_and(|word| *word > 0));
        out.lost = away;
    }
    Ok(out)
}

/// The places that a finding names, with its related places.
pub(super) fn places(path: &Path, finding: &Finding) -> Vec<(PathBuf, [usize; 2])> {
    let mut out = vec![(path.to_owned(), finding.lines)];
    let related = finding.raw["relatedInformation"].as_array();
    for related in related.into_iter().flatten() {
        let line =
            |end: &str| related["location"]["range"][end]["line"].as_u64().unwrap_or(0) as usize;
        let uri = related["location"]["uri"].as_str().unwrap_or_default();
        out.push((path_of(uri), [line("start"), line("end")]));
    }
    out
}

/// Edits of text by file; files that the edit creates have an entry.
fn by_file(edit: &Value) -> Result<BTreeMap<PathBuf, Vec<Value>>> {
    let mut out = BTreeMap::<PathBuf, Vec<Value>>::new();
    let uri = |value: &Value| value.as_str().map(path_of).context("no URI");
    for change in edit["documentChanges"].as_array().into_iter().flatten() {
        match change["kind"].as_str() {
            Some("create") => _ = out.entry(uri(&change["uri"])?).or_default(),
            Some(other) => bail!("an edit does `{other}`"),
            None => {
                let edits = change["edits"].as_array().cloned().unwrap_or_default();
                out.entry(uri(&change["textDocument"]["uri"])?).or_default().extend(edits);
            }
        }
    }
    for (name, edits) in edit["changes"].as_object().into_iter().flatten() {
        let edits = edits.as_array().cloned().unwrap_or_default();
        out.entry(path_of(name)).or_default().extend(edits);
    }
    Ok(out)
}

pub(super) fn path_of(uri: &str) -> PathBuf {
    let path = uri.strip_prefix("file://").unwrap_or(uri);
    let mut parts = path.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2).unwrap_or_default();
        match u8::from_str_radix(digits, 16) {
            Ok(byte) => {
                bytes.push(byte);
                bytes.extend(&part.as_bytes()[2..]);
            }
            Err(_) => {
                bytes.push(b'%');
                bytes.extend(part.as_bytes());
            }
        }
    }
    PathBuf::from(String::from_utf8_lossy(&bytes).into_owned())
}

/// A replacement without the common beginning and end of both texts.
fn hunk(old: &str, edit: &Value) -> Result<Hunk> {
    let start = offset(old, &edit["range"]["start"])?;
    let end = offset(old, &edit["range"]["end"])?;
    let new = edit["newText"].as_str().context("no new text")?;
    let was = old.get(start..end).context("an edit is outside of its file")?;
    let mut head = std::iter::zip(was.bytes(), new.bytes()).take_while(|(a, b)| a == b).count();
    // Whole words: a part of a word does not count as a removed word.
    while !is_border(was, head) || !is_border(new, head) {
        head -= 1;
    }
    let (was_rest, new_rest) = (&was[head..], &new[head..]);
    let pairs = std::iter::zip(was_rest.bytes().rev(), new_rest.bytes().rev());
    let mut tail = pairs.take_while(|(a, b)| a == b).count();
    while !is_border(was_rest, was_rest.len() - tail) || !is_border(new_rest, new_rest.len() - tail)
    {
        tail -= 1;
    }
    let bytes = start + head..end - tail;
    let line = |at: usize| old[..at].matches('\n').count();
    Ok(Hunk {
        lines: [line(bytes.start), line(bytes.end)],
        new: new_rest[..new_rest.len() - tail].to_owned(),
        bytes,
    })
}

/// True if a word does not continue at a byte of a text.
fn is_border(text: &str, at: usize) -> bool {
    let is_word = |character: char| character.is_alphanumeric() || character == '_';
    text.is_char_boundary(at) && !(text[..at].ends_with(is_word) && text[at..].starts_with(is_word))
}

/// The byte of a position; characters are bytes.
fn offset(text: &str, position: &Value) -> Result<usize> {
    let line = position["line"].as_u64().context("no line")? as usize;
    let character = position["character"].as_u64().context("no character")? as usize;
    let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(end, _)| end + 1));
    let start = starts.clone().nth(line).unwrap_or(text.len());
    Ok((start + character).min(text.len()))
}

fn words_of(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|character: char| !character.is_alphanumeric() && character != '_');
    words.filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Words that an edit of the lines from one to another removes, for a finding in line 0.
    fn lost(lines: [usize; 2], new: &str) -> Vec<String> {
        let position = |line| json!({ "line": line, "character": 0 });
        let range = json!({ "start": position(lines[0]), "end": position(lines[1]) });
        let edit =
            json!({ "changes": { "file:///a%2B.gen": [{ "range": range, "newText": new }] } });
        let text = |_: &Path| Some("one\ntwo\nthree\nfour\nfive\n".to_owned());
        let about = [(PathBuf::from("/a+.gen"), [0, 0])];
        let applied = apply(&edit, text, &about).expect("the edit applies");
        applied.lost
    }

    #[test]
    fn words_away_from_a_finding_are_lost() {
        assert!(lost([0, 1], "").is_empty());
        assert!(lost([3, 4], "quattro\n").is_empty());
        assert_eq!(lost([3, 4], ""), ["four"]);
        assert_eq!(lost([3, 5], "five\n"), ["four"]);
    }
}
