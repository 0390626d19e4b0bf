//! The execution of a MiniJinja template: options, the data of its texts, and the result files.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use dotgen_analysis::model::{ComponentId, ComponentKind, Spec};
use dotgen_analysis::model_json;
use dotgen_analysis::release::Change;
use dotgen_syntax::encoding;
use minijinja::context;
use minijinja::value::Value;
use serde_json::Value as Json;

use super::arguments::{self, OptionFlow};
use super::expand::{Ask, Expand, Local, Remote};
use super::{Manifest, RunScope, Texts};
use crate::codels::expected::Expected;
use crate::codels::stub::{StubOptions, Stubs};
use crate::compiler::Compiler;
use crate::disk::Disk;
use crate::environment::Environment;
use crate::environment::Pictures;
use crate::options::Options as General;
use crate::process::{Folder, Processes};
use crate::template::console::Console;
use crate::template::output::{Environment as Surroundings, Rights};
use crate::template::{Failure, Output, notice_of, readable_files};

/// Options of all these templates.
struct Options {
    directory: Option<String>,
    language: Option<String>,
    terse: bool,
    inputs: Vec<String>,
}

pub(super) fn run(
    name: &str,
    texts: &Texts,
    args: &[String],
    general: &General,
    compiler: &mut Compiler,
    env: &mut Environment<'_>,
) -> Result<i32, String> {
    let manifest = texts.manifest(&*env.disk)?;
    super::with_output(name, general, env, |env, output| {
        if let Texts::Folder(_) = texts {
            output.confined.clone_from(&env.confined);
            output.rights = Rights::MiniJinja(env.allowed(general));
        }
        write(name, &manifest, texts, args, general, compiler, env, output)
    })
}

#[allow(clippy::too_many_arguments, reason = "the parts of a run")]
fn write(
    name: &str,
    manifest: &Manifest,
    texts: &Texts,
    args: &[String],
    general: &General,
    compiler: &mut Compiler,
    env: &mut Environment<'_>,
    output: &mut Output,
) -> Result<i32, String> {
    let Some(options) = options(name, manifest, args, output, env.console)? else {
        return Ok(0);
    };
    if options.inputs.is_empty() {
        env.console.out(usage(name, manifest).as_bytes());
        return Ok(2);
    }
    let console = &mut *env.console;
    compiler
        .parse_files(&options.inputs, &mut |line| console.err(line))
        .map_err(|failure| failure.to_string())?;
    output.dir = match &options.directory {
        Some(directory) => directory.clone(),
        None => parent(&options.inputs[0]),
    };
    let folder = env.base.join(&general.directory);
    let notice = notice_of(&*env.disk, &folder, &options.inputs).unwrap_or_default();
    let run = Data::new(&*env.disk, compiler, &options, notice, &output.dir, &output.base)?;
    let mut expander = expander(&run, texts, env)?;
    let verbose = general.verbose.then(|| name.to_owned());
    let mut files = Files::new(env.console, verbose, &*env.processes)?;
    let limit = env.limits.output.unwrap_or(u64::MAX);
    let mut written = 0;
    for rule in &manifest.files {
        if options.terse && !rule.terse {
            continue;
        }
        let source = texts.read(&*env.disk, &rule.source)?;
        for data in run.each(rule.each) {
            let path = expander.expand(&rule.path, &rule.path, &data)?;
            check_result(&path, texts, output)?;
            let text = expander.expand(&rule.source, &source, &data)?;
            let text = encoding::latin1(&text);
            written += text.len() as u64;
            if written > limit {
                return Err(format!("stopped: more than {} MiB", limit >> 20));
            }
            output
                .commit(&path, &rule.permissions, &text, &mut files)
                .map_err(Failure::into_text)?;
        }
    }
    Ok(0)
}

/// The expander of a template: in this process for templates of dotgen, in a confined one for others.
fn expander(run: &Data, texts: &Texts, env: &Environment<'_>) -> Result<Box<dyn Expand>, String> {
    let spec = Arc::clone(&run.spec);
    let pictures = Arc::clone(&env.pictures);
    let ask: Arc<Ask> =
        Arc::new(move |function, arguments| ask(&spec, &*pictures, function, arguments));
    if let Texts::Folder(_) = texts {
        let remote = Remote::start(&*env.processes, &env.limits, &run.shared, Arc::clone(&ask))?;
        if let Some(remote) = remote {
            return Ok(Box::new(remote));
        }
    }
    let shared = run.shared.clone();
    Ok(Box::new(Local { shared, ask }))
}

/// Answers the function calls of texts.
fn ask(
    spec: &Spec,
    pictures: &Pictures,
    function: &str,
    arguments: &[String],
) -> Result<String, String> {
    match (function, arguments) {
        ("diagram", [component, owner, form]) => pictures(spec, component, owner, form),
        ("json_schema", [component]) => {
            let schema =
                named(spec, component).map(|component| super::json_schema::schema(spec, component));
            Ok(schema.map(|schema| format!("{schema:#}")).unwrap_or_default())
        }
        ("python_stub", [component]) => {
            let stub = named(spec, component).map(|component| super::python::stub(spec, component));
            Ok(stub.unwrap_or_default())
        }
        _ => Err(format!("there is no function {function} of {} arguments", arguments.len())),
    }
}

fn named<'s>(spec: &'s Spec, component: &str) -> Option<&'s dotgen_analysis::model::Component> {
    spec.components.iter().find(|candidate| candidate.name == component)
}

/// Checks that a result is below the output directory, because the template may not be trusted.
fn check_result(path: &str, texts: &Texts, output: &Output) -> Result<(), String> {
    let inside = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    let plain = !path.is_empty() && Path::new(path).components().all(inside);
    let folder = output.base.join(if output.dir.is_empty() { "." } else { &output.dir });
    let linked = matches!(texts, Texts::Folder(_))
        && !readable_files::is_below(
            &*output.disk,
            &folder.join(path),
            std::slice::from_ref(&folder),
        );
    if plain && !linked {
        Ok(())
    } else {
        Err(format!(
            "template.toml: the path \"{path}\" of a result is not below the output directory"
        ))
    }
}

fn parent(path: &str) -> String {
    let parent = Path::new(path).parent().map(|parent| parent.display().to_string());
    parent.filter(|parent| !parent.is_empty()).unwrap_or_else(|| ".".into())
}

fn usage(name: &str, manifest: &Manifest) -> String {
    format!(
        "{name}: {}

Options:
  -C, --directory=DIR  write below DIR instead of the folder of the first file
  -l, --language=c++   compile C codels as C++
  -m, --merge=TOOL     merge files that exist: interactive, auto, or a program
  -i                   the same as -m interactive
  -u                   the same as -m auto
  -f, --force          overwrite files that exist
  -t, --terse          leave out documentation
  -h, --help           print this help
",
        manifest.about
    )
}

/// Reads the options; `None` if they ask for help.
fn options(
    name: &str,
    manifest: &Manifest,
    args: &[String],
    output: &mut Output,
    console: &mut dyn Console,
) -> Result<Option<Options>, String> {
    let mut options = Options { directory: None, language: None, terse: false, inputs: Vec::new() };
    let merge = |output: &mut Output, tool: &str| {
        output.set_merge_tool(tool).map_err(Failure::into_text)?;
        let _ = output.modes.set("merge-if-change");
        Ok::<(), String>(())
    };
    let files = arguments::read(args, |option, value| {
        match option {
            "-C" | "--directory" => options.directory = Some(value()?),
            "-l" | "--language" => options.language = Some(value()?),
            "-m" | "--merge" => merge(output, &value()?)?,
            "-i" => merge(output, "interactive")?,
            "-u" => merge(output, "auto")?,
            "-f" | "--force" => {
                let _ = output.modes.set("overwrite");
            }
            "-t" | "--terse" => options.terse = true,
            "-h" | "--help" => {
                console.out(usage(name, manifest).as_bytes());
                return Ok(OptionFlow::Stop);
            }
            other => return Err(arguments::unknown(other)),
        }
        Ok(OptionFlow::Go)
    })?;
    Ok(files.map(|inputs| Options { inputs, ..options }))
}

/// The requirement on GenoM3 in build files if the specification has none; GenoM3 writes the same.
const LEAST_GENOM: &str = "genom3 >= 2.99.4";

/// A component that is not an interface.
type Regular = dotgen_analysis::model::Component;

/// The texts without repetitions.
fn unique<'t>(all: impl Iterator<Item = &'t String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for text in all {
        if !out.contains(text) {
            out.push(text.clone());
        }
    }
    out
}

/// The packages that components require, GenoM3 among them.
fn requirements(regular: &[(ComponentId, &Regular)]) -> Vec<String> {
    let mut requires = unique(regular.iter().flat_map(|(_, component)| &component.requires));
    let is_genom = |requirement: &String| requirement.starts_with("genom3 ");
    if !requires.iter().any(is_genom) {
        requires.insert(0, LEAST_GENOM.to_owned());
    }
    requires
}

/// The files of codels, each with the value of its component, and the names of the files of each component.
fn codel_files(
    spec: &Spec,
    regular: &[(ComponentId, &Regular)],
    values: &[Value],
    options: &Options,
    notice: &str,
) -> Result<(Vec<Value>, serde_json::Map<String, Json>), String> {
    let stub_options = StubOptions {
        compile_as_cxx: options.language.as_deref() == Some("c++"),
        notice: Some(notice.to_owned()).filter(|notice| !notice.is_empty()),
        ..StubOptions::default()
    };
    let mut codel_files = Vec::new();
    let mut names = serde_json::Map::new();
    for ((index, component), value) in std::iter::zip(regular, values) {
        let expected = Expected::new(spec, *index);
        let files =
            Stubs::new(&expected, &stub_options).all_files().map_err(|error| error.message)?;
        let own: Vec<Json> =
            files.iter().filter_map(|file| file.path.file_name().map(Json::from)).collect();
        names.insert(component.name.to_string(), own.into());
        for file in files {
            codel_files.push(context! {
                component => value.clone(),
                file => context! { path => file.path.to_string(), text => file.text },
            });
        }
    }
    Ok((codel_files, names))
}

/// The data of the texts.
struct Data {
    /// The shared data.
    shared: Value,
    components: Vec<Value>,
    codel_files: Vec<Value>,
    machines: Vec<Value>,
    /// The specification, for functions of texts.
    spec: Arc<Spec>,
}

impl Data {
    fn new(
        disk: &dyn Disk,
        compiler: &Compiler,
        options: &Options,
        notice: String,
        dir: &str,
        base: &Path,
    ) -> Result<Data, String> {
        let compiled = compiler.compiled();
        let spec = &*compiled.spec;
        let model = model_json::to_json(spec, None);
        let json = |name: &str| -> Json {
            let components = model["components"].as_array();
            let found = components.and_then(|all| all.iter().find(|json| json["name"] == name));
            found.cloned().unwrap_or_default()
        };
        let regular: Vec<(ComponentId, &Regular)> = spec
            .components
            .iter_enumerated()
            .filter(|(_, number)| number.kind == ComponentKind::Component)
            .collect();
        let values: Vec<Value> = regular
            .iter()
            .map(|(_, component)| Value::from_serialize(json(&component.name)))
            .collect();
        let (codel_files, names) = codel_files(spec, &regular, &values, options, &notice)?;
        let first = regular.first().map(|(_, component)| *component);
        let input = Path::new(&options.inputs[0]).file_name().unwrap_or_default();
        let below = disk.canonical(&base.join(dir)).unwrap_or_else(|_| dir.into());
        let inputs: Vec<String> = compiled
            .deps
            .iter()
            .filter_map(|dependency| Path::new(dependency).strip_prefix(&below).ok())
            .map(|path| path.display().to_string())
            .collect();
        let base = context! {
            model => Value::from_serialize(&model),
            name => first.map(|component| component.name.to_string()),
            release => first.and_then(|component| component.version.clone()),
            email => first.and_then(|component| component.email.clone()),
            requires => requirements(&regular),
            codels_requires => unique(regular.iter().flat_map(|(_, component)| &component.codels_requires)),
            input => input.to_string_lossy(),
            inputs,
            notice => notice,
            language => options.language.as_deref().unwrap_or("c"),
            terse => options.terse,
            version => spec.release.to_string(),
            package_variables => spec.release.has(Change::PackageVariables),
            codel_files => Value::from_serialize(&names),
        };
        let components = values.iter().map(|value| context! { component => value.clone() });
        let machines = std::iter::zip(&regular, &values).flat_map(|((_, component), value)| {
            component.machines().map(move |owner| {
                context! {
                    component => value.clone(),
                    owner => component.owner_name(owner).as_str(),
                }
            })
        });
        Ok(Data {
            shared: base,
            components: components.collect(),
            codel_files,
            machines: machines.collect(),
            spec: Arc::clone(&compiled.spec),
        })
    }

    /// The additional data of the texts of a rule, one after the other.
    fn each(&self, each: RunScope) -> Vec<Value> {
        let own = match each {
            RunScope::Run => return vec![context! {}],
            RunScope::Component => &self.components,
            RunScope::CodelFile => &self.codel_files,
            RunScope::StateMachine => &self.machines,
        };
        own.clone()
    }
}

/// The channels and temporary files of a run.
pub(super) struct Files<'a> {
    console: &'a mut dyn Console,
    tmpdir: Box<dyn Folder>,
    count: u32,
    /// Prefix of messages, if they are printed.
    verbose: Option<String>,
    processes: &'a dyn Processes,
}

impl<'a> Files<'a> {
    /// Messages begin with `verbose`; without it, none are printed.
    pub(super) fn new(
        console: &'a mut dyn Console,
        verbose: Option<String>,
        processes: &'a dyn Processes,
    ) -> Result<Files<'a>, String> {
        let tmpdir = processes
            .folder(None)
            .map_err(|error| format!("cannot create a temporary directory: {error}"))?;
        Ok(Files { console, tmpdir, count: 0, verbose, processes })
    }
}

impl Surroundings for Files<'_> {
    fn console(&mut self) -> &mut dyn Console {
        &mut *self.console
    }

    fn temporary(&mut self) -> PathBuf {
        self.count += 1;
        self.tmpdir.path().join(format!("file{}", self.count))
    }

    fn format_time(&mut self, time: SystemTime) -> String {
        let seconds = time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
        format!("@{seconds}")
    }

    fn processes(&self) -> &dyn Processes {
        self.processes
    }

    fn message(&mut self, text: &str) {
        if let Some(name) = &self.verbose {
            self.console.err(&format!("{name}: {text}"));
        }
    }
}
