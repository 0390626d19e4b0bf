//! `cargo xtask prose`: patterns of English that readers stumble over, in what users read.
//!
//! A list of patterns, not a judgement of style. Code is left out.

use std::path::Path;

use anyhow::{Context, Result};

/// Words that are not written, with what is written instead.
const PATTERNS: [(&str, &str); 15] = [
    ("nobody", "name the thing that does not"),
    ("somebody", "name the person or program"),
    ("whoever", "name the person or program"),
    ("beside", "next to, with"),
    ("is told", "the command prints, the check reports"),
    ("are told", "the command prints, the check reports"),
    ("that very", "the same"),
    ("are looked at", "is checked"),
    ("is looked at", "is checked"),
    ("brings", "provides, supplies"),
    ("is given back", "is freed"),
    ("are given back", "are freed"),
    ("is no X", "is not an X"),
    ("are no X", "are not X"),
    ("who includes", "files that include"),
];

/// Folders and files with text for users.
const TEXTS: [&str; 8] = [
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "docs",
    "examples",
    "vscode-extension/README.md",
    "vscode-extension/media/walkthrough",
    "cli/src/snapshots",
];

/// Definitions of the language, in the words of their own.
const DEFINITIONS: [&str; 3] = ["docs/language.md", "docs/timed-semantics.md", "docs/checks.md"];

/// Prints every place with a pattern. Returns true if there is none.
pub(crate) fn prose() -> Result<bool> {
    let found = places(xtask::root())?;
    for place in &found {
        println!("{place}");
    }
    println!("{} places", found.len());
    Ok(found.is_empty())
}

/// The places with a pattern, with the words to write instead.
fn places(root: &Path) -> Result<Vec<String>> {
    let mut files = Vec::new();
    let mut folders: Vec<_> = TEXTS.iter().map(|text| root.join(text)).collect();
    while let Some(path) = folders.pop() {
        if path.is_dir() {
            for entry in std::fs::read_dir(&path)? {
                folders.push(entry?.path());
            }
        } else if matches!(
            path.extension().and_then(|extension| extension.to_str()),
            Some("md" | "snap")
        ) {
            files.push(path);
        }
    }
    files.sort();
    let mut found = Vec::new();
    for path in files {
        let name = path.strip_prefix(root)?.to_string_lossy().replace('\\', "/");
        if DEFINITIONS.contains(&name.as_str()) {
            continue;
        }
        let text = std::fs::read_to_string(&path).with_context(|| name.clone())?;
        for (line, pattern, better) in patterns(&text) {
            found.push(format!("{name}:{line}: `{pattern}`: {better}"));
        }
    }
    Ok(found)
}

/// The patterns in a text, with the lines, outside of code.
fn patterns(text: &str) -> Vec<(usize, &'static str, &'static str)> {
    let mut found = Vec::new();
    let mut in_code = false;
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim_start().starts_with("```") {
            in_code = !in_code;
            continue;
        }
        if in_code {
            continue;
        }
        // Every second part is between back-quotes.
        let prose: Vec<&str> = line.split('`').step_by(2).collect();
        let prose = prose.join("X").to_lowercase();
        let words: Vec<&str> =
            prose.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect();
        for (pattern, better) in PATTERNS {
            if occurs(&words, pattern) {
                found.push((number, pattern, better));
            }
        }
    }
    found
}

/// Returns true if the words of a pattern follow each other; `X` stands for any noun.
fn occurs(words: &[&str], pattern: &str) -> bool {
    let pattern: Vec<&str> = pattern.split(' ').collect();
    words.windows(pattern.len()).enumerate().any(|(at, window)| {
        let matches = std::iter::zip(&pattern, window).all(|(wanted, word)| match *wanted {
            "X" => !["longer", "more"].contains(word),
            _ => wanted == word,
        });
        // "There is no X" is English; "there" may be on the line before.
        let needs_subject = pattern.contains(&"X");
        matches && (!needs_subject || at > 0 && words[at - 1] != "there")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_found_outside_of_code() {
        for text in
            ["Nobody is sought.", "the answer is no proof", "a task beside it", "is looked at"]
        {
            assert_eq!(patterns(text).len(), 1, "{text}");
        }
        for text in [
            "There is no answer.",
            "it is no longer used",
            "`nobody` is a codel",
            "```\\nnobody\\n```",
            "besides",
        ] {
            let text = text.replace("\\n", "\n");
            assert_eq!(patterns(&text), [], "{text}");
        }
    }

    #[test]
    fn what_users_read_has_none() {
        let found = places(xtask::root()).expect("the texts can be read");
        assert!(found.is_empty(), "{found:#?}");
    }
}
