//! GenoM3's `skeleton` without Tcl: the same files with the same bytes.
//!
//! Stubs are those of [`Stubs`]. The constant texts of the other files are read from the folder of the
//! template, see [`TemplateWriter`]. This module decides which values to insert, and how often.

mod build;
mod fill;
mod readme;

use std::path::Path;
use std::sync::Arc;

use dotgen_analysis::model::{CodelKind, ComponentKind};
use dotgen_analysis::release::{Change, Release};
use rustc_hash::FxHashMap;

use super::render::Files;
use crate::codels::expected::Expected;
use crate::codels::stub::{NewFile, StubOptions, Stubs};
use crate::compiler::Compiler;
use crate::disk::{Disk, Kind, normalize};
use crate::environment::Environment;
use crate::frontend::Frontend;
use crate::options::Options as General;
use crate::template::{Failure, Output, OutputSink, notice_of};
use fill::{Facts, TemplateWriter};

/// A call with only these options and files.
#[derive(Debug, Default, PartialEq, Eq)]
struct Call {
    /// `-l`
    language: Option<String>,
    /// `-C`
    directory: Option<String>,
    /// `-m`, `-u`
    merge: Option<String>,
    /// `-f`
    overwrite: bool,
    /// `-t`
    terse: bool,
    inputs: Vec<String>,
}

/// True for a path that Tcl and dotgen split in the same way, and that is not a pattern for either.
fn is_plain_path(path: &str) -> bool {
    let mut parts = path.split('/').enumerate();
    !path.is_empty()
        && !path.contains(['*', '?', '[', ']', '\\', '{', '}', '$', '"', ' ', '\t', '\n'])
        && !path.starts_with('~')
        && parts.all(|(at, part)| at == 0 || !matches!(part, "" | "."))
}

impl Call {
    /// Reads the arguments of a call. `None` if the Tcl template is needed: for questions about merging, for
    /// help, for options with `=`, for names of components and for errors.
    fn read(args: &[String], is_file: impl Fn(&str) -> bool) -> Option<Call> {
        let mut call = Call::default();
        let mut words = args.iter();
        while let Some(word) = words.next() {
            match word.as_str() {
                "-l" | "--language" => {
                    let language =
                        words.next().filter(|word| matches!(word.as_str(), "c" | "c++"))?;
                    call.language = Some(language.clone());
                }
                "-C" | "--directory" => {
                    call.directory = Some(words.next().filter(|word| is_plain_path(word))?.clone());
                }
                "-m" | "--merge" => {
                    let tool =
                        words.next().filter(|word| *word != "interactive" && !word.is_empty())?;
                    call.merge = Some(tool.clone());
                }
                "-u" => call.merge = Some("auto".into()),
                "-f" | "--force" => call.overwrite = true,
                "-t" | "--terse" => call.terse = true,
                option if option.starts_with('-') => return None,
                _ => {
                    let inputs = std::iter::once(word).chain(words);
                    call.inputs = inputs.cloned().collect();
                    let plain = |path: &String| is_plain_path(path) && is_file(path);
                    return call.inputs.iter().all(plain).then_some(call);
                }
            }
        }
        None
    }
}

struct ResultFile {
    path: String,
    permissions: &'static str,
    text: String,
}

/// Runs the template. `None` if the Tcl template is needed; nothing has then been printed or written.
pub(super) fn run(
    dir: &Path,
    args: &[String],
    release: Release,
    general: &General,
    mut compiler: Compiler,
    env: &mut Environment<'_>,
) -> Option<Result<i32, String>> {
    let folder = env.base.join(&general.directory);
    let is_file = |text: &str| {
        let found = env.disk.status(&folder.join(text));
        found.is_some_and(|status| status.kind == Kind::File)
    };
    let call = Call::read(args, is_file)?;
    let name = dir.file_name()?.to_str()?;
    let mut lines = Vec::new();
    compiler.parse_files(&call.inputs, &mut |line| lines.push(line.to_owned())).ok()?;
    let made = make(name, dir, &call, release, general, &compiler, env)?;
    if let Some(limit) = env.limits.output
        && made.iter().map(|file| file.text.len() as u64).sum::<u64>() > limit
    {
        return None;
    }
    let disk = Arc::clone(&env.disk);
    let sink = std::mem::replace(&mut env.sink, OutputSink::Direct);
    let mut output = Output::new(name.to_owned(), env.base.clone(), false, disk, sink);
    output.confined = env.confined.clone().map(super::of_dotgen);
    let set_up = set_up(&mut output, &call);
    let tmpdir = env.processes.folder(None);
    let (Ok(()), Ok(tmpdir)) = (set_up, tmpdir) else {
        env.sink = output.finish(true).0;
        return None;
    };
    for line in lines {
        env.console.err(&line);
    }
    output.dir = call.output_dir();
    let mut files = Files::new(&mut *env.console, tmpdir.path().to_owned(), None, &*env.processes);
    let mut result = Ok(0);
    for ResultFile { path, permissions, text } in made {
        match output.commit(&path, permissions, &text, &mut files) {
            Ok(()) => {}
            Err(failure) => {
                result = Err(failure.into_text());
                break;
            }
        }
    }
    // Files written before a failure remain, as with GenoM3.
    let (sink, written) = output.finish(false);
    env.sink = sink;
    Some(written.map_err(|error| error.to_string()).and(result))
}

/// Applies the options about existing files.
fn set_up(output: &mut Output, call: &Call) -> Result<(), Failure> {
    if let Some(tool) = &call.merge {
        output.set_merge_tool(tool)?;
        output.modes.set("merge-if-change")?;
    }
    if call.overwrite {
        output.modes.set("overwrite")?;
    }
    Ok(())
}

impl Call {
    /// The output directory: the requested one, or the folder of the first input.
    fn output_dir(&self) -> String {
        let of_first = || match self.inputs[0].rsplit_once('/') {
            Some(("", _)) => "/".to_owned(),
            Some((folder, _)) => folder.to_owned(),
            None => ".".to_owned(),
        };
        self.directory.clone().unwrap_or_else(of_first)
    }
}

/// All files, in order. `None` if the template would fail, or if it is needed for an error message.
fn make(
    name: &str,
    dir: &Path,
    call: &Call,
    release: Release,
    general: &General,
    compiler: &Compiler,
    env: &Environment<'_>,
) -> Option<Vec<ResultFile>> {
    let compiled = compiler.compiled();
    let folder = env.base.join(&general.directory);
    let facts = Facts::new(&compiled, name);
    let components = generated(&facts, call, release, &*env.disk, &env.base, &folder)?;
    let interface = language(&facts, &components, release)?;
    let notice = notice_of(&*env.disk, &folder, &call.inputs);
    let expected = components.iter().map(|component| Expected::new(&compiled.spec, *component));
    let expected: Vec<Expected<'_>> = expected.collect();
    let job = build::Job {
        facts: &facts,
        components: &components,
        expected: &expected,
        language: call.language.clone().unwrap_or(interface),
        terse: call.terse,
        newer: release.has(Change::PerComponentSkeletons),
        inputs: &call.inputs,
        cmdline: &general.cmdline,
        notice: notice.as_deref(),
    };
    let walk = |file: &str| TemplateWriter::read(&*env.disk, &dir.join(file));
    let mut made = Vec::new();
    let options = StubOptions {
        compile_as_cxx: job.language == "c++",
        notice: notice.clone(),
        ..StubOptions::default()
    };
    add_component_files(&job, &options, &walk, &mut made)?;
    if !call.terse {
        made.push(plain("README.adoc", readme::write(&job, walk("readme.adoc")?)?));
    }
    made.push(ResultFile {
        path: "bootstrap.sh".into(),
        permissions: "a+x",
        text: "#!/bin/sh\nautoreconf -vi\n".into(),
    });
    let mut add = |path: &str, text: String| made.push(plain(path, text));
    if !job.newer || job.has_component() {
        add("autoconf/ag_templates.m4", walk("ag_templates.m4")?.whole()?);
    }
    add("configure.ac", job.configure(walk("top.configure.ac")?)?);
    let idls = idls(&compiled.deps, call, &*env.disk, &env.base)?;
    add("Makefile.am", job.makefile(walk("top.Makefile.am")?, &idls)?);
    let makefile = job.makefile_of_codels(walk("codels.Makefile.am")?)?;
    add("codels/Makefile.am", makefile);
    Some(made)
}

/// Adds the stubs and packages of each component. A function is written once, even if several components use
/// it.
fn add_component_files(
    job: &build::Job<'_>,
    options: &StubOptions,
    walk: &dyn Fn(&str) -> Option<TemplateWriter>,
    made: &mut Vec<ResultFile>,
) -> Option<()> {
    let mut written = FxHashMap::default();
    for expected in job.expected {
        let component = expected.component;
        if lacks_yields(expected) {
            return None;
        }
        let stubs = Stubs::new(expected, options);
        for NewFile { path, text } in stubs.files(&mut written).ok()? {
            made.push(plain(path.into_string(), text));
        }
        let package = &expected.spec.components[component as usize].name;
        let file = walk("component.pc.in")?;
        let path = format!("{package}-genom3.pc.in");
        made.push(plain(path, job.package(file, component)?));
        let file = walk("component-uninstalled.pc.in")?;
        let path = format!("{package}-genom3-uninstalled.pc.in");
        made.push(plain(path, job.package(file, component)?));
    }
    Some(())
}

/// A file with the usual permissions.
fn plain(path: impl Into<String>, text: String) -> ResultFile {
    ResultFile { path: path.into(), permissions: "", text }
}

/// The components for which files are written: all, or those that the inputs themselves define, with
/// interfaces.
fn generated(
    facts: &Facts<'_>,
    call: &Call,
    release: Release,
    disk: &dyn Disk,
    base: &Path,
    folder: &Path,
) -> Option<Vec<u32>> {
    let of_kind = |kind: ComponentKind| {
        let all = (0..).zip(&facts.spec().components);
        all.filter(move |(_, component)| component.kind == kind).map(|(number, _)| number)
    };
    let components = of_kind(ComponentKind::Component);
    let found: Vec<u32> = if release.has(Change::PerComponentSkeletons) {
        let same = |path: &Path| disk.canonical(path).ok();
        let inputs: Vec<_> =
            call.inputs.iter().filter_map(|input| same(&folder.join(input))).collect();
        let defined = |number: &u32| {
            let file = facts.component(*number, &["loc", "file"]);
            let file = file.and_then(|file| same(&base.join(file)));
            file.is_some_and(|file| inputs.contains(&file))
        };
        let all = components.chain(of_kind(ComponentKind::Interface));
        all.filter(defined).collect()
    } else {
        components.collect()
    };
    (!found.is_empty()).then_some(found)
}

/// The language of the codels, if the template supports it.
fn language(facts: &Facts<'_>, components: &[u32], release: Release) -> Option<String> {
    let mut languages = Vec::new();
    if release.has(Change::PerComponentSkeletons) {
        for &component in components {
            languages.push(facts.component(component, &["lang"])?);
        }
        languages.dedup();
    } else if let [component] = components {
        languages.extend(facts.component(*component, &["lang"]));
    }
    let c = languages.iter().all(|language| language == "c") && languages.len() < 2;
    c.then(|| "c".to_owned())
}

/// True if a stub has no event to return, for which the template fails.
fn lacks_yields(expected: &Expected<'_>) -> bool {
    let component = expected.component();
    let of_tasks = component.tasks.iter().flat_map(|task| &task.codels);
    let of_services = component.services.iter().flat_map(|service| &service.codels);
    let machines = of_services.filter(|service| service.kind == CodelKind::Fsm);
    of_tasks.chain(machines).any(|task| task.yields.is_empty())
}

/// The files read that are below the output directory, relative to it.
fn idls(deps: &[String], call: &Call, disk: &dyn Disk, base: &Path) -> Option<Vec<String>> {
    let dir = normalize(disk, &base.join(call.output_dir()))?;
    let mut found = Vec::new();
    for file in deps {
        let file = normalize(disk, Path::new(file))?;
        if let Ok(inside) = file.strip_prefix(&dir)
            && inside.file_name().is_some()
        {
            found.push(inside.to_str()?.to_owned());
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(args: &[&str]) -> Option<Call> {
        let args: Vec<String> = args.iter().map(|argument| (*argument).to_owned()).collect();
        Call::read(&args, |text| text.ends_with(".gen"))
    }

    #[test]
    fn what_the_template_reads_in_its_own_way_is_left_to_it() {
        let call = read(&["-l", "c++", "-C", "out", "-u", "-t", "a.gen", "../b.gen"]).unwrap();
        assert_eq!(call.inputs, ["a.gen", "../b.gen"]);
        assert_eq!(call.merge.as_deref(), Some("auto"));
        assert_eq!(call.output_dir(), "out");
        assert_eq!(read(&["a/b.gen"]).unwrap().output_dir(), "a");
        assert_eq!(read(&["b.gen"]).unwrap().output_dir(), ".");
        for words in [
            &["-h"][..],
            &[],
            &["-l", "ada", "a.gen"],
            &["--language=c++", "a.gen"],
            &["-i", "a.gen"],
            &["-m", "interactive", "a.gen"],
            &["a.gen", "motor"],
            &["a.gen", "-x"],
            &["a//b.gen"],
            &["[x].gen"],
            &["-C", "~", "a.gen"],
        ] {
            assert_eq!(read(words), None, "{words:?}");
        }
    }
}
