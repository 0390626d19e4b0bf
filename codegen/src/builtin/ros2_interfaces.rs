//! `ros2-interfaces`: ROS 2 packages with the types of components.

use std::sync::Arc;

use super::arguments::{self, OptionFlow};
use super::render::Files;
use crate::compiler::Compiler;
use crate::environment::Environment;
use crate::frontend::Frontend;
use crate::lang::Anchor;
use crate::options::Options as General;
use crate::template::{Failure, Output, OutputSink};

pub(super) const NAME: &str = "ros2-interfaces";

pub(super) const ABOUT: &str = "ROS 2 packages with the types of ports and services";

const USAGE: &str = "ros2-interfaces: write ROS 2 packages with the types of ports and services

Options:
  -o, -C, --directory=DIR  write the packages below DIR instead of the current directory
  -f, --force              overwrite files that exist
  -h, --help               print this help
";

pub(super) fn run(
    args: &[String],
    general: &General,
    compiler: &mut Compiler,
    env: &mut Environment<'_>,
) -> Result<i32, String> {
    let sink = std::mem::replace(&mut env.sink, OutputSink::Direct);
    let disk = Arc::clone(&env.disk);
    let mut output = Output::new(NAME.to_owned(), env.base.clone(), general.debug, disk, sink);
    output.confined = env.confined.clone().map(super::of_dotgen);
    let result = write(args, general, compiler, env, &mut output);
    let (sink, written) = output.finish(!matches!(result, Ok(0)));
    env.sink = sink;
    written.map_err(|error| error.to_string()).and(result)
}

fn write(
    args: &[String],
    general: &General,
    compiler: &mut Compiler,
    env: &mut Environment<'_>,
    output: &mut Output,
) -> Result<i32, String> {
    let mut directory = ".".to_owned();
    let console = &mut *env.console;
    let inputs = arguments::read(args, |option, value| {
        match option {
            "-o" | "-C" | "--directory" => directory = value()?,
            "-f" | "--force" => {
                let _ = output.modes.set("overwrite");
            }
            "-h" | "--help" => {
                console.out(USAGE.as_bytes());
                return Ok(OptionFlow::Stop);
            }
            other => return Err(arguments::unknown(other)),
        }
        Ok(OptionFlow::Go)
    })?;
    let Some(inputs) = inputs else {
        return Ok(0);
    };
    if inputs.is_empty() {
        console.out(USAGE.as_bytes());
        return Ok(2);
    }
    compiler
        .parse_files(&inputs, &mut |line| console.err(line))
        .map_err(|failure| failure.to_string())?;
    let compiled = compiler.compiled();
    let packages = (env.ros2)(&compiled.spec)?;
    for (src, refusal) in &packages.refused {
        let place = compiled.places.place(*src, Anchor::First);
        let place = place.map_or(String::new(), |place| format!("{}:{}: ", place.file, place.line));
        env.console.err(&format!("{place}{refusal}"));
    }
    output.dir = directory;
    let tmpdir = env
        .processes
        .folder(None)
        .map_err(|error| format!("cannot create a temporary directory: {error}"))?;
    let mut files = Files::new(
        env.console,
        tmpdir.path().to_owned(),
        general.verbose.then(|| NAME.to_owned()),
        &*env.processes,
    );
    for (path, text) in &packages.files {
        let written = output.commit(path, "", text, &mut files);
        written.map_err(Failure::into_text)?;
    }
    Ok(0)
}
