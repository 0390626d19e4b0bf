//! `dotgen new`

use anyhow::Context;
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_analysis::host::AnalysisHost;
use dotgen_codegen::component::NewTask;

use super::report;
use super::{CommandExit, session};
use dotgen_lsp_server::features::codels::Disk;
use dotgen_lsp_server::features::component::{self, Answers};
use dotgen_platform::files::vfs::Vfs;

/// Create a component: a folder with a specification, a scenario and codel stubs
///
/// Existing files are never changed.
///
/// Exit status: 0 if the component was created, 2 if not.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Name of the component
    name: String,

    /// Add a task; without PERIOD, the task is not periodic [default: exec=10ms]
    #[arg(long = "task", value_name = "NAME[=PERIOD]")]
    tasks: Vec<String>,

    /// Provide the interface NAME that FILE declares
    #[arg(long, value_name = "FILE:NAME", value_parser = interface)]
    provides: Vec<(String, Utf8PathBuf)>,

    /// Use the interface NAME that FILE declares: its ports, with directions reversed
    #[arg(long, value_name = "FILE:NAME", value_parser = interface)]
    uses: Vec<(String, Utf8PathBuf)>,

    /// Folder of the component [default: its name]
    #[arg(long, value_name = "DIR")]
    directory: Option<Utf8PathBuf>,
}

/// `pose.gen:pose_estimator`
fn interface(text: &str) -> Result<(String, Utf8PathBuf), String> {
    match text.rsplit_once(':') {
        Some((file, name)) if !file.is_empty() && !name.is_empty() => {
            Ok((name.to_owned(), file.into()))
        }
        _ => Err("write the file, a colon and the interface, as in `pose.gen:pose`".to_owned()),
    }
}

fn task(text: &str) -> NewTask {
    match text.split_once('=') {
        Some((name, period)) => NewTask { name: name.to_owned(), period: Some(period.to_owned()) },
        None => NewTask { name: text.to_owned(), period: None },
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let absolute = |path: &Utf8Path| -> anyhow::Result<Utf8PathBuf> {
        camino::absolute_utf8(path).with_context(|| format!("`{path}` is no path"))
    };
    let interfaces = |all: &[(String, Utf8PathBuf)]| -> anyhow::Result<Vec<_>> {
        let all = all.iter();
        all.map(|(name, path)| Ok((name.clone(), absolute(path)?))).collect()
    };
    anyhow::ensure!(
        !arguments.name.is_empty(),
        "a component needs a name: write for example `dotgen new arm`"
    );
    let name = Utf8Path::new(&arguments.name);
    let folder = absolute(arguments.directory.as_deref().unwrap_or(name))?;
    let tasks = match arguments.tasks.as_slice() {
        [] => vec![task("exec=10ms")],
        given => given.iter().map(|text| task(text)).collect(),
    };
    let answers = Answers {
        name: arguments.name.clone(),
        tasks,
        provides: interfaces(&arguments.provides)?,
        uses: interfaces(&arguments.uses)?,
    };
    let mut host = AnalysisHost::new(std::sync::Arc::new(Vfs::default()));
    let files = component::files(&mut host, &Disk, &folder, &answers);
    let files = files.map_err(anyhow::Error::msg)?;
    let contents = files.iter().map(|file| report::edited(&file.0, None, &file.1)).collect();
    report::write_files(contents, &[])?;
    for (path, _) in &files {
        report::note(&format!("wrote `{}`", session::display(path)));
    }
    Ok(CommandExit::Fine)
}
