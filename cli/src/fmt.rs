//! `dotgen fmt`

use std::io::Write as _;

use anyhow::{anyhow, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::FileContent;
use dotgen_codegen::disk::{Disk as _, NewContent};
use dotgen_syntax::encoding::{self, LineEnd};
use dotgen_syntax::{format, parse_text};
use dotgen_timing::scn;
use similar::TextDiff;

use super::report;
use super::session::{self, Session, SourceFile};
use super::{CommandExit, SpecificationOptions};
use dotgen_lsp_server::config::style;
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs;

/// Lines shown around each change.
const CONTEXT: usize = 3;

/// Format specifications and scenarios
///
/// Changes blanks and line ends only. A declaration that does not parse stays unchanged, and so does a file
/// with a missing brace. Either all files are written or none. A file that cannot be read is reported; the
/// others are formatted.
///
/// Exit status: 0 if all files are formatted, 1 with --check if a file is not, 2 if a file cannot be read or
/// written.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Files, directories to search for .gen, .idl and .scn files, or - for standard input [default: .]
    #[arg(value_name = "PATH")]
    paths: Vec<Utf8PathBuf>,

    /// Write nothing; print the changes
    #[arg(long)]
    check: bool,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    if arguments.paths.iter().any(|path| session::is_standard_input(path)) {
        if arguments.paths.len() > 1 {
            bail!("`-` stands for standard input and goes with no other path");
        }
        return standard_input(arguments.check);
    }
    // In directories, files that are only included are formatted too.
    let paths = session::or_here(&arguments.paths);
    let (files, mut trouble) = session::usable_files(&paths, &["gen", "idl", "scn"]);
    let count = files.len();
    let mut changed = Vec::new();
    for session in session::open(files, &arguments.reading)? {
        for file in &session.files {
            let result = trouble.ok_or_report(formatted(&session, file));
            if let Some((old, new)) = result.filter(|entry| entry.0 != entry.1) {
                if arguments.check {
                    print_diff(&session::display(&file.path), &old, &new)?;
                }
                let content = report::edited(&file.path, Some(&old), &new);
                let content = NewContent {
                    within: session.writable().into_iter().map(Into::into).collect(),
                    ..content
                };
                // A link that leads out concerns this file only; the others are formatted.
                match content.leads_out(&SystemDisk) {
                    Some(reason) => trouble.tell(&anyhow!(
                        "cannot write `{}`: {reason}",
                        session::display(&file.path)
                    )),
                    None => changed.push(content),
                }
            }
        }
    }
    let differs = !changed.is_empty();
    if !arguments.check {
        let written = SystemDisk.write(&changed).map_err(Into::into);
        if trouble.ok_or_report(written).is_some() {
            let counted = |count: usize, what: &str| match count {
                0 => None,
                1 => Some(format!("1 file {what}")),
                _ => Some(format!("{count} files {what}")),
            };
            let formatted = counted(changed.len(), "formatted");
            let others = counted(count - changed.len(), "left as before");
            let parts: Vec<String> = formatted.into_iter().chain(others).collect();
            report::note(&parts.join(", "));
        }
    }
    Ok(trouble.outcome(if arguments.check && differs {
        CommandExit::Errors
    } else {
        CommandExit::Fine
    }))
}

/// Returns the text of a file, and the formatted text.
fn formatted(session: &Session, file: &SourceFile) -> anyhow::Result<(String, String)> {
    let path: &Utf8Path = &file.path;
    // Edits are for the text that analysis has, which it may have read before as an included file.
    let known = session.ask(path, |analysis| analysis.text(path))?;
    let old = match vfs::read(path) {
        FileContent::Text(text) | FileContent::NotUtf8(text) => match known {
            Some(known) => known.to_string(),
            None => text,
        },
        FileContent::Unreadable(why) => bail!("cannot read `{}`: {why}", session::display(path)),
        _ => bail!("cannot read `{}`", session::display(path)),
    };
    let new = if file.is_scenario() {
        match scn::format(&old) {
            Some(new) => LineEnd::of(&old).fit(&new).into_owned(),
            None => left(path, &old),
        }
    } else {
        let style = style::options(&session.format, path, None);
        let edits = session.ask(path, |analysis| analysis.format(path, None, &style))?;
        if edits.is_empty() && lacks_brace(&old) {
            left(path, &old);
        }
        apply(&old, &edits)
    };
    Ok((old, new))
}

/// Reports that a file stays unchanged, and returns its text.
fn left(path: &Utf8Path, text: &str) -> String {
    let path = session::display(path);
    report::note(&format!(
        "`{path}` is left as it is because of syntax errors; `dotgen check {path}` lists them"
    ));
    text.to_owned()
}

/// Returns true if a text is not formatted because its braces are not paired.
fn lacks_brace(text: &str) -> bool {
    let parse = parse_text(text);
    !parse.errors.is_empty() && !format::is_paired(&parse.syntax())
}

fn apply(text: &str, edits: &[FileEdit]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        out.push_str(&text[at..edit.range.start]);
        out.push_str(&edit.new_text);
        at = edit.range.end;
    }
    out.push_str(&text[at..]);
    out
}

/// Formats standard input. Its includes are not followed, because the text has no path.
fn standard_input(check: bool) -> anyhow::Result<CommandExit> {
    let old = session::standard_input()?;
    let parse = parse_text(&old);
    let style = format::Options::default();
    let new = format::apply(&old, &format::format(&parse.syntax(), &parse.broken(), None, &style));
    if !check {
        std::io::stdout().write_all(&encoding::encode(&new))?;
    } else if old != new {
        print_diff("-", &old, &new)?;
        return Ok(CommandExit::Errors);
    }
    Ok(CommandExit::Fine)
}

/// Prints differences as a unified diff.
pub(super) fn print_diff(name: &str, old: &str, new: &str) -> anyhow::Result<()> {
    let diff = TextDiff::from_lines(old, new);
    let mut unified = diff.unified_diff();
    unified.context_radius(CONTEXT).header(name, name);
    let mut out = std::io::stdout().lock();
    let unified = unified.to_string();
    write!(out, "{}", report::patch(&unified))?;
    Ok(())
}
