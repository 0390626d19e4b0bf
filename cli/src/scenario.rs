//! `dotgen scenario`: scenarios from files of others.

use std::io::Write;

use anyhow::{Context, bail, ensure};
use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, Subcommand, ValueEnum};
use dotgen_analysis::ide::relative_path;
use dotgen_analysis::language;
use dotgen_platform::files::vfs;
use dotgen_timing::scn::ast::Unit;
use dotgen_timing::scn::requests;
use dotgen_views::verification::problem::components;

use crate::verify::one_problem;
use crate::{CommandExit, SpecificationOptions, report, session};

/// Write scenarios from files of published models
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Import(Import),
}

/// Write the scenario of a list of requests (NAME.rqst), or of a Fiacre client (NAME.client.fcr)
///
/// Requests become the steps of a client, in their order, with the waits between them. Names that no service
/// has are left out and reported.
///
/// Exit status: 0 if all requests are written, 1 if some have no service, 2 if nothing is written.
#[derive(Debug, Args)]
struct Import {
    /// A list of requests or a Fiacre client, and the specifications (.gen) of the services
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    /// Write a file, which must not exist [default: standard output]
    #[arg(long, short, value_name = "FILE")]
    output: Option<Utf8PathBuf>,

    /// Unit of the times in a Fiacre client
    #[arg(long, value_enum, default_value_t = UnitName::Ms)]
    unit: UnitName,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum UnitName {
    S,
    Ms,
    Us,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    match &arguments.command {
        Command::Import(import) => import.run(),
    }
}

impl Import {
    fn run(&self) -> anyhow::Result<CommandExit> {
        let is_specification = |path: &&Utf8PathBuf| language::is_specification(path);
        let specifications: Vec<_> = self.files.iter().filter(is_specification).cloned().collect();
        let others: Vec<_> = self.files.iter().filter(|path| !is_specification(path)).collect();
        let &[file] = &others[..] else {
            bail!("name one list of requests (.rqst) or Fiacre client (.client.fcr)");
        };
        ensure!(!specifications.is_empty(), "name the specification (.gen) of the services");
        let text = session::text(file, 1)?;
        let list = requests::parse(&text).map_err(|malformed| {
            anyhow::anyhow!("{file}:{}: {}", malformed.line, malformed.what)
        })?;
        let Some((_, problem)) = one_problem(&specifications, &self.reading)? else {
            return Ok(CommandExit::Unusable);
        };
        let specs = problem.specs();
        let all: Vec<_> = specs.iter().flat_map(|spec| components(spec)).collect();
        let unit = match self.unit {
            UnitName::S => Unit::Seconds,
            UnitName::Ms => Unit::Milliseconds,
            UnitName::Us => Unit::Microseconds,
        };
        let client = list.client(&all, unit);
        for what in &client.unknown {
            report::note(&format!("`{file}`, {what}: left out"));
        }
        ensure!(!client.steps.is_empty(), "`{file}` has no request of these components");
        let text = self.scenario(file, &specifications, &client.steps)?;
        self.write(&text)?;
        Ok(if client.unknown.is_empty() { CommandExit::Fine } else { CommandExit::Errors })
    }

    /// Returns the text of a scenario over the specifications, with a client of the steps.
    fn scenario(
        &self,
        file: &Utf8Path,
        specifications: &[Utf8PathBuf],
        steps: &[String],
    ) -> anyhow::Result<String> {
        let here = Utf8PathBuf::from_path_buf(std::env::current_dir()?).ok();
        let here = here.context("the current directory is not UTF-8")?;
        let output = here.join(self.output.as_deref().unwrap_or("-".into()));
        let folder = vfs::normalize(output.parent().unwrap_or(&here));
        let name = file.file_name().unwrap_or_default().split('.').next().unwrap_or_default();
        let is_name = name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
            && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        let name = if is_name { name } else { "imported" };
        let mut out = format!(
            "// The requests of `{}`.\nscenario {name} {{\n",
            file.file_name().unwrap_or_default()
        );
        for specification in specifications {
            let path = vfs::normalize(&here.join(specification));
            let path = relative_path(&folder, &path).unwrap_or(path);
            out += &format!("  use \"{path}\";\n");
        }
        out += "\n  client requests {\n";
        for step in steps {
            out += &format!("    {step}\n");
        }
        out += "  }\n\n  check schedulable *;\n}\n";
        Ok(out)
    }

    fn write(&self, text: &str) -> anyhow::Result<()> {
        let Some(path) = &self.output else {
            std::io::stdout().write_all(text.as_bytes())?;
            return Ok(());
        };
        let mut file =
            std::fs::File::create_new(path).with_context(|| format!("cannot create `{path}`"))?;
        file.write_all(text.as_bytes()).with_context(|| format!("cannot write `{path}`"))?;
        report::note(&format!("wrote `{path}`"));
        Ok(())
    }
}
