//! `dotgen fmt`

use std::io::{Read as _, Write as _};

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_syntax::{format, parse_text};
use dotgen_timing::scn;
use similar::TextDiff;

use super::report;
use super::session::{self, Session, SourceFile};
use super::{Outcome, Reading};
use crate::style;
use crate::vfs;

/// Lines shown around each change.
const CONTEXT: usize = 3;

/// Bring specifications in shape
///
/// Changes blanks and line ends only; a declaration that does not parse is left as it is, and so is a
/// file in which a brace is missing.
///
/// Exit status: 0 when everything is (now) in shape, 1 with --check when something is not, 2 if a
/// file cannot be read or written.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Files, directories to search for .gen, .idl and .scn files, or - for standard input [default: .]
    #[arg(value_name = "PATH")]
    paths: Vec<Utf8PathBuf>,

    /// Change nothing; print what would change
    #[arg(long)]
    check: bool,

    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if arguments.paths.iter().any(|it| it == "-") {
        if arguments.paths.len() > 1 {
            bail!("`-` stands for standard input and goes with no other path");
        }
        return standard_input(arguments.check);
    }
    let here = [Utf8PathBuf::from(".")];
    let paths = match arguments.paths.as_slice() {
        [] => &here[..],
        paths => paths,
    };
    let files = files(paths)?;
    let mut changed = 0;
    for session in session::open(files, &arguments.reading)? {
        for file in &session.files {
            changed += usize::from(format_file(&session, file, arguments.check)?);
        }
    }
    Ok(match arguments.check && changed > 0 {
        true => Outcome::Errors,
        false => Outcome::Fine,
    })
}

/// The files that the arguments name; of directories, also those that are only included.
fn files(arguments: &[Utf8PathBuf]) -> anyhow::Result<Vec<session::SourceFile>> {
    let mut paths = Vec::new();
    for argument in arguments {
        match argument.is_dir() {
            true => {
                let found = vfs::files_below(argument, &["gen", "idl", "scn"]);
                if found.is_empty() {
                    bail!("no .gen, .idl or .scn file below `{argument}`");
                }
                paths.extend(found);
            }
            false => paths.push(argument.clone()),
        }
    }
    session::files(&paths)
}

/// Whether the file was not in shape.
fn format_file(session: &Session, file: &SourceFile, check: bool) -> anyhow::Result<bool> {
    let path: &Utf8Path = &file.path;
    let old = session.ask(path, |it| it.text(path))?;
    let old = old.with_context(|| format!("cannot read `{path}`"))?;
    let new = if file.is_scenario() {
        scn::format(&old).unwrap_or_else(|| left(path, &old))
    } else {
        let style = style::options(&session.format, path, None);
        let edits = session.ask(path, |it| it.format(path, None, &style))?;
        if edits.is_empty() && lacks_brace(&old) {
            left(path, &old);
        }
        apply(&old, &edits)
    };
    if *old == *new {
        return Ok(false);
    }
    if check {
        print_diff(&session::display(path), &old, &new)?;
    } else {
        // What is not UTF-8 was read with replacements: writing it would lose text.
        if !matches!(vfs::read(path), dotgen_analysis::host::FileContent::Text(_)) {
            bail!("`{path}` is not UTF-8 text; it is left as it is");
        }
        std::fs::write(path, new).with_context(|| format!("cannot write `{path}`"))?;
    }
    Ok(true)
}

/// Says that a file stays as it is, and gives its text.
fn left(path: &Utf8Path, text: &str) -> String {
    let path = session::display(path);
    report::note(&format!(
        "`{path}` is left as it is because of its syntax errors; `dotgen check {path}` tells them"
    ));
    text.to_owned()
}

/// Whether nothing of a text is formatted because its braces are not paired.
fn lacks_brace(text: &str) -> bool {
    let parse = parse_text(text);
    !parse.errors.is_empty() && !format::is_paired(&parse.syntax())
}

fn apply(text: &str, edits: &[FileEdit]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for it in edits {
        out.push_str(&text[at..it.range.start]);
        out.push_str(&it.new_text);
        at = it.range.end;
    }
    out.push_str(&text[at..]);
    out
}

/// A text without a place: its includes are not followed.
fn standard_input(check: bool) -> anyhow::Result<Outcome> {
    let mut old = String::new();
    std::io::stdin()
        .read_to_string(&mut old)
        .context("cannot read standard input as UTF-8 text")?;
    let parse = parse_text(&old);
    let broken: Vec<_> = parse.errors.iter().map(|it| it.range).collect();
    let style = format::Options::default();
    let new = format::apply(
        &old,
        &format::format(&parse.syntax(), &broken, None, &style),
    );
    if !check {
        std::io::stdout().write_all(new.as_bytes())?;
    } else if old != new {
        print_diff("-", &old, &new)?;
        return Ok(Outcome::Errors);
    }
    Ok(Outcome::Fine)
}

/// Prints what differs as a unified diff.
pub(super) fn print_diff(name: &str, old: &str, new: &str) -> anyhow::Result<()> {
    let diff = TextDiff::from_lines(old, new);
    let mut unified = diff.unified_diff();
    unified.context_radius(CONTEXT).header(name, name);
    let mut out = std::io::stdout().lock();
    write!(out, "{unified}")?;
    Ok(())
}
