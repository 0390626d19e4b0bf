//! The built-in merge of a file edited by the user with the new output of a template.

use dotgen_syntax::encoding::LineEnd;

/// The resolution of a conflict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// The new lines.
    New,
    /// The old lines.
    Old,
    /// Both, between conflict markers.
    Markers,
    /// Leave the whole file as it is.
    Leave,
}

/// Old and new lines that differ at the same place.
#[derive(Debug)]
pub struct Conflict<'a> {
    /// Up to three lines before the conflict, from the old file.
    pub before: &'a [String],
    /// Lines only in the old file.
    pub old: &'a [String],
    /// Lines only in the new file.
    pub new: &'a [String],
    /// Up to three lines after the conflict, from the old file.
    pub after: &'a [String],
    /// Index of the first old line.
    pub line: usize,
}

impl Conflict<'_> {
    /// The conflict as a hunk of a unified patch, without its final newline.
    pub fn hunk(&self) -> String {
        let context = self.before.len() + self.after.len();
        format!(
            "@@ -{line},{} +{line},{} @@\n {}\n-{}\n+{}\n {}",
            context + self.old.len(),
            context + self.new.len(),
            self.before.join("\n "),
            self.old.join("\n-"),
            self.new.join("\n+"),
            self.after.join("\n "),
            line = self.line,
        )
    }
}

/// A merged text.
#[derive(Debug, PartialEq, Eq)]
pub struct Merged {
    /// The text; `None` if the user left the file unchanged.
    pub text: Option<String>,
    /// Number of conflicts left in it between markers.
    pub conflicts: usize,
}

/// Merges the text of a template into an existing one. Lines in both are kept; between them, new lines are
/// added and old lines are kept. If both sides differ, `settle` decides. Lines of sample code are ignored.
pub fn merge(new: &str, old: &str, settle: &mut dyn FnMut(&Conflict<'_>) -> Choice) -> Merged {
    let unfinished = !old.is_empty() && !old.ends_with('\n');
    let line_end = LineEnd::of(old);
    let new = lines(&line_end.fit(new));
    let mut old = lines(old);
    if unfinished && let Some(last) = old.last_mut() {
        last.push_str(line_end.as_str().trim_end_matches('\n'));
    }
    let mut out = Output { line_end, ..Output::default() };
    let (mut at_new, mut at_old) = (0, 0);
    for (next_new, next_old) in common_lines(&bare(&new), &bare(&old)) {
        let only_new = &new[at_new.min(next_new)..next_new];
        let only_old = &old[at_old.min(next_old)..next_old];
        match (counts(only_new), counts(only_old)) {
            (true, true) => {
                let conflict = Conflict {
                    before: &old[at_old.saturating_sub(3)..at_old.min(old.len())],
                    old: only_old,
                    new: only_new,
                    after: &old[next_old..(next_old + 3).min(old.len())],
                    line: next_old - only_old.len(),
                };
                match settle(&conflict) {
                    Choice::New => out.push(only_new),
                    Choice::Old => out.push(only_old),
                    Choice::Markers => {
                        out.marker("<<<<<<< user version");
                        out.push(only_old);
                        out.marker("=======");
                        out.push(only_new);
                        out.marker(">>>>>>> template version");
                        out.conflicts += 1;
                    }
                    Choice::Leave => {
                        return Merged { text: None, conflicts: out.conflicts };
                    }
                }
            }
            (true, false) => out.push(only_new),
            (false, _) if !only_old.is_empty() => out.push(only_old),
            _ => {}
        }
        if let Some(line) = old.get(next_old) {
            out.line(line);
        }
        at_new = next_new + 1;
        at_old = next_old + 1;
    }
    // If the last line of the old file has no line end, the result has none either.
    let ends_so = |last: &String| {
        let text = out.text.strip_suffix('\n');
        text.is_some_and(|text| text.ends_with(last))
    };
    if unfinished && old.last().is_some_and(ends_so) {
        out.text.truncate(out.text.len() - line_end.as_str().len());
    }
    Merged { text: Some(out.text), conflicts: out.conflicts }
}

#[derive(Default)]
struct Output {
    text: String,
    line_end: LineEnd,
    conflicts: usize,
}

impl Output {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn marker(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push_str(self.line_end.as_str());
    }

    fn push(&mut self, lines: &[String]) {
        self.line(&lines.join("\n"));
    }
}

fn lines(text: &str) -> Vec<String> {
    let text = text.strip_suffix('\n').unwrap_or(text);
    if text.is_empty() {
        return Vec::new();
    }
    text.split('\n').map(str::to_owned).collect()
}

/// The lines without their remaining `\r`: it does not make lines differ.
fn bare(lines: &[String]) -> Vec<&str> {
    lines.iter().map(|line| line.strip_suffix('\r').unwrap_or(line)).collect()
}

fn counts(block: &[String]) -> bool {
    block.iter().any(|line| !line.trim().is_empty() && !line.contains("skeleton sample"))
}

/// A common subsequence: its last pair and the candidate before it.
#[derive(Clone, Copy)]
struct Candidate {
    new: usize,
    old: usize,
    before: Option<usize>,
}

/// Pairs of indexes of equal lines, growing on both sides, ending with the two lengths: a longest common
/// subsequence by the method of Hunt and McIlroy ("An algorithm for differential file comparison", Bell
/// Laboratories, 1976). Blank lines never match.
fn common_lines(new: &[&str], old: &[&str]) -> Vec<(usize, usize)> {
    let mut places: rustc_hash::FxHashMap<&str, Vec<usize>> = rustc_hash::FxHashMap::default();
    for (index, line) in old.iter().copied().enumerate() {
        if !line.trim().is_empty() {
            places.entry(line).or_default().push(index);
        }
    }
    let mut candidates: Vec<Candidate> = Vec::new();
    // best[n] is the candidate of length n + 1 that ends earliest in the old file.
    let mut best: Vec<usize> = Vec::new();
    for (at_new, line) in new.iter().enumerate() {
        let Some(matches) = places.get(line) else {
            continue;
        };
        // A candidate found for this line is stored only after the next search, so that no candidate uses the
        // line twice.
        let mut pending: Option<(usize, usize)> = None;
        let mut least = 0;
        for &at_old in matches {
            // Not past the entry that the pending candidate will replace: nothing longer ends here.
            if least > 0 && candidates[best[least - 1]].old >= at_old {
                continue;
            }
            let length = least
                + best[least..].partition_point(|candidate| candidates[*candidate].old < at_old);
            if best.get(length).is_some_and(|candidate| candidates[*candidate].old == at_old) {
                continue;
            }
            let before = match length {
                0 => None,
                _ => Some(best[length - 1]),
            };
            candidates.push(Candidate { new: at_new, old: at_old, before });
            if let Some((place, candidate)) = pending.take() {
                put(&mut best, place, candidate);
            }
            pending = Some((length, candidates.len() - 1));
            least = length + 1;
            if length >= best.len() {
                break;
            }
        }
        if let Some((place, candidate)) = pending {
            put(&mut best, place, candidate);
        }
    }
    let mut pairs = vec![(new.len(), old.len())];
    let mut at = best.last().copied();
    while let Some(index) = at {
        let candidate = candidates[index];
        pairs.push((candidate.new, candidate.old));
        at = candidate.before;
    }
    pairs.reverse();
    pairs
}

fn put(best: &mut Vec<usize>, place: usize, candidate: usize) {
    match best.get_mut(place) {
        Some(slot) => *slot = candidate,
        None => best.push(candidate),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn auto(new: &str, old: &str) -> String {
        let merged = merge(new, old, &mut |_| Choice::Markers);
        merged.text.unwrap_or_default()
    }

    #[test]
    fn both_sides_are_kept() {
        assert_eq!(auto("a\nnew\nb\n", "a\nb\nmine\n"), "a\nnew\nb\nmine\n");
        assert_eq!(auto("a\nb\n", "a\nb\n"), "a\nb\n");
        assert_eq!(auto("", "a\n"), "a\n");
        assert_eq!(auto("a\n", ""), "a\n");
    }

    #[test]
    fn bytes_and_line_ends_of_the_file_stay() {
        assert_eq!(auto("a\nnew\nb\n", "a\r\nb\r\nmine\r\n"), "a\r\nnew\r\nb\r\nmine\r\n");
        assert_eq!(auto("a\nb\n", "a\r\nb\nc\r\nd\r\n"), "a\r\nb\nc\r\nd\r\n");
        assert_eq!(
            auto("a\nnew\nb\n", "a\r\nold\r\nb"),
            "a\r\n<<<<<<< user version\r\nold\r\n=======\r\nnew\r\n>>>>>>> template version\r\nb"
        );
        assert_eq!(auto("a\nb\nc\n", "a\nb"), "a\nb\nc\n");
    }

    #[test]
    fn conflicts_are_marked() {
        assert_eq!(
            auto("a\nnew\nb\n", "a\nold\nb\n"),
            "a\n<<<<<<< user version\nold\n=======\nnew\n>>>>>>> template version\nb\n"
        );
    }

    #[test]
    fn sample_code_and_blank_lines_count_for_nothing() {
        assert_eq!(auto("a\n /* skeleton sample */\nb\n", "a\nmine\nb\n"), "a\nmine\nb\n");
        assert_eq!(auto("a\nnew\nb\n", "a\n /* skeleton sample */\nb\n"), "a\nnew\nb\n");
        assert_eq!(auto("a\n\nb\n", "a\nb\n"), "a\nb\n");
    }

    #[test]
    fn leaving_a_file_gives_no_text() {
        let merged = merge("x\n", "y\n", &mut |_| Choice::Leave);
        assert_eq!(merged.text, None);
    }

    #[test]
    fn hunks_show_both_sides() {
        let mut shown = String::new();
        merge("a\nnew\nb\n", "0\na\nold\nb\n", &mut |conflict| {
            shown = conflict.hunk();
            Choice::Old
        });
        assert_eq!(shown, "@@ -2,4 +2,4 @@\n 0\n a\n-old\n+new\n b");
    }

    #[test]
    fn a_longest_common_subsequence_is_found() {
        let split = |text: &'static str| -> Vec<&str> {
            text.split("").filter(|part| !part.is_empty()).collect()
        };
        let (new, old) = (split("abcabba"), split("cbabac"));
        let pairs = common_lines(&new, &old);
        assert_eq!(pairs.len(), 5, "four common lines and the end");
        for pair in pairs.windows(2) {
            assert!(pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1);
        }
        for (n, o) in &pairs[..pairs.len() - 1] {
            assert_eq!(new[*n], old[*o]);
        }
    }
}
