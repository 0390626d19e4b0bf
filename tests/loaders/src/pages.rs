//! The pages of diagnostics in `docs/diagnostics`, which are the source of their texts and examples.

use std::path::{Path, PathBuf};

/// The page of a code.
pub struct Page {
    /// The meaning, in one sentence.
    pub meaning: String,
    /// The line about the default severity.
    pub default: String,
    pub examples: Vec<Example>,
    pub why: String,
    /// Advice, and what `dotgen.toml` and comments can do about the code.
    pub rest: String,
}

/// A text in a fence.
pub struct Example {
    pub language: String,
    /// Ends with a line end.
    pub text: String,
    /// It is below the word `Corrected:`.
    pub corrected: bool,
}

/// The folder of the pages.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics")
}

impl Page {
    /// Reads the page of a code.
    ///
    /// # Errors
    /// Returns the part of the page that is missing.
    pub fn read(code: &str) -> Result<Page, String> {
        let path = folder().join(code).with_extension("md");
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|error| format!("{code}: no page: {error}"))?;
        Page::parse(code, &text).ok_or_else(|| format!("{code}: the page is not in the usual form"))
    }

    fn parse(code: &str, text: &str) -> Option<Page> {
        let text = text.strip_prefix(&format!("# {code}\n\n"))?;
        let (meaning, text) = text.split_once("\n\n")?;
        let (default, text) = text.split_once("\n\n## Example\n")?;
        let (examples, text) = text.split_once("\n## Why it matters\n\n")?;
        let (why, rest) = text.split_once("\n\n## What to do\n\n")?;
        Some(Page {
            meaning: meaning.to_owned(),
            default: default.to_owned(),
            examples: fences(examples),
            why: why.to_owned(),
            rest: rest.to_owned(),
        })
    }

    /// The texts of a language, faulty or corrected.
    pub fn texts(&self, language: &str, corrected: bool) -> Vec<&str> {
        let all = self.examples.iter();
        let all = all.filter(|text| text.language == language && text.corrected == corrected);
        all.map(|text| text.text.as_str()).collect()
    }
}

fn fences(text: &str) -> Vec<Example> {
    let mut out = Vec::new();
    let mut corrected = false;
    let mut open: Option<Example> = None;
    for line in text.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (Some(_), Some(_)) => out.extend(open.take()),
            (Some(example), None) => example.text += &format!("{line}\n"),
            (None, Some(language)) => {
                let language = language.to_owned();
                open = Some(Example { language, text: String::new(), corrected });
            }
            (None, None) => corrected |= line == "Corrected:",
        }
    }
    out
}
