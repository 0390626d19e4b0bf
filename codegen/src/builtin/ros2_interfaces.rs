//! `ros2-interfaces`: ROS 2 packages with the types of components.

use super::arguments::{self, OptionFlow};
use super::render::Files;
use crate::compiler::Compiler;
use crate::environment::Environment;
use crate::lang::Anchor;
use crate::options::Options as General;
use crate::template::{Failure, Output};

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
    super::with_output(NAME, general, env, |env, output| {
        write(args, general, compiler, env, output)
    })
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
    let verbose = general.verbose.then(|| NAME.to_owned());
    let mut files = Files::new(env.console, verbose, &*env.processes)?;
    for (path, text) in &packages.files {
        let written = output.commit(path, "", text, &mut files);
        written.map_err(Failure::into_text)?;
    }
    Ok(0)
}
