//! `dotgen query`: a declaration by its name.

use std::io::Write;

use anyhow::bail;
use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, ValueEnum};
use dotgen_analysis::diagnostic::{Diagnostic, Severity, Wording};
use dotgen_analysis::ide::{FilePosition, FileRange, NamedDeclaration, SymbolKind};
use dotgen_syntax::suggestion::nearest;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde_json::json;

use super::{CommandExit, SpecificationOptions, report, session};
use dotgen_lsp_server::protocol::convert::{Encoding, Lines};
use session::{Session, Texts};

/// The version of the JSON output.
const VERSION: u32 = 1;
/// Maximum number of declarations that are described, of each configuration.
const MAX_DECLARATIONS: usize = 100;
/// Maximum number of lines of documentation in the text form.
const MAX_DOCUMENTATION_LINES: usize = 60;

/// Print the documentation, uses and findings of a declaration
///
/// The name may have dots: `start` finds every declaration of this name, `pump.fill.start` only the state of
/// this activity.
///
/// Exit status: 0, 1 if nothing has this name, 2 if a file cannot be read.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Name of a component, type, task, port, service, state, codel, …, with or without what contains it
    #[arg(value_name = "NAME")]
    name: String,

    /// Specifications, and directories to search for .gen files
    #[arg(value_name = "PATH", default_value = ".")]
    paths: Vec<Utf8PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Json,
}

/// A declaration with everything that is known about it.
#[derive(Debug, Serialize)]
struct Declaration {
    name: String,
    kind: SymbolKind,
    #[serde(flatten)]
    place: Place,
    /// Markdown: declaration, documentation, state machine, times.
    documentation: Option<String>,
    uses: Vec<Place>,
    findings: Vec<Finding>,
}

/// A place in a file; lines and columns (in characters) count from 1.
#[derive(Debug, PartialEq, Eq, Serialize)]
struct Place {
    file: String,
    line: u32,
    column: u32,
    /// The line of the file.
    text: String,
}

/// A diagnostic inside the declaration.
#[derive(Debug, Serialize)]
struct Finding {
    code: &'static str,
    severity: Severity,
    message: Wording,
    line: u32,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let (files, trouble) = session::specifications(&arguments.paths);
    let names: Vec<&str> =
        arguments.name.split(['.', ':']).filter(|part| !part.is_empty()).collect();
    if names.is_empty() {
        bail!("`{}` is not a name", arguments.name);
    }
    let mut found: Vec<Declaration> = Vec::new();
    let mut known = Vec::new();
    let mut left_out = 0;
    for session in session::open(files, &arguments.reading)? {
        let Some(first) = session.files.first() else {
            continue;
        };
        let all = session.ask(&first.path, |analysis| analysis.named(&names))?;
        let mut all: Vec<_> = all.into_iter().map(|declaration| (declaration, None)).collect();
        if all.is_empty() {
            all = session.states(&first.path, &names)?;
            known.extend(session.ask(&first.path, |analysis| analysis.named(&[]))?);
        }
        left_out += all.len().saturating_sub(MAX_DECLARATIONS);
        all.truncate(MAX_DECLARATIONS);
        let mut describer = Describer::new(&session);
        for (declaration, machine) in &all {
            let described = describer.describe(declaration, machine.as_ref())?;
            // A shared file may be read under several configurations.
            match found.iter_mut().find(|declaration| declaration.place == described.place) {
                Some(same) => same.add_uses(described.uses),
                None => found.push(described),
            }
        }
    }
    if left_out > 0 {
        report::note(&format!("{left_out} more declarations: write more of the name"));
    }
    match arguments.format {
        Format::Json => {
            let text = format!("{:#}\n", json!({ "version": VERSION, "declarations": found }));
            std::io::stdout().write_all(dotgen_syntax::encoding::shown(&text).as_bytes())?;
        }
        Format::Text => {
            let text = found.iter().map(Declaration::text).collect::<Vec<_>>().join("\n");
            let text = dotgen_syntax::encoding::shown(&text);
            anstream::stdout().write_all(text.as_bytes())?;
        }
    }
    if found.is_empty() && !trouble.any() {
        let last = names.last().copied().unwrap_or_default();
        let simple = |declaration: &NamedDeclaration| declaration.names.last().cloned();
        let candidates: Vec<String> = known.iter().filter_map(simple).collect();
        let near = nearest(last, candidates.iter().map(String::as_str));
        let near = near.map_or_else(String::new, |text| format!("; did you mean `{text}`?"));
        super::failure(&anyhow::anyhow!("nothing is named `{}`{near}", arguments.name));
    }
    Ok(trouble.outcome(if found.is_empty() { CommandExit::Errors } else { CommandExit::Fine }))
}

impl Session {
    /// The states `machine.state`: a state belongs to its component, and is used in state machines. Each with
    /// the task or activity.
    fn states(
        &self,
        about: &Utf8Path,
        names: &[&str],
    ) -> anyhow::Result<Vec<(NamedDeclaration, Option<NamedDeclaration>)>> {
        let Some((state, machine)) = names.split_last().filter(|(_, rest)| !rest.is_empty()) else {
            return Ok(Vec::new());
        };
        let mut found = Vec::new();
        for machine in self.ask(about, |analysis| analysis.named(machine))? {
            let component = machine.names.first().map_or("", String::as_str);
            let states = self.ask(about, |analysis| analysis.named(&[component, state]))?;
            let states = states.into_iter().filter(|state| state.kind == SymbolKind::State);
            found.extend(states.map(|state| (state, Some(machine.clone()))));
        }
        Ok(found)
    }
}

/// Describes declarations of a session. Texts and diagnostics of a file are computed once.
struct Describer<'s> {
    session: &'s Session,
    texts: Texts,
    diagnostics: FxHashMap<Utf8PathBuf, Vec<Diagnostic>>,
}

impl Describer<'_> {
    fn new(session: &Session) -> Describer<'_> {
        Describer { session, texts: Texts::default(), diagnostics: FxHashMap::default() }
    }

    /// Everything known about a declaration; its uses only those inside `machine`.
    fn describe(
        &mut self,
        declaration: &NamedDeclaration,
        machine: Option<&NamedDeclaration>,
    ) -> anyhow::Result<Declaration> {
        let about = &declaration.path;
        let at = FilePosition { path: about.clone(), offset: declaration.range.start };
        let documentation = self.session.ask(about, |analysis| analysis.hover(&at))?;
        let uses = self.session.ask(about, |analysis| analysis.references(&at, false))?;
        let is_used = |range: &FileRange| {
            machine.is_none_or(|machine| {
                range.path == machine.path && machine.full_range.contains(&range.range.start)
            })
        };
        let uses = uses.into_iter().flatten().map(|usage| usage.place).filter(is_used);
        let uses: anyhow::Result<Vec<Place>> =
            uses.map(|usage| self.place(&usage.path, usage.range.start)).collect();
        Ok(Declaration {
            name: declaration.qualified(),
            kind: declaration.kind,
            place: self.place(about, declaration.range.start)?,
            documentation: documentation.map(|documentation| documentation.info.markdown),
            uses: uses?,
            findings: self.findings(declaration)?,
        })
    }

    /// The diagnostics inside a declaration.
    fn findings(&mut self, declaration: &NamedDeclaration) -> anyhow::Result<Vec<Finding>> {
        let path = &declaration.path;
        if !self.diagnostics.contains_key(path) {
            let all = self.session.ask(path, |analysis| analysis.diagnostics(path))?;
            self.diagnostics.insert(path.clone(), all);
        }
        let mut found = Vec::new();
        for diagnostic in &self.diagnostics[path] {
            if diagnostic.path == *path && declaration.full_range.contains(&diagnostic.range.start)
            {
                found.push((
                    diagnostic.code,
                    diagnostic.severity,
                    diagnostic.message.clone(),
                    diagnostic.range.start,
                ));
            }
        }
        let finding = |(code, severity, message, at)| {
            let line = self.place(path, at)?.line;
            Ok(Finding { code, severity, message, line })
        };
        found.into_iter().map(finding).collect()
    }

    fn place(&mut self, path: &Utf8PathBuf, offset: usize) -> anyhow::Result<Place> {
        if !self.texts.contains_key(path) {
            let text = self.session.ask(path, |analysis| analysis.text(path))?.unwrap_or_default();
            self.texts.insert(path.clone(), Lines::new(text, Encoding::Utf32));
        }
        let lines = &self.texts[path];
        let position = lines.position(offset);
        let text = lines.line(position.line).and_then(|line| lines.text().get(line));
        Ok(Place {
            file: session::display(path),
            line: position.line + 1,
            column: position.character + 1,
            text: text.unwrap_or_default().trim().to_owned(),
        })
    }
}

impl Declaration {
    /// Adds uses that were found under another configuration.
    fn add_uses(&mut self, uses: Vec<Place>) {
        for usage in uses {
            if !self.uses.contains(&usage) {
                self.uses.push(usage);
            }
        }
    }

    /// The declaration as Markdown, with its uses and findings.
    fn text(&self) -> String {
        let Place { file, line, column, .. } = &self.place;
        let mut out = format!("{file}:{line}:{column}: {}\n", self.name);
        if let Some(documentation) = &self.documentation {
            let lines: Vec<&str> = documentation.trim().lines().collect();
            let (shown, left) = lines.split_at(lines.len().min(MAX_DOCUMENTATION_LINES));
            out += &format!("\n{}\n", shown.join("\n"));
            if !left.is_empty() {
                out += &format!("… {} more lines\n", left.len());
            }
        }
        if !self.uses.is_empty() {
            let plural = if self.uses.len() == 1 { "" } else { "s" };
            out += &format!("\n{} use{plural}:\n", self.uses.len());
        }
        for usage in &self.uses {
            out += &format!("{}:{}:{}: {}\n", usage.file, usage.line, usage.column, usage.text);
        }
        if !self.findings.is_empty() {
            out += "\nfindings:\n";
        }
        for finding in &self.findings {
            out += &format!("{file}:{}: {} [{}]\n", finding.line, finding.message, finding.code);
        }
        out
    }
}
