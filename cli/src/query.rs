//! `dotgen query`: a declaration by its name.

use std::io::Write;

use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, ValueEnum};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::ide::{FilePosition, FileRange, NamedDeclaration, SymbolKind};
use dotgen_syntax::suggestion::nearest;
use serde::Serialize;
use serde_json::json;

use super::{Outcome, SpecificationOptions, session};
use dotgen_lsp_server::protocol::convert::{Encoding, Lines};
use session::{Session, Texts};

/// The version of the JSON output.
const VERSION: u32 = 1;

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
#[derive(Debug, Serialize)]
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
    message: String,
    line: u32,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let (files, trouble) = session::specifications(&arguments.paths);
    let names: Vec<&str> = arguments
        .name
        .split(['.', ':'])
        .filter(|it| !it.is_empty())
        .collect();
    let mut found = Vec::new();
    let mut known = Vec::new();
    for session in session::open(files, &arguments.reading)? {
        let Some(first) = session.files.first() else {
            continue;
        };
        let all = session.ask(&first.path, |it| it.named(&names))?;
        for declaration in &all {
            found.push(session.described(declaration, None)?);
        }
        if all.is_empty() {
            for (state, machine) in session.states(&first.path, &names)? {
                found.push(session.described(&state, Some(&machine))?);
            }
            known.extend(session.ask(&first.path, |it| it.named(&[]))?);
        }
    }
    match arguments.format {
        Format::Json => {
            let text = format!(
                "{:#}\n",
                json!({ "version": VERSION, "declarations": found })
            );
            std::io::stdout().write_all(dotgen_syntax::encoding::shown(&text).as_bytes())?;
        }
        Format::Text => {
            let text = found
                .iter()
                .map(Declaration::text)
                .collect::<Vec<_>>()
                .join("\n");
            let text = dotgen_syntax::encoding::shown(&text);
            anstream::stdout().write_all(text.as_bytes())?;
        }
    }
    if found.is_empty() && !trouble.any() {
        let last = names.last().copied().unwrap_or_default();
        let simple = |it: &NamedDeclaration| it.name.rsplit('.').next().map(str::to_owned);
        let candidates: Vec<String> = known.iter().filter_map(simple).collect();
        let near = nearest(last, candidates.iter().map(String::as_str));
        let near = near.map_or_else(String::new, |it| format!("; did you mean `{it}`?"));
        super::failure(&anyhow::anyhow!(
            "nothing is named `{}`{near}",
            arguments.name
        ));
    }
    Ok(trouble.outcome(match found.is_empty() {
        true => Outcome::Errors,
        false => Outcome::Fine,
    }))
}

impl Session {
    /// The states `machine.state`: a state belongs to its component, and is used in state machines. Each with
    /// the task or activity.
    fn states(
        &self,
        about: &Utf8Path,
        names: &[&str],
    ) -> anyhow::Result<Vec<(NamedDeclaration, NamedDeclaration)>> {
        let Some((state, machine)) = names.split_last().filter(|it| !it.1.is_empty()) else {
            return Ok(Vec::new());
        };
        let mut found = Vec::new();
        for machine in self.ask(about, |it| it.named(machine))? {
            let component = machine.name.split('.').next().unwrap_or_default();
            let states = self.ask(about, |it| it.named(&[component, state]))?;
            let states = states.into_iter().filter(|it| it.kind == SymbolKind::State);
            found.extend(states.map(|it| (it, machine.clone())));
        }
        Ok(found)
    }

    /// Everything known about a declaration; its uses only those inside `machine`.
    fn described(
        &self,
        declaration: &NamedDeclaration,
        machine: Option<&NamedDeclaration>,
    ) -> anyhow::Result<Declaration> {
        let at = FilePosition {
            path: declaration.path.clone(),
            offset: declaration.range.start,
        };
        let about = &declaration.path;
        let documentation = self.ask(about, |it| it.hover(&at))?;
        let uses = self.ask(about, |it| it.references(&at, false))?;
        let findings = self.ask(about, |it| it.diagnostics(about))?;
        let mut texts = Texts::default();
        let mut place = |path: &Utf8PathBuf, offset: usize| -> anyhow::Result<Place> {
            if !texts.contains_key(path) {
                let text = self.ask(path, |it| it.text(path))?.unwrap_or_default();
                texts.insert(path.clone(), Lines::new(text, Encoding::Utf32));
            }
            let lines = &texts[path];
            let position = lines.position(offset);
            let text = lines
                .text()
                .lines()
                .nth(position.line as usize)
                .unwrap_or_default();
            Ok(Place {
                file: session::display(path),
                line: position.line + 1,
                column: position.character + 1,
                text: text.trim().to_owned(),
            })
        };
        let inside = |at: usize| declaration.full_range.contains(&at);
        let findings = findings
            .into_iter()
            .filter(|it| &it.path == about && inside(it.range.start));
        let findings: anyhow::Result<Vec<Finding>> = findings
            .map(|it| {
                Ok(Finding {
                    code: it.code,
                    severity: it.severity,
                    line: place(&it.path, it.range.start)?.line,
                    message: it.message,
                })
            })
            .collect();
        let mut uses = uses.unwrap_or_default();
        if let Some(machine) = machine {
            let inside = |it: &FileRange| {
                it.path == machine.path && machine.full_range.contains(&it.range.start)
            };
            uses.retain(|it| inside(&it.place));
        }
        let uses: anyhow::Result<Vec<Place>> = uses
            .iter()
            .map(|it| place(&it.place.path, it.place.range.start))
            .collect();
        Ok(Declaration {
            name: declaration.name.clone(),
            kind: declaration.kind,
            place: place(&declaration.path, declaration.range.start)?,
            documentation: documentation.map(|it| it.info.markdown),
            uses: uses?,
            findings: findings?,
        })
    }
}

impl Declaration {
    /// The declaration as Markdown, with its uses and findings.
    fn text(&self) -> String {
        let Place {
            file, line, column, ..
        } = &self.place;
        let mut out = format!("{file}:{line}:{column}: {}\n", self.name);
        if let Some(documentation) = &self.documentation {
            out += &format!("\n{}\n", documentation.trim());
        }
        if !self.uses.is_empty() {
            out += &format!("\n{} uses:\n", self.uses.len());
        }
        for it in &self.uses {
            out += &format!("{}:{}:{}: {}\n", it.file, it.line, it.column, it.text);
        }
        if !self.findings.is_empty() {
            out += "\nfindings:\n";
        }
        for it in &self.findings {
            out += &format!("{file}:{}: {} [{}]\n", it.line, it.message, it.code);
        }
        out
    }
}
