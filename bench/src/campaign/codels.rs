//! The campaign over codels: a compiler judges findings and repairs.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use super::Options;
use super::compare::Finding;
use super::mutate::mutate;
use super::report::Report;
use super::sets::{Set, is_specification};

/// The code that a compiler can confirm.
const CONFIRMABLE_CODE: &str = "codel/signature-mismatch";

/// Folder of the generated headers; the comparison of codels does not read it.
const HEADERS: &str = ".campaign";

/// One specification with its sources, in a copy.
struct Folder<'f> {
    dotgen: &'f Path,
    root: &'f Path,
    specification: PathBuf,
    sources: Vec<PathBuf>,
}

/// Measures a set.
pub(super) fn codels(
    options: &Options,
    dotgen: &Path,
    set: &Set,
    report: &mut Report,
) -> Result<()> {
    let copy = set.copy()?;
    let documents = set.documents(&copy.root);
    for specification in documents.iter().filter(|document| is_specification(document)) {
        let below = specification.with_file_name("codels");
        let is_source = |path: &&PathBuf| {
            let extension = path.extension().and_then(|extension| extension.to_str());
            path.starts_with(&below) && matches!(extension, Some("c" | "cc" | "cpp" | "cxx"))
        };
        let is_bare = !documents.iter().any(|document| is_source(&document));
        if is_bare {
            stubs(dotgen, &copy.root, specification)?;
            report.count("as published", "folders of stubs", 1);
        }
        let documents = set.documents(&copy.root);
        let folder = Folder {
            dotgen,
            root: &copy.root,
            specification: specification.clone(),
            sources: documents.iter().filter(is_source).cloned().collect(),
        };
        if folder.sources.is_empty() {
            continue;
        }
        folder.measure(report, "as published", "")?;
        for number in 0..options.mutations * 2 {
            let seed = options.seed.wrapping_mul(1000).wrapping_add(number as u64);
            let mut random = fastrand::Rng::with_seed(seed);
            // Specification and sources in turn.
            let path = match number % 2 {
                0 => specification,
                _ => &folder.sources[random.usize(..folder.sources.len())],
            };
            let original = std::fs::read(path)?;
            let Ok(text) = std::str::from_utf8(&original) else {
                continue;
            };
            let Some((new, what)) = mutate(text, &mut random) else {
                continue;
            };
            std::fs::write(path, new)?;
            let shown = folder.shown(path);
            let result = folder.measure(report, "mutated", &format!(" [mutation: {shown} {what}]"));
            std::fs::write(path, &original)?;
            result?;
        }
    }
    Ok(())
}

/// Writes stubs for a specification without sources.
fn stubs(dotgen: &Path, root: &Path, specification: &Path) -> Result<()> {
    let mut command = Command::new(dotgen);
    command.args(["codels", "stub"]).arg(specification).current_dir(root);
    command.output().context("cannot run dotgen codels stub")?;
    Ok(())
}

impl Folder<'_> {
    /// Compares findings with the compiler, then repairs and compiles again; the texts are restored.
    fn measure(&self, report: &mut Report, group: &str, context: &str) -> Result<()> {
        let before: Vec<_> = self.compiled();
        let compiling = before.iter().filter(|(compiles, _)| *compiles).count();
        report.count(group, "sources", self.sources.len());
        report.count(group, "sources that compile", compiling);
        self.judge(report, group, context, &before)?;
        if compiling == 0 {
            return Ok(());
        }
        let files: Vec<&PathBuf> = self.sources.iter().chain([&self.specification]).collect();
        let originals = files.iter().map(|file| Ok((*file, std::fs::read(file)?)));
        let originals = originals.collect::<Result<Vec<_>>>()?;
        self.run(&["codels", "sync"])?;
        let is_changed =
            originals.iter().any(|(path, old)| std::fs::read(path).ok().as_ref() != Some(old));
        let after = is_changed.then(|| self.compiled());
        for (path, old) in originals {
            std::fs::write(path, old)?;
        }
        let Some(after) = after else { return Ok(()) };
        for ((source, before), after) in self.sources.iter().zip(&before).zip(&after) {
            if !before.0 {
                continue;
            }
            report.count(group, "judged", 1);
            report.count(group, "compile after sync", usize::from(after.0));
            if !after.0 {
                let error = after.1.lines().find(|line| line.contains("error")).unwrap_or_default();
                let error = error.replace(&format!("{}/", self.root.display()), "");
                let shown = self.shown(source);
                report.code("no longer compiles", "codels sync");
                report.report_offender(
                    "no longer compiles",
                    &format!("{shown}: `codels sync`{context}: {error}"),
                );
            }
        }
        Ok(())
    }

    /// Compares findings with the messages of the compiler.
    fn judge(
        &self,
        report: &mut Report,
        group: &str,
        context: &str,
        compiled: &[(bool, String)],
    ) -> Result<()> {
        let output = self.run(&["codels", "check", "--format", "json"])?;
        let found: Value = serde_json::from_str(&output.0).with_context(|| output.1.clone())?;
        for diagnostic in found["diagnostics"].as_array().into_iter().flatten() {
            let finding = Finding::read(diagnostic);
            if finding.code != CONFIRMABLE_CODE || finding.severity > 2 {
                continue;
            }
            let file = self.root.join(diagnostic["file"].as_str().unwrap_or_default());
            let Some(at) = self.sources.iter().position(|source| *source == file) else {
                continue;
            };
            let (compiles, messages) = &compiled[at];
            let complains =
                messages.lines().any(|line| line.contains("error:") || line.contains("warning:"));
            report.count(group, "judged", 1);
            match (compiles, complains) {
                (true, false) => {
                    let line = finding.lines[0] + 1;
                    let shown = self.shown(&file);
                    report.count(group, "contradicted", 1);
                    report.code("contradicted", &finding.code);
                    let text =
                        format!("{shown}:{line}: {}: {}{context}", finding.code, finding.message);
                    report.report_offender("contradicted", &text);
                }
                (true, true) => report.count(group, "confirmed by a warning", 1),
                (false, _) if messages.contains("fatal error:") => {
                    report.count(group, "not judged: a header is missing", 1);
                }
                (false, _) => report.count(group, "confirmed by an error", 1),
            }
        }
        Ok(())
    }

    /// Generates headers and compiles each source: the result and the messages.
    fn compiled(&self) -> Vec<(bool, String)> {
        let headers = self.root.join(HEADERS);
        std::fs::remove_dir_all(&headers).ok();
        let generated = Command::new(self.dotgen)
            .args(["codels", "headers", "-o"])
            .arg(&headers)
            .arg(&self.specification)
            .current_dir(self.root)
            .output();
        let fine = generated.is_ok_and(|output| output.status.success());
        let flags = std::fs::read_to_string(headers.join("compile_flags.txt")).unwrap_or_default();
        let compile = |source: &PathBuf| {
            if !fine {
                return (false, "fatal error: no headers".to_owned());
            }
            let is_c = source.extension().is_some_and(|extension| extension == "c");
            let output = Command::new(if is_c { "gcc" } else { "g++" })
                .args(["-Wall", "-fsyntax-only"])
                .args(flags.lines())
                .arg(source)
                .current_dir(self.root)
                .output();
            match output {
                Ok(output) => {
                    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
                }
                Err(error) => (false, format!("fatal error: {error}")),
            }
        };
        let out = self.sources.iter().map(compile).collect();
        std::fs::remove_dir_all(&headers).ok();
        out
    }

    /// Runs dotgen on the specification: standard output and standard error.
    fn run(&self, arguments: &[&str]) -> Result<(String, String)> {
        let mut command = Command::new(self.dotgen);
        command.args(arguments).arg(&self.specification).current_dir(self.root);
        let output = command.output()?;
        let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
        Ok((text(&output.stdout), text(&output.stderr)))
    }

    fn shown(&self, path: &Path) -> String {
        path.strip_prefix(self.root).unwrap_or(path).display().to_string()
    }
}
