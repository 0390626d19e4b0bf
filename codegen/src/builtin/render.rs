//! Running a MiniJinja template: options, the data texts see, and writing the files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use dotgen_analysis::model::{ComponentKind, Spec};
use dotgen_analysis::model_json;
use dotgen_syntax::encoding;
use minijinja::value::Value;
use minijinja::{Environment as Jinja, context};
use serde_json::Value as Json;

use super::words::{self, Next};
use super::{Each, Manifest, Texts};
use crate::codels::expected::Expected;
use crate::codels::stub::{StubOptions, Stubs};
use crate::command::Pictures;
use crate::command::{Environment, Options as General};
use crate::compiler::Compiler;
use crate::disk::{Disk, Scratch};
use crate::frontend::Frontend;
use crate::template::console::Console;
use crate::template::output::Environment as Surroundings;
use crate::template::{Failure, Output, OutputSink, VERSION, notice, tcl};

/// Steps a text may take.
const FUEL: u64 = 50_000_000;

/// Options that all these templates take.
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
    let sink = std::mem::replace(&mut env.sink, OutputSink::Direct);
    let disk = Arc::clone(&env.disk);
    let mut output = Output::new(name.to_owned(), env.base.clone(), general.debug, disk, sink);
    let result = write(
        name,
        &manifest,
        texts,
        args,
        general,
        compiler,
        env,
        &mut output,
    );
    let (sink, written) = output.finish(!matches!(result, Ok(0)));
    env.sink = sink;
    written.map_err(|error| error.to_string()).and(result)
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
    let run = Data::new(&*env.disk, compiler, &options, &output.dir, &output.base)?;
    let scratch = (env.disk.scratch(None))
        .map_err(|error| format!("cannot create a temporary directory: {error}"))?;
    let mut files = Files {
        console: env.console,
        scratch,
        count: 0,
        verbose: general.verbose.then(|| name.to_owned()),
    };
    let pictures = Arc::clone(&env.pictures);
    let limit = env.limits.output.unwrap_or(u64::MAX);
    let mut written = 0;
    for rule in &manifest.files {
        if options.terse && !rule.terse {
            continue;
        }
        let source = texts.read(&*env.disk, &rule.source)?;
        for data in run.each(rule.each) {
            let path = render(&rule.path, &rule.path, &data, &run.spec, &pictures)?;
            let text = render(&rule.source, &source, &data, &run.spec, &pictures)?;
            let text = encoding::latin1(&text);
            written += text.len() as u64;
            if written > limit {
                return Err(format!("stopped: more than {} MiB", limit >> 20));
            }
            output
                .commit(&path, &rule.permissions, &text, &mut files)
                .map_err(|failure| match failure {
                    Failure::Error(text) | Failure::Fatal(text) | Failure::Stop(text) => text,
                })?;
        }
    }
    Ok(0)
}

fn parent(path: &str) -> String {
    let parent = Path::new(path).parent().map(|it| it.display().to_string());
    parent
        .filter(|it| !it.is_empty())
        .unwrap_or_else(|| ".".into())
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

/// Reads the options; `None` when help was asked for.
fn options(
    name: &str,
    manifest: &Manifest,
    args: &[String],
    output: &mut Output,
    console: &mut dyn Console,
) -> Result<Option<Options>, String> {
    let mut options = Options {
        directory: None,
        language: None,
        terse: false,
        inputs: Vec::new(),
    };
    let merge = |output: &mut Output, tool: String| {
        output.merge_tool = tool;
        let _ = output.modes.set("merge-if-change");
    };
    let files = words::read(args, |option, value| {
        match option {
            "-C" | "--directory" => options.directory = Some(value()?),
            "-l" | "--language" => options.language = Some(value()?),
            "-m" | "--merge" => merge(output, value()?),
            "-i" => merge(output, "interactive".into()),
            "-u" => merge(output, "auto".into()),
            "-f" | "--force" => {
                let _ = output.modes.set("overwrite");
            }
            "-t" | "--terse" => options.terse = true,
            "-h" | "--help" => {
                console.out(usage(name, manifest).as_bytes());
                return Ok(Next::Stop);
            }
            other => return Err(words::unknown(other)),
        }
        Ok(Next::Go)
    })?;
    Ok(files.map(|inputs| Options { inputs, ..options }))
}

/// What the texts see.
struct Data {
    base: Value,
    components: Vec<Value>,
    codel_files: Vec<Value>,
    machines: Vec<Value>,
    /// For what texts ask.
    spec: Arc<Spec>,
}

impl Data {
    fn new(
        disk: &dyn Disk,
        compiler: &Compiler,
        options: &Options,
        dir: &str,
        base: &Path,
    ) -> Result<Data, String> {
        let compiled = compiler.compiled();
        let spec = &*compiled.spec;
        let model = model_json::to_json(spec, None);
        let json = |name: &str| -> Json {
            let components = model["components"].as_array();
            let found = components.and_then(|all| all.iter().find(|it| it["name"] == name));
            found.cloned().unwrap_or_default()
        };
        let regular: Vec<(u32, &dotgen_analysis::model::Component)> = (0..)
            .zip(&spec.components)
            .filter(|(_, it)| it.kind == ComponentKind::Component)
            .collect();
        let mut all_notices = String::new();
        for input in &options.inputs {
            let text = disk.read(&base.join(input)).unwrap_or_default();
            all_notices += &notice(&tcl::decode(&text)).unwrap_or_default();
        }
        let stub_options = StubOptions {
            compile_as_cxx: options.language.as_deref() == Some("c++"),
            notice: Some(all_notices.clone()).filter(|it| !it.is_empty()),
            ..StubOptions::default()
        };
        let mut codel_files = Vec::new();
        let mut names = serde_json::Map::new();
        for (index, component) in &regular {
            let expected = Expected::new(spec, *index);
            let files = Stubs::new(&expected, &stub_options)
                .all_files()
                .map_err(|error| error.message)?;
            let own: Vec<Json> = files
                .iter()
                .filter_map(|it| it.path.file_name().map(Json::from))
                .collect();
            names.insert(component.name.to_string(), own.into());
            for file in files {
                codel_files.push(context! {
                    component => Value::from_serialize(json(&component.name)),
                    file => context! { path => file.path.to_string(), text => file.text },
                });
            }
        }
        let unique = |lists: Vec<&Vec<String>>| -> Vec<String> {
            let mut out: Vec<String> = Vec::new();
            for it in lists.into_iter().flatten() {
                if !out.contains(it) {
                    out.push(it.clone());
                }
            }
            out
        };
        let first = regular.first().map(|(_, it)| *it);
        let input = Path::new(&options.inputs[0])
            .file_name()
            .unwrap_or_default();
        let below = disk
            .canonical(&base.join(dir))
            .unwrap_or_else(|_| dir.into());
        let inputs: Vec<String> = compiled
            .deps
            .iter()
            .filter_map(|it| Path::new(it).strip_prefix(&below).ok())
            .map(|it| it.display().to_string())
            .collect();
        let base = context! {
            model => Value::from_serialize(&model),
            name => first.map(|it| it.name.to_string()),
            release => first.and_then(|it| it.version.clone()),
            email => first.and_then(|it| it.email.clone()),
            requires => unique(regular.iter().map(|(_, it)| &it.requires).collect()),
            codels_requires => unique(regular.iter().map(|(_, it)| &it.codels_requires).collect()),
            input => input.to_string_lossy(),
            inputs,
            notice => all_notices,
            language => options.language.as_deref().unwrap_or("c"),
            terse => options.terse,
            version => VERSION,
            codel_files => Value::from_serialize(&names),
        };
        let components = regular
            .iter()
            .map(|(_, it)| context! { component => Value::from_serialize(json(&it.name)) })
            .collect();
        let mut machines = Vec::new();
        for (_, component) in &regular {
            for owner in component.machines() {
                machines.push(context! {
                    component => Value::from_serialize(json(&component.name)),
                    owner => component.owner_name(owner).as_str(),
                });
            }
        }
        Ok(Data {
            base,
            components,
            codel_files,
            machines,
            spec: Arc::clone(&compiled.spec),
        })
    }

    fn each(&self, each: Each) -> Vec<Value> {
        let own = match each {
            Each::Run => return vec![self.base.clone()],
            Each::Component => &self.components,
            Each::CodelFile => &self.codel_files,
            Each::StateMachine => &self.machines,
        };
        let base = &self.base;
        own.iter()
            .map(|it| context! { ..it.clone(), ..base.clone() })
            .collect()
    }
}

/// Seconds in the unit people use.
fn duration(seconds: f64) -> String {
    let (number, unit) = match seconds {
        it if it >= 1.0 || it == 0.0 => (it, "s"),
        it if it >= 1e-3 => (it * 1e3, "ms"),
        it => (it * 1e6, "µs"),
    };
    let rounded = (number * 1e6).round() / 1e6;
    format!("{rounded} {unit}")
}

/// Expands a text; an error names it and the line.
fn render(
    name: &str,
    text: &str,
    data: &Value,
    spec: &Arc<Spec>,
    pictures: &Arc<Pictures>,
) -> Result<String, String> {
    let mut jinja = Jinja::new();
    let own = Arc::clone(spec);
    let pictures = Arc::clone(pictures);
    jinja.add_function(
        "diagram",
        move |component: &str, owner: &str, form: &str| {
            let drawn = pictures(&own, component, owner, form);
            drawn.map_err(|it| minijinja::Error::new(minijinja::ErrorKind::InvalidOperation, it))
        },
    );
    let own = Arc::clone(spec);
    jinja.add_function("json_schema", move |component: &str| {
        let found = own.components.iter().find(|it| it.name == component);
        let schema = found.map(|it| super::json_schema::schema(&own, it));
        schema.map(|it| format!("{it:#}")).unwrap_or_default()
    });
    jinja.add_filter("duration", duration);
    jinja.set_trim_blocks(true);
    jinja.set_lstrip_blocks(true);
    jinja.set_keep_trailing_newline(true);
    jinja.set_fuel(Some(FUEL));
    jinja.set_auto_escape_callback(|_| minijinja::AutoEscape::None);
    let explain = |error: minijinja::Error| {
        let line = error.line().map(|it| format!(":{it}")).unwrap_or_default();
        format!("{name}{line}: {error:#}")
    };
    let template = jinja.template_from_named_str(name, text).map_err(explain)?;
    template.render(data).map_err(explain)
}

/// The channels and temporary files of a run.
struct Files<'a> {
    console: &'a mut dyn Console,
    scratch: Box<dyn Scratch>,
    count: u32,
    /// Name for messages, when they are wanted.
    verbose: Option<String>,
}

impl Surroundings for Files<'_> {
    fn console(&mut self) -> &mut dyn Console {
        &mut *self.console
    }

    fn temporary(&mut self) -> (&dyn Scratch, PathBuf) {
        self.count += 1;
        let path = self.scratch.path().join(format!("file{}", self.count));
        (&*self.scratch, path)
    }

    fn format_time(&mut self, time: SystemTime) -> String {
        let seconds = time
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default()
            .as_secs();
        format!("@{seconds}")
    }

    fn message(&mut self, text: &str) {
        if let Some(name) = &self.verbose {
            self.console.err(&format!("{name}: {text}"));
        }
    }
}
