//! The results of a command, and the formats in which they are printed.

pub(super) mod json;
pub(super) mod sarif;
pub(super) mod text;

use std::collections::HashSet;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use clap::ValueEnum;
use dotgen_analysis::deps::Dependencies;
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::language::SCENARIO;
use dotgen_analysis::terminal;
use dotgen_codegen::codels::coverage::Coverage;
use dotgen_codegen::disk::{Disk as _, NewContent};
use dotgen_syntax::encoding;
use schemars::JsonSchema;
use serde::Serialize;

use super::session::{SourceFile, Texts, absolute, display};
use super::width::wrapped_for_errors;
use dotgen_lsp_server::protocol::convert::{Encoding, Lines};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs;

/// The message of a build without Zenoh.
#[cfg(not(feature = "zenoh"))]
pub(super) const NO_ZENOH: &str = "this build of dotgen has no Zenoh, as the one in the VS Code extension: install \
    dotgen from the archive, the Debian package or the wheel of a release, or build it with `--features zenoh`";

/// Diagnostics of all files checked.
#[derive(Default)]
pub(super) struct FileReports {
    pub(super) diagnostics: Vec<Diagnostic>,
    /// The texts to which the diagnostics refer.
    pub(super) texts: Texts,
    /// Number of specifications.
    pub(super) checked: usize,
    /// The number of specifications with codels that have no function.
    pub(super) incomplete: usize,
    /// Coverage of the codels, by component.
    pub(super) compared: Vec<Compared>,
    /// The names that could not be checked because packages and files are missing.
    pub(super) waiting: Vec<OpenNames>,
}

/// Names of a specification that only a missing package or file can explain.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct OpenNames {
    /// The names, each once.
    pub(super) names: Vec<String>,
    /// The packages and files that are missing.
    #[serde(rename = "for")]
    pub(super) missing: Vec<String>,
}

impl OpenNames {
    /// Returns the names that need something missing, if there are any.
    pub(super) fn of(needs: &Dependencies) -> Option<OpenNames> {
        let unknown = needs.unknown.iter().map(|name| name.name.to_string());
        let interfaces = needs.interfaces.iter().filter(|interface| interface.found.is_none());
        let interfaces = interfaces.map(|interface| interface.name.to_string());
        let mut names: Vec<String> = unknown.chain(interfaces).collect();
        names.sort();
        names.dedup();
        let packages = needs.missing_packages();
        let packages = packages
            .flat_map(|package| package.brought_by.iter().map(|provider| provider.package.clone()));
        let files = needs.includes.iter().filter(|include| include.found.is_none());
        let mut missing: Vec<String> = packages.collect();
        if missing.is_empty() {
            missing.extend(files.map(|file| file.path.clone()));
        }
        (!names.is_empty()).then_some(OpenNames { names, missing })
    }
}

/// How much of the codels of a component was compared.
#[derive(Debug, Serialize)]
pub(super) struct Compared {
    /// The specification, relative to the current directory if it is below it.
    pub(super) file: String,
    pub(super) component: String,
    #[serde(flatten)]
    pub(super) coverage: Coverage,
}

impl FileReports {
    /// Merges the diagnostics of several units about a shared file.
    pub(super) fn finish(&mut self) {
        let mut seen = HashSet::new();
        self.diagnostics.retain(|diagnostic| {
            let place = (diagnostic.path.clone(), diagnostic.range.start, diagnostic.range.end);
            seen.insert((place, diagnostic.code, diagnostic.message.clone()))
        });
    }

    /// Adds diagnostics, and the texts that their places are in.
    pub(super) fn add(
        &mut self,
        diagnostics: Vec<Diagnostic>,
        mut text_of: impl FnMut(&Utf8Path) -> Option<Arc<str>>,
    ) {
        for diagnostic in &diagnostics {
            let related = diagnostic.related.iter().map(|related| &related.path);
            for path in std::iter::once(&diagnostic.path).chain(related) {
                let lines = || Lines::new(text_of(path).unwrap_or_default(), Encoding::Utf16);
                self.texts.entry(path.clone()).or_insert_with(lines);
            }
        }
        self.diagnostics.extend(diagnostics);
    }

    /// Number of diagnostics of a severity.
    pub(super) fn count(&self, severity: Severity) -> usize {
        let of = |diagnostic: &&Diagnostic| diagnostic.severity == severity;
        self.diagnostics.iter().filter(of).count()
    }
}

/// Output format of most commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum TextOrJson {
    /// For people
    Text,
    /// For programs
    Json,
}

/// Output format of diagnostics.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum Format {
    /// For people
    Text,
    /// For programs: positions as in the LSP (from 0, in UTF-16 units)
    Json,
    /// SARIF 2.1.0, for code scanning services
    Sarif,
}

/// Prints a report.
pub(super) fn print(report: &FileReports, format: Format) -> anyhow::Result<()> {
    match format {
        Format::Text => text::print(report),
        Format::Json => json::print(report),
        Format::Sarif => sarif::print(report),
    }
}

/// Prints a note on standard error.
pub(super) fn note(text: &str) {
    use std::io::Write as _;
    let style = clap::builder::styling::AnsiColor::Cyan.on_default().bold();
    let text = encoding::shown(text);
    let text = terminal::text(&text);
    let text = wrapped_for_errors(&text, "note: ".len(), 2);
    let _ = writeln!(anstream::stderr(), "{style}note{style:#}: {text}");
}

/// Prints a note about scenarios of directories that are read for their specifications only. Scenarios in
/// `files` were named.
pub(super) fn note_unused_scenarios(arguments: &[Utf8PathBuf], files: &[SourceFile]) {
    for argument in arguments.iter().filter(|argument| argument.is_dir()) {
        let Ok(path) = absolute(argument) else {
            continue;
        };
        let mut found = vfs::files_below(&path, &[SCENARIO]).files;
        found.retain(|path| !files.iter().any(|file| file.path == *path));
        let names: Vec<_> = (found.iter()).map(|path| format!("`{}`", display(path))).collect();
        match names.as_slice() {
            [] => {}
            [one] => note(&format!("{one} is not used; name it to use its checks")),
            several => note(&format!(
                "not used: {}; name a scenario to use its checks",
                several.join(", ")
            )),
        }
    }
}

/// Returns a patch for standard output: safe for a terminal, and unchanged for a file or a program.
pub(super) fn patch(text: &str) -> String {
    use std::io::IsTerminal;
    let shown = encoding::shown(text);
    if std::io::stdout().is_terminal() {
        terminal::text(&shown).into_owned()
    } else {
        shown.into_owned()
    }
}

/// Writes the new content of files: all of them, or none. Links do not lead out of the folders `within`. If
/// there are no folders, the user named the paths.
pub(super) fn write_files(
    mut files: Vec<NewContent>,
    within: &[Utf8PathBuf],
) -> anyhow::Result<()> {
    for file in &mut files {
        file.within = within.iter().map(Into::into).collect();
    }
    Ok(SystemDisk.write(&files)?)
}

/// Returns the content of a file that no other program edits.
pub(super) fn new_content(path: &Utf8Path, text: &str) -> NewContent {
    NewContent::new(path, encoding::encode(text).into_owned())
}

/// Returns the new content of a file that is edited as text. `before` is the text that was read; `None` if
/// there was no file.
pub(super) fn edited(path: &Utf8Path, before: Option<&str>, text: &str) -> NewContent {
    let before = before.map(|before| encoding::encode(before).into_owned());
    NewContent { before: before.into(), ..new_content(path, text) }
}
