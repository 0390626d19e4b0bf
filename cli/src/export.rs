//! `dotgen export`: formal models for tools of others.

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, ValueEnum};
use dotgen_analysis::host::FileContent;
use dotgen_analysis::model::Src;
use dotgen_export::{Format, export};
use dotgen_platform::files::vfs;
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::{Options, Prepared};
use dotgen_views::verification::Problem;

use super::session::Session;
use super::system_options::{DurationsName, SystemOptions};
use super::verify::{body, one_problem, parsed, prepared};
use super::{CommandExit, SpecificationOptions, report, session};

/// Words of the first lines of each file that the command writes.
const MARK: &str = "written by dotgen export";

/// Write the formal model of a scenario for UPPAAL, TChecker, TINA or BIP
///
/// The model has cores, policy, clients, durations and checks of the scenario. What the format cannot say is
/// an error that names it; nothing is left out.
///
/// Exit status: 0 if the model is written, 2 if not.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The tool
    #[arg(value_name = "TOOL", value_enum)]
    tool: Tool,

    /// Write the files into DIR
    #[arg(long, short, value_name = "DIR", default_value = ".")]
    output: Utf8PathBuf,

    #[command(flatten)]
    model: ModelOptions,
}

/// The system of a formal model, and its checks.
#[derive(Debug, Args)]
pub(super) struct ModelOptions {
    /// A scenario (.scn), or specifications (.gen)
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    #[command(flatten)]
    system: SystemOptions,

    /// Execution times of codels
    #[arg(long, value_enum)]
    durations: Option<DurationsName>,

    /// Use CHECK instead of the scenario's checks, for example "response arm.motion <= 5 ms"
    #[arg(long = "check", value_name = "CHECK", action = clap::ArgAction::Append)]
    checks: Vec<String>,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Tool {
    /// Network and queries of UPPAAL (.xta, .q, and a drawing with both: .xml)
    Uppaal,
    /// Network of TChecker (.tck), a label for each query
    Tchecker,
    /// Fiacre program of TINA (.fcr), a property for each check
    Fiacre,
    /// BIP 2 with real time (.bip), a place for each check
    Bip,
}

/// The system of a formal model.
pub(super) struct Model {
    session: Session,
    pub(super) problem: Problem,
    pub(super) options: Options,
    pub(super) prepared: Prepared,
}

impl ModelOptions {
    /// Prepares the system. Returns `None` after errors, which are printed.
    pub(super) fn model(&self) -> anyhow::Result<Option<Model>> {
        let Some((session, problem)) = one_problem(&self.files, &self.reading)? else {
            return Ok(None);
        };
        let checks: Vec<&str> = self.checks.iter().map(|check| body(check)).collect();
        let options = Options {
            durations: self.durations.map(DurationsName::durations),
            checks: parsed(&checks, &problem)?,
            ..self.system.options()
        };
        let prepared = prepared(&session, &problem, &options, &checks, true)?;
        Ok(prepared.map(|prepared| Model { session, problem, options, prepared }))
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let Some(Model { session, problem, prepared, .. }) = arguments.model.model()? else {
        return Ok(CommandExit::Unusable);
    };
    let names = Names::new(&problem.specs());
    let place = |component: usize, src: Src| {
        let (path, range) = problem.place(names.components.get(component)?.spec_index, src)?;
        let text = session.ask(&path, |analysis| analysis.text(&path)).ok()??;
        let line = 1 + text.get(..range.start)?.matches('\n').count();
        Some(format!("{}:{line}", path.file_name()?))
    };
    let format = match arguments.tool {
        Tool::Uppaal => Format::Uppaal,
        Tool::Tchecker => Format::TChecker,
        Tool::Fiacre => Format::Fiacre,
        Tool::Bip => Format::Bip,
    };
    let files = match export(&prepared, &place, format) {
        Ok(files) => files,
        Err(refusals) => {
            for refusal in refusals {
                report::note(&refusal.to_string());
            }
            bail!("nothing was written: the model would not be that of `dotgen verify`");
        }
    };
    std::fs::create_dir_all(&arguments.output)
        .with_context(|| format!("cannot create `{}`", arguments.output))?;
    let paths: Vec<Utf8PathBuf> =
        files.iter().map(|file| arguments.output.join(&file.name)).collect();
    paths.iter().try_for_each(|path| check_is_own(path))?;
    let contents = files.iter().zip(&paths);
    let contents = contents.map(|(file, path)| report::new_content(path, &file.text)).collect();
    report::write_files(contents, &[])?;
    for path in &paths {
        report::note(&format!("wrote `{}`", session::display(path)));
    }
    Ok(CommandExit::Fine)
}

/// Checks that a file is missing, or was written by an earlier export.
fn check_is_own(path: &Utf8Path) -> anyhow::Result<()> {
    match vfs::read(path) {
        FileContent::Missing => Ok(()),
        FileContent::Text(text) if text.lines().take(3).any(|line| line.contains(MARK)) => Ok(()),
        _ => bail!(
            "`{path}` exists and is not from an earlier export; choose another folder with `-o`"
        ),
    }
}
