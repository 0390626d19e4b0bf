//! `dotgen release`: releases of GenoM3, and their differences for specifications.

use std::io::Write;

use camino::Utf8PathBuf;
use clap::{Args, Subcommand, ValueEnum};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::release::Release;
use dotgen_codegen::release_diff::{self, ReleaseDiff, TextChange};
use serde::Serialize;
use serde_json::json;

use super::session;
use super::{Outcome, SpecificationOptions};

/// Compare releases of GenoM3
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    Diff(Diff),
}

/// Report differences between two releases: diagnostics, digests, types, prototypes and stubs
///
/// Exit status: 0 if nothing differs, 1 if something does, 2 if a file cannot be read.
#[derive(Debug, Args)]
struct Diff {
    /// Specifications, and directories to search for .gen files
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<Utf8PathBuf>,

    /// First release [default: the release the specifications are read as; if that is the second release, the
    /// oldest known one]
    #[arg(long, value_name = "RELEASE")]
    from: Option<Release>,

    /// Second release [default: the newest that dotgen is verified against]
    #[arg(long, value_name = "RELEASE")]
    to: Option<Release>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    Text,
    Json,
}

/// The differences for one specification.
#[derive(Debug, Serialize)]
struct FileDiff {
    file: String,
    from: Release,
    to: Release,
    checks: Vec<CheckChange>,
    #[serde(flatten)]
    generated: ReleaseDiff,
}

/// A diagnostic of one of the releases.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct CheckChange {
    only_in: Release,
    severity: &'static str,
    code: &'static str,
    file: String,
    /// From 1.
    line: usize,
    message: String,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let Action::Diff(diff) = &arguments.action;
    let mut reports = Vec::new();
    let (files, mut trouble) = session::specifications(&diff.paths);
    for file in files {
        reports.extend(trouble.ok_or_report(compare(diff, &file.path)));
    }
    let mut out = anstream::stdout().lock();
    match diff.format {
        Format::Json => writeln!(out, "{:#}", json!({ "version": 1, "specifications": reports }))?,
        Format::Text => reports.iter().try_for_each(|report| print(report, &mut out))?,
    }
    Ok(trouble.outcome(match reports.iter().all(FileDiff::is_empty) {
        true => Outcome::Fine,
        false => Outcome::Errors,
    }))
}

fn compare(diff: &Diff, path: &Utf8PathBuf) -> anyhow::Result<FileDiff> {
    let to = diff.to.unwrap_or_default();
    let from = match diff.from {
        Some(from) => from,
        None => {
            let session = session::single(path, &diff.reading)?;
            let used = session.ask(path, |analysis| analysis.release(path))?.release;
            if used == to { Release::OLDEST } else { used }
        }
    };
    let read = |release: Release| -> anyhow::Result<_> {
        let reading = SpecificationOptions { release: Some(release), ..diff.reading.clone() };
        let session = session::single(path, &reading)?;
        let unit = session.ask(path, |analysis| analysis.root_unit(path))?;
        Ok((session, unit))
    };
    let ((old_session, old), (new_session, new)) = (read(from)?, read(to)?);
    let mut checks = Vec::new();
    for (release, session, own, other) in
        [(from, &old_session, &old, &new), (to, &new_session, &new, &old)]
    {
        for diagnostic in own.diagnostics.iter() {
            if diagnostic.severity == Severity::Hint
                || other.diagnostics.iter().any(|that| is_same(diagnostic, that))
            {
                continue;
            }
            let text = session.ask(&diagnostic.path, |analysis| analysis.text(&diagnostic.path))?;
            let text = text.unwrap_or_default();
            let before = text.get(..diagnostic.range.start).unwrap_or_default();
            checks.push(CheckChange {
                only_in: release,
                severity: word(diagnostic.severity),
                code: diagnostic.code,
                file: session::display(&diagnostic.path),
                line: 1 + before.matches('\n').count(),
                message: diagnostic.message.clone(),
            });
        }
    }
    Ok(FileDiff {
        file: session::display(path),
        from,
        to,
        checks,
        generated: release_diff::compare(&old.spec, &new.spec),
    })
}

fn is_same(a: &Diagnostic, b: &Diagnostic) -> bool {
    (a.code, &a.path, &a.range, a.severity) == (b.code, &b.path, &b.range, b.severity)
}

fn word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Information => "information",
        Severity::Hint => "hint",
    }
}

impl FileDiff {
    fn is_empty(&self) -> bool {
        self.checks.is_empty() && self.generated == ReleaseDiff::default()
    }
}

fn print(diff: &FileDiff, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "{}: from GenoM3 {} to {}", diff.file, diff.from, diff.to)?;
    for release in [diff.from, diff.to].iter().filter(|release| !release.is_verified()) {
        writeln!(out, "  {release} is known from its changes only: not verified")?;
    }
    if diff.is_empty() {
        return writeln!(out, "  nothing changes");
    }
    for check in &diff.checks {
        writeln!(
            out,
            "  only in {}: {}:{}: {}: {} [{}]",
            check.only_in, check.file, check.line, check.severity, check.message, check.code
        )?;
    }
    let generated = &diff.generated;
    for digest in &generated.digests {
        match &digest.service {
            None => writeln!(
                out,
                "  component {}: digest {} becomes {}; clients have to be built again",
                digest.component, digest.from, digest.to
            )?,
            Some(service) => writeln!(
                out,
                "  service {}.{service}: digest {} becomes {}",
                digest.component, digest.from, digest.to
            )?,
        }
    }
    for ty in &generated.types {
        writeln!(out, "  type {} in {}:", ty.name, ty.language)?;
        print_text(ty, out)?;
    }
    for codel in &generated.prototypes {
        writeln!(out, "  prototype of {}:", codel.name)?;
        print_text(codel, out)?;
    }
    for stub in &generated.stubs {
        writeln!(
            out,
            "  stub of {}.{}: only {} writes it; it is declared by interface {}",
            stub.component, stub.codel, stub.only_in, stub.declared_by
        )?;
    }
    Ok(())
}

/// Prints the lines that differ.
fn print_text(change: &TextChange, out: &mut dyn Write) -> std::io::Result<()> {
    let (old, new): (Vec<&str>, Vec<&str>) =
        (change.from.lines().collect(), change.to.lines().collect());
    for line in old.iter().filter(|text| !new.contains(text)) {
        writeln!(out, "    - {line}")?;
    }
    for line in new.iter().filter(|text| !old.contains(text)) {
        writeln!(out, "    + {line}")?;
    }
    Ok(())
}
