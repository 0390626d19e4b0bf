//! Compares findings before and after an edit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

/// A finding of a document.
#[derive(Clone, Debug)]
pub(super) struct Finding {
    pub(super) code: String,
    /// Severity of the protocol: 1 is an error, 4 a hint.
    pub(super) severity: u64,
    /// First and last line, from 0.
    pub(super) lines: [usize; 2],
    pub(super) message: String,
    /// The finding in the form of the protocol, for the context of a request.
    pub(super) raw: Value,
}

impl Finding {
    /// Reads a diagnostic of the protocol, or one in the JSON output of the command line.
    pub(super) fn read(raw: &Value) -> Finding {
        let line = |end: &str| raw["range"][end]["line"].as_u64().unwrap_or(0) as usize;
        let severity = match raw["severity"].as_str() {
            Some("error") => 1,
            Some("warning") => 2,
            Some("hint") => 4,
            Some(_) => 3,
            None => raw["severity"].as_u64().unwrap_or(1),
        };
        Finding {
            code: raw["code"].as_str().unwrap_or("none").to_owned(),
            severity,
            lines: [line("start"), line("end")],
            message: raw["message"].as_str().unwrap_or_default().to_owned(),
            raw: raw.clone(),
        }
    }
}

/// Findings by document.
#[derive(Clone, Default)]
pub(super) struct Findings(pub(super) BTreeMap<PathBuf, Vec<Finding>>);

/// Documents' changed lines, in the texts after an edit.
pub(super) type ChangedLines = BTreeMap<PathBuf, Vec<[usize; 2]>>;

/// A finding and its document.
type Placed<'a> = (&'a Path, &'a Finding);

impl Findings {
    /// Number of findings of a code.
    pub(super) fn count(&self, code: &str) -> usize {
        let all = self.0.values().flatten();
        all.filter(|finding| finding.code == code).count()
    }

    /// Number of errors.
    pub(super) fn errors(&self) -> usize {
        self.0.values().flatten().filter(|finding| finding.severity == 1).count()
    }

    /// Findings with codes that are more frequent in a document afterwards.
    fn added<'a>(&self, after: &'a Findings) -> Vec<Placed<'a>> {
        let mut out = Vec::new();
        for (path, findings) in &after.0 {
            let old = self.0.get(path).map(Vec::as_slice).unwrap_or_default();
            let number = |of: &[Finding], code: &str| {
                of.iter().filter(|finding| finding.code == code).count()
            };
            let mut seen: Vec<&str> = Vec::new();
            for finding in findings {
                let more = number(findings, &finding.code) > number(old, &finding.code);
                if more && !seen.contains(&finding.code.as_str()) {
                    seen.push(&finding.code);
                    // Preferred: a finding whose message is new.
                    let is_new =
                        |finding: &&Finding| !old.iter().any(|o| o.message == finding.message);
                    let mut same = findings.iter().filter(|f| f.code == finding.code);
                    let telling = same.find(is_new).unwrap_or(finding);
                    out.push((path.as_path(), telling));
                }
            }
        }
        out
    }

    /// The findings that an edit adds: those that make it worse, and those that a fixed error had hidden.
    ///
    /// A new finding was hidden if there are fewer errors than before, and it is away from the changed lines
    /// or no more than an information.
    pub(super) fn judged<'a>(
        &self,
        after: &'a Findings,
        touched: &ChangedLines,
    ) -> (Vec<Placed<'a>>, Vec<Placed<'a>>) {
        let reveals = after.errors() < self.errors();
        let is_touched = |path: &Path, finding: &Finding| {
            let mut lines = touched.get(path).into_iter().flatten();
            lines.any(|at| at[0] <= finding.lines[1] && finding.lines[0] <= at[1])
        };
        let added = self.added(after).into_iter();
        added.partition(|(path, finding)| {
            !reveals || finding.severity <= 2 && is_touched(path, finding)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(all: &[(&str, u64, usize)]) -> Findings {
        let found = all.iter().map(|&(code, severity, line)| Finding {
            code: code.to_owned(),
            severity,
            lines: [line, line],
            message: format!("{code} {line}"),
            raw: Value::Null,
        });
        Findings(BTreeMap::from([("a.gen".into(), found.collect())]))
    }

    #[test]
    fn new_findings_are_worse_unless_a_mended_error_had_hidden_them() {
        let touched = ChangedLines::from([("a.gen".into(), vec![[3, 3]])]);
        let before = findings(&[("e", 1, 3), ("w", 2, 9)]);
        let kinds = |after: &[(&str, u64, usize)]| {
            let after = findings(after);
            let (worse, revealed) = before.judged(&after, &touched);
            (worse.len(), revealed.len())
        };
        assert_eq!(kinds(&[("w", 2, 9)]), (0, 0));
        assert_eq!(kinds(&[("e", 1, 3), ("w", 2, 9), ("w", 2, 12)]), (1, 0));
        assert_eq!(kinds(&[("w", 2, 9), ("x", 2, 12)]), (0, 1));
        assert_eq!(kinds(&[("w", 2, 9), ("x", 2, 3)]), (1, 0));
        assert_eq!(kinds(&[("f", 1, 3), ("w", 2, 9)]), (1, 0));
    }
}
