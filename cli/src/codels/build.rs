//! `dotgen codels build`

use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_analysis::diagnostic::{Diagnostic, Related, Severity};
use dotgen_analysis::source_map::Locations as _;
use dotgen_codegen::codels::build::{
    self, CompilerMessage, Contents, MessageLevel, Optimization, Packages, Plan, Step, Tools,
};
use dotgen_codegen::codels::files::Files as _;
use dotgen_codegen::codels::folder::Folder;
use dotgen_codegen::codels::links::codel_functions;
use dotgen_codegen::codels::shared_object::{SharedObject, hosted};
use dotgen_codegen::disk::{Disk as _, NewContent};
use dotgen_codegen::process::Processes as _;
use dotgen_syntax::packages;
use dotgen_timing::verify::Interrupt;

use super::{check_is_file, project, roots};
use crate::progress::{self, Activity};
use crate::report::{self, FileReports, Format};
use crate::{CommandExit, SpecificationOptions, session};
use dotgen_lsp_server::features::codels::Disk;
use dotgen_lsp_server::features::codels::headers::{FOLDER, IGNORED};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs;
use dotgen_platform::files::vfs::PackageConfig;
use dotgen_platform::process;

/// Folder of builds, below that of generated headers.
const RUN: &str = "run";

/// Code of diagnostics from compilers.
const CODE: &str = "codel/compiler";

/// Compile codels with the system's compilers; GenoM3 is not needed
///
/// Compiles the sources of codels against the mapped types of their specification and links them into a
/// shared object below `.dotgen/run`. Only changed sources are compiled, on all cores. pkg-config finds the
/// packages of `requires` and `codels-requires`. $CC and $CXX select other compilers.
///
/// Exit status: 0 if all codels exist and compile (warnings do not count), 1 if one is missing or does not
/// compile, 2 if nothing could be compiled.
#[derive(Debug, Args)]
pub(super) struct Build {
    /// Specifications, and directories to search for .gen files
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<Utf8PathBuf>,

    /// Number of compilers to run at the same time [default: one per processor core]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,

    /// Output format of the compilers' messages
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Build) -> anyhow::Result<CommandExit> {
    check_is_file(&arguments.paths)?;
    let (files, mut trouble) = session::specifications(&arguments.paths);
    let tools = tools(Optimization::Some)?;
    let mut report = FileReports::default();
    let mut errors = Vec::new();
    let mut whole = true;
    for mut session in session::open(files, &arguments.reading)? {
        let roots = roots(&session);
        let packages = session.packages().clone();
        let mut project = project(&mut session);
        whole &= !roots.iter().any(|root| project.has_errors_in_text(root));
        for folder in project.folders(&roots, &mut errors) {
            let built = Builder {
                folder: &folder,
                tools: &tools,
                packages: &packages,
                jobs: arguments.jobs.map(usize::from),
                // A signal ends this process, and its compilers with it.
                interrupt: &Interrupt::default(),
            };
            let Some(built) = trouble.ok_or_report(built.build()) else {
                continue;
            };
            whole &= built.whole;
            report.checked += 1;
            report.incomplete += usize::from(!built.complete);
            report.add(built.diagnostics, |path| Disk.read(path));
        }
    }
    report.finish();
    report::print(&report, arguments.format)?;
    for error in errors {
        trouble.tell(&anyhow::Error::msg(error));
    }
    let outcome = if whole && report.count(Severity::Error) == 0 {
        CommandExit::Fine
    } else {
        CommandExit::Errors
    };
    Ok(trouble.outcome(outcome))
}

fn tools(optimization: Optimization) -> anyhow::Result<Tools> {
    let tool = |variable: &str, usual: &str| -> anyhow::Result<Vec<String>> {
        let named = std::env::var(variable).ok().filter(|variable| !variable.trim().is_empty());
        let named = named.unwrap_or_else(|| usual.to_owned());
        match shlex::split(&named) {
            Some(words) if !words.is_empty() => Ok(words),
            _ => bail!("${variable} is no command: `{named}`"),
        }
    };
    Ok(Tools { c: tool("CC", "cc")?, cxx: tool("CXX", "c++")?, optimization })
}

/// Returns the steps whose outputs are missing or out of date.
fn stale<'s>(steps: &[&'s Step]) -> Vec<&'s Step> {
    let mut contents = Contents::new(&SystemDisk);
    let steps = steps.iter().copied();
    steps.filter(|step| !step.is_fresh(&mut contents)).collect()
}

/// Returns true if the output of every step is up to date. A shared object alone says nothing about its
/// sources: the objects of a source that does not compile are still those of the text before.
fn are_fresh<'s>(steps: impl IntoIterator<Item = &'s Step>) -> bool {
    let mut contents = Contents::new(&SystemDisk);
    steps.into_iter().all(|step| step.is_fresh(&mut contents))
}

/// `1 file`, `3 files`
fn files(count: usize) -> String {
    match count {
        1 => "1 file".to_owned(),
        _ => format!("{count} files"),
    }
}

struct Builder<'b> {
    folder: &'b Folder,
    tools: &'b Tools,
    packages: &'b PackageConfig,
    jobs: Option<usize>,
    interrupt: &'b Interrupt,
}

struct Built {
    diagnostics: Vec<Diagnostic>,
    /// True if the shared object exists and contains all codels.
    whole: bool,
    /// True if each codel has a function.
    complete: bool,
}

/// The shared objects of a folder, for hosts.
pub(crate) struct BuiltObjects {
    /// By component; only complete objects.
    pub(crate) hosted: Vec<SharedObject>,
    /// Messages of compilers.
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// True if something does not compile.
    pub(crate) failed: bool,
}

/// Builds the shared objects for hosts, from a folder with sources.
///
/// An interrupted build has failed.
pub(crate) fn hosts(
    folder: &Folder,
    packages: &PackageConfig,
    optimization: Optimization,
    interrupt: &Interrupt,
) -> anyhow::Result<BuiltObjects> {
    let builder = Builder { folder, tools: &tools(optimization)?, packages, jobs: None, interrupt };
    builder.hosts()
}

/// The build of a folder.
struct FolderPlan {
    plan: Plan,
    packages: Packages,
    place: Utf8PathBuf,
}

impl Builder<'_> {
    fn hosts(&self) -> anyhow::Result<BuiltObjects> {
        let FolderPlan { plan, packages, place } = self.plan()?;
        let shown = session::display(&self.folder.specification);
        let hosted = hosted(self.folder, &plan, &place, self.tools, &packages);
        let hosted = hosted
            .map_err(anyhow::Error::msg)
            .with_context(|| format!("`{shown}` cannot be run with its codels"))?;
        let glue = hosted.iter().map(|shared_object| &shared_object.glue);
        let glue = glue.map(|glue| report::new_content(&glue.path, &glue.text));
        write_changed(glue.collect(), &self.workspace())?;
        let compile =
            plan.compile.iter().chain(hosted.iter().map(|shared_object| &shared_object.compile));
        let links: Vec<&Step> = hosted.iter().map(|shared_object| &shared_object.link).collect();
        let compile: Vec<&Step> = compile.collect();
        let stale = stale(&compile).len();
        if stale > 0 {
            report::note(&format!("compiling {} of `{shown}`", files(stale)));
        }
        let (said, other) = self.compile(&compile, &links)?;
        let diagnostics = self.diagnostics(&said);
        for text in &other {
            report::note(text);
        }
        Ok(BuiltObjects {
            failed: !are_fresh(compile.iter().chain(&links).copied()),
            diagnostics,
            hosted,
        })
    }

    fn plan(&self) -> anyhow::Result<FolderPlan> {
        let specification = &self.folder.specification;
        let shown = session::display(specification);
        let wanted = self.packages(&shown)?;
        let words = |question| {
            let words = vfs::words(self.packages, question, &wanted);
            words.map_err(anyhow::Error::msg).with_context(|| format!("`{shown}` is not compiled"))
        };
        let packages = Packages { compile: words("--cflags")?, link: words("--libs")? };
        let beside = specification.parent().unwrap_or(Utf8Path::new("."));
        let stem = specification.file_stem().unwrap_or_default();
        let place = beside.join(FOLDER).join(RUN).join(stem);
        let plan = build::plan(self.folder, &place, self.tools, &packages);
        let plan = plan
            .map_err(anyhow::Error::msg)
            .with_context(|| format!("`{shown}` is not compiled"))?;
        write_headers(&plan, &beside.join(FOLDER), &self.workspace())?;
        Ok(FolderPlan { plan, packages, place })
    }

    /// Returns the folder in which all files are written.
    fn workspace(&self) -> Utf8PathBuf {
        let specification = &self.folder.specification;
        session::workspace(specification.parent().unwrap_or(specification))
    }

    /// Returns the packages that are installed. Packages that only the specification requires may be missing.
    fn packages(&self, shown: &str) -> anyhow::Result<Vec<String>> {
        let required = build::packages(self.folder);
        let all = required.all();
        let flags = |packages: &[String]| vfs::words(self.packages, "--cflags", packages);
        if flags(&all).is_ok() {
            return Ok(all);
        }
        let mut wanted: Vec<String> = Vec::new();
        for codel in &required.codels {
            if flags(std::slice::from_ref(codel)).is_ok() {
                wanted.push(codel.clone());
                continue;
            }
            let names = packages::names(codel);
            for name in &names {
                let one = match names.len() {
                    1 => codel.clone(),
                    _ => (*name).to_owned(),
                };
                match flags(std::slice::from_ref(&one)) {
                    Ok(_) => wanted.push(one),
                    // The package contains only interfaces.
                    Err(_) if vfs::has_own_interfaces(name) => {}
                    Err(why) => bail!(
                        "`{shown}` is not compiled: its codels require the package `{one}`: {}; install {}",
                        why.trim_end().trim_end_matches('.'),
                        packages::advice(name)
                    ),
                }
            }
        }
        let is_there = |text: &&String| flags(std::slice::from_ref(*text)).is_ok();
        let (there, missing): (Vec<&String>, Vec<&String>) =
            required.specification.iter().partition(is_there);
        if !missing.is_empty() {
            let missing: Vec<String> = missing.iter().map(|text| format!("`{text}`")).collect();
            report::note(&format!(
                "not installed: {}; the codels of `{shown}` are compiled without, because only the \
                 specification requires it",
                missing.join(", ")
            ));
        }
        Ok(there.into_iter().cloned().chain(wanted).collect())
    }

    fn build(&self) -> anyhow::Result<Built> {
        let specification = &self.folder.specification;
        let shown = session::display(specification);
        let codels = &self.folder.sources.folder;
        if !self.folder.unit.accepted() {
            // A model with errors has gaps, which a compiler would report as other errors.
            bail!("`{shown}` is not compiled: it has errors; `dotgen check {shown}` shows them");
        }
        if self.folder.sources.sources.is_empty() {
            report::note(&format!(
                "`{shown}` has no sources in `{}`; `dotgen codels stub {shown}` writes them",
                session::display(codels)
            ));
            return Ok(Built { diagnostics: Vec::new(), whole: false, complete: false });
        }
        let plan = self.plan()?.plan;
        if !plan.missing.is_empty() {
            report::note(&format!(
                "`{shown}` has codels without a function: {}; `dotgen codels stub {shown}` writes them",
                plan.missing.join(", ")
            ));
        }
        let steps: Vec<&Step> = plan.compile.iter().collect();
        let (stale, linked) = (stale(&steps).len(), !are_fresh([&plan.link]));
        let (said, other) = self.compile(&steps, &[&plan.link])?;
        let diagnostics = self.diagnostics(&said);
        for text in &other {
            report::note(text);
        }
        let failed = |diagnostic: &Diagnostic| diagnostic.severity == Severity::Error;
        let made = are_fresh(plan.compile.iter().chain([&plan.link]));
        if made {
            let library = session::display(&plan.link.output);
            report::note(&match (stale, linked) {
                (0, false) => format!("`{library}` is up to date"),
                (0, true) => format!("linked `{library}`"),
                (count, _) => format!("compiled {} into `{library}`", files(count)),
            });
        } else if !diagnostics.iter().any(failed) && other.is_empty() {
            bail!("`{shown}` does not compile, and the compiler does not say why");
        }
        let complete = plan.missing.is_empty();
        Ok(Built { whole: made && complete, complete, diagnostics })
    }

    /// Runs the necessary steps. Returns the messages with places, and other errors.
    fn compile(
        &self,
        steps: &[&Step],
        links: &[&Step],
    ) -> anyhow::Result<(Vec<CompilerMessage>, Vec<String>)> {
        let todo = stale(steps);
        let doing = format!("compiling {}", session::display(&self.folder.specification));
        let done = AtomicUsize::new(0);
        let jobs = self
            .jobs
            .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
        let next = AtomicUsize::new(0);
        // A compiler that is ended leaves its temporary files, in this folder.
        let temporary = process::System.folder(None)?;
        let (place, interrupt) = (temporary.path(), self.interrupt);
        let workspace = self.workspace();
        let work = |step: &Step| perform(step, &workspace, place, interrupt);
        let results = Mutex::new(Vec::new());
        let compile = |tell: &(dyn Fn(Activity) + Sync)| {
            let told = |done: usize| {
                let how_far = format!("{done} of {}", files(todo.len()));
                tell(Activity { what: doing.clone(), how_far });
            };
            told(0);
            while let Some(step) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                if interrupt.is_raised() {
                    break;
                }
                let result = work(step);
                told(done.fetch_add(1, Ordering::Relaxed) + 1);
                let mut results = results.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                results.push((&step.output, result));
            }
        };
        progress::during(None, &doing, |tell| {
            std::thread::scope(|scope| {
                for _ in 0..jobs.min(todo.len()) {
                    scope.spawn(|| compile(tell));
                }
            });
        });
        let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        results.sort_by_key(|mutex| mutex.0);
        let (mut said, mut other) = (Vec::new(), Vec::new());
        let mut failed = false;
        for (_, result) in results {
            let (well, printed) = result?;
            failed |= !well;
            let (places, rest) = build::said(&printed);
            said.extend(places);
            other.extend(rest);
        }
        for link in links {
            if failed {
                // Built from another text than that on the disk.
                SystemDisk.remove(link.output.as_std_path());
                continue;
            }
            if interrupt.is_raised() || are_fresh([*link]) {
                continue;
            }
            let linking = format!("linking {}", session::display(&link.output));
            let (_, printed) = progress::during(None, &linking, |_| work(link))?;
            let (places, rest) = build::said(&printed);
            said.extend(places);
            other.extend(rest);
        }
        Ok((said, other))
    }

    /// Converts messages of compilers to diagnostics. Notes belong to the message before them.
    fn diagnostics(&self, said: &[CompilerMessage]) -> Vec<Diagnostic> {
        let expected = self.folder.expected();
        let mut out: Vec<Diagnostic> = Vec::new();
        for message in said {
            let path = vfs::normalize(&message.path);
            let text = Disk.read(&path).unwrap_or_default();
            let range = place(&text, message.line, message.column);
            let severity = match message.weight {
                MessageLevel::Error => Severity::Error,
                MessageLevel::Warning => Severity::Warning,
                MessageLevel::Note => {
                    if let Some(before) = out.last_mut() {
                        before.related.push(Related {
                            message: message.what.as_str().into(),
                            path,
                            range,
                        });
                    }
                    continue;
                }
            };
            let functions = codel_functions(&expected, &self.folder.sources, &path);
            let mut around =
                functions.iter().filter(|function| function.range.contains(&range.start));
            let codel = around.next().and_then(|function| function.codels.first());
            let mut diagnostic =
                Diagnostic::new(CODE, severity, message.what.as_str(), path, range);
            if let Some(&(component, codel)) = codel {
                let unit = &self.folder.unit;
                let codel = unit.spec.components[component].codel(codel);
                diagnostic.related.extend(unit.locations.locate(codel.src).map(|at| Related {
                    path: at.path,
                    range: at.range,
                    message: format!("the codel `{}` is declared here", codel.name).into(),
                }));
            }
            if !out.contains(&diagnostic) {
                out.push(diagnostic);
            }
        }
        out
    }
}

/// Writes changed headers only: an unchanged header keeps its time.
fn write_headers(plan: &Plan, folder: &Utf8Path, workspace: &Utf8Path) -> anyhow::Result<()> {
    let mut files: Vec<NewContent> = (plan.headers.iter())
        .map(|header| report::new_content(&header.path, &header.text))
        .collect();
    files.push(report::new_content(&folder.join(".gitignore"), IGNORED));
    write_changed(files, workspace)
}

fn write_changed(mut files: Vec<NewContent>, workspace: &Utf8Path) -> anyhow::Result<()> {
    let changed =
        |content: &NewContent| SystemDisk.read(&content.path).ok().as_ref() != Some(&content.bytes);
    files.retain(changed);
    report::write_files(files, &[workspace.to_owned()])
}

/// Runs a step. Returns true if its output was created, and the printed text.
fn perform(
    step: &Step,
    workspace: &Utf8Path,
    temporary: &Path,
    interrupt: &Interrupt,
) -> anyhow::Result<(bool, String)> {
    let within = [workspace.to_owned()];
    // Until the output is complete, the record is empty.
    report::write_files(vec![report::new_content(&step.record(), "")], &within)?;
    let before = step.before(&mut Contents::new(&SystemDisk));
    let (program, arguments) = step.command.split_first().context("a step runs a program")?;
    let arguments: Vec<OsString> = arguments.iter().map(Into::into).collect();
    // Messages are parsed, so their language is fixed.
    let environment =
        [("LC_ALL", "C".to_owned()), ("TMPDIR", temporary.to_string_lossy().into_owned())];
    let process = process::ask(program, arguments, &environment);
    let mut process = process.map_err(|error| match error.kind() {
        ErrorKind::NotFound => anyhow::anyhow!(
            "there is no compiler `{program}`; install one, or name another one in $CC and $CXX"
        ),
        _ => anyhow::Error::new(error).context(format!("cannot run `{program}`")),
    })?;
    let (status, printed) = process.wait_with_output_unless(&|| interrupt.is_raised())?;
    let printed = String::from_utf8_lossy(&printed).into_owned();
    let mut after = Contents::new(&SystemDisk);
    if status.success()
        && step.before(&mut after) == before
        && let Some(recorded) = step.recorded(&mut after)
    {
        report::write_files(vec![report::new_content(&step.record(), &recorded)], &within)?;
    }
    Ok((status.success(), printed))
}

/// Returns the range of the word at a line and a column, both from 1. A column beyond the line is its end.
fn place(text: &str, line: usize, column: usize) -> std::ops::Range<usize> {
    let mut start = 0;
    let mut lines = text.split_inclusive('\n');
    for line in lines.by_ref().take(line.saturating_sub(1)) {
        start += line.len();
    }
    let line = lines.next().unwrap_or_default().trim_end_matches(['\r', '\n']);
    let at = line.char_indices().nth(column.saturating_sub(1));
    let at = at.map_or(line.len(), |(byte, _)| byte);
    let word =
        line[at..].chars().take_while(|character| character.is_alphanumeric() || *character == '_');
    let length: usize = word.map(char::len_utf8).sum();
    let length = length.max(line[at..].chars().next().map_or(0, char::len_utf8));
    start + at..start + at + length
}

#[cfg(test)]
mod tests {
    use super::place;

    #[test]
    fn a_place_is_a_word() {
        let text = "int é = 1;\r\nfoo_1(x);\n";
        assert_eq!(&text[place(text, 1, 5)], "é");
        assert_eq!(&text[place(text, 1, 7)], "=");
        assert_eq!(&text[place(text, 2, 1)], "foo_1");
        assert_eq!(place(text, 2, 99), text.len() - 1..text.len() - 1);
        assert_eq!(place(text, 99, 1), text.len()..text.len());
    }
}
