//! Compiler flags of packages: from pkg-config if it may be run and is installed, otherwise from `.pc` files
//! (`pkg_file`).

use std::ffi::OsString;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};

use dotgen_analysis::host::PackageFlags;
use dotgen_syntax::packages;

use super::PackageConfig;
use super::{interfaces, pkg_file};
use crate::process;

const PKG_CONFIG_TIMEOUT: Duration = Duration::from_secs(10);

/// Flags for all `arguments` (each `package`, or `package op version`) in one query. The included interfaces
/// replace packages that are not installed.
///
/// # Errors
/// A message for the user: the missing package, or the reason why the query failed.
pub fn query(config: &PackageConfig, arguments: &[String]) -> Result<PackageFlags, String> {
    let why = match asked(config, arguments) {
        Err(why) if config.own_interfaces => why,
        answer => return answer,
    };
    let (own, rest) = replaced(config, arguments);
    let folders: Vec<_> = own.iter().flat_map(|package| interfaces::folders_of(package)).collect();
    if folders.is_empty() {
        return Err(why);
    }
    let mut flags = if rest.is_empty() { PackageFlags::default() } else { asked(config, &rest)? };
    flags.include_dirs.extend(folders);
    flags.own = own;
    Ok(flags)
}

/// Packages that are not installed and have included interfaces, and the remaining arguments.
fn replaced(config: &PackageConfig, arguments: &[String]) -> (Vec<String>, Vec<String>) {
    let directories = pkg_file::search_path(&config.paths);
    let mut own = Vec::new();
    let mut rest = Vec::new();
    for argument in arguments {
        let names = packages::names(argument);
        let is_own =
            |name: &&str| interfaces::has(name) && pkg_file::version(&directories, name).is_none();
        if !names.is_empty() && names.iter().all(is_own) {
            own.extend(names.into_iter().map(str::to_owned));
        } else {
            rest.push(argument.clone());
        }
    }
    (own, rest)
}

/// The answer of the package tool.
fn asked(config: &PackageConfig, arguments: &[String]) -> Result<PackageFlags, String> {
    if config.may_run {
        match run(&pkg_file::tool(), &config.paths, "--cflags", arguments) {
            Err(Failure::NotInstalled) => {}
            Err(Failure::Said(message)) => return Err(message),
            Ok(output) => return Ok(parse_flags(&output)),
        }
    }
    let directories = pkg_file::search_path(&config.paths);
    pkg_file::cflags(&directories, arguments).map(|words| flags_of(&words))
}

/// The words that pkg-config prints for an option (`--cflags`, `--libs`) and packages.
///
/// # Errors
/// A message for the user: the missing package, or the reason why pkg-config cannot be run.
pub fn words(
    config: &PackageConfig,
    question: &str,
    arguments: &[String],
) -> Result<Vec<String>, String> {
    if arguments.is_empty() {
        return Ok(Vec::new());
    }
    let program = pkg_file::tool();
    match run(&program, &config.paths, question, arguments) {
        Ok(output) => shlex::split(&output).ok_or_else(|| {
            format!("`{program} {question}` answers with a quote that is not closed")
        }),
        Err(Failure::Said(message)) => Err(message),
        Err(Failure::NotInstalled) => Err(format!(
            "`{program}` is not installed, so the compiler flags are unknown for {}",
            arguments.join(", ")
        )),
    }
}

/// The version of a package, from a tool that may search more directories than [`pkg_file::search_path`]: a
/// script, or the program that the environment names. `None` for the plain tool, without starting a process.
pub(super) fn version(config: &PackageConfig, name: &str) -> Option<String> {
    let program = pkg_file::tool();
    let is_plain = program == pkg_file::TOOL
        && process::find_in_path(Path::new(pkg_file::TOOL))
            .is_none_or(|path| process::is_machine_code(&path));
    if !config.may_run || is_plain {
        return None;
    }
    let output = run(&program, &config.paths, "--modversion", &[name.to_owned()]).ok()?;
    first_line(&output).map(str::to_owned)
}

enum Failure {
    NotInstalled,
    Said(String),
}

fn run(
    program: &str,
    paths: &[Utf8PathBuf],
    question: &str,
    arguments: &[String],
) -> Result<String, Failure> {
    let mut words: Vec<OsString> = [question, "--print-errors", "--"].map(Into::into).to_vec();
    words.extend(arguments.iter().map(Into::into));
    let mut environment = Vec::new();
    if !paths.is_empty() {
        let mut path: Vec<String> = paths.iter().map(ToString::to_string).collect();
        path.extend(std::env::var("PKG_CONFIG_PATH").ok());
        environment.push(("PKG_CONFIG_PATH", path.join(":")));
    }
    let mut process =
        process::ask(program, words, &environment).map_err(|error| match error.kind() {
            ErrorKind::NotFound => Failure::NotInstalled,
            _ => Failure::Said(format!("cannot run `{program}`: {error}")),
        })?;
    let child = &mut process.child;

    // Both pipes are read on threads: a full pipe would block the child for ever.
    let (done, finished) = mpsc::channel();
    let drain = |pipe: Option<Box<dyn Read + Send>>| {
        let done = done.clone();
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            if let Some(mut pipe) = pipe {
                // A broken pipe ends the output; the text read before is used.
                let _ = pipe.read_to_end(&mut bytes);
            }
            let _ = done.send(());
            String::from_utf8_lossy(&bytes).into_owned()
        })
    };
    let stdout = drain(child.stdout.take().map(|stdout| Box::new(stdout) as Box<dyn Read + Send>));
    let stderr = drain(child.stderr.take().map(|stderr| Box::new(stderr) as Box<dyn Read + Send>));
    for _ in 0..2 {
        if finished.recv_timeout(PKG_CONFIG_TIMEOUT).is_err() {
            process.kill();
            let seconds = PKG_CONFIG_TIMEOUT.as_secs();
            return Err(Failure::Said(format!("`{program}` gave no answer within {seconds} s")));
        }
    }
    let status =
        process.wait().map_err(|error| Failure::Said(format!("`{program}` was lost: {error}")))?;
    let text = |thread: std::thread::JoinHandle<String>| thread.join().unwrap_or_default();
    if status.success() {
        return Ok(text(stdout));
    }
    let message = text(stderr);
    Err(Failure::Said(match first_line(&message) {
        Some(line) => line.to_owned(),
        None => format!("`{program}` failed ({status})"),
    }))
}

fn first_line(text: &str) -> Option<&str> {
    text.lines().map(str::trim).find(|line| !line.is_empty())
}

fn parse_flags(output: &str) -> PackageFlags {
    let words = shlex::split(output)
        .unwrap_or_else(|| output.split_whitespace().map(str::to_owned).collect());
    flags_of(&words)
}

fn flags_of(words: &[String]) -> PackageFlags {
    let mut flags = PackageFlags::default();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let mut argument = |flag: &str| -> Option<String> {
            let attached = word.strip_prefix(flag)?;
            if attached.is_empty() { words.next().cloned() } else { Some(attached.to_owned()) }
        };
        if let Some(directory) = argument("-I") {
            flags.include_dirs.push(super::normalize(Utf8Path::new(&directory)));
        } else if let Some(define) = argument("-D") {
            let (name, body) = define.split_once('=').unwrap_or((&define, "1"));
            flags.defines.push((name.into(), body.into()));
        }
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_may_be_attached_detached_and_quoted() {
        let flags = parse_flags(r#"-I/a -I /b/../c -DX -D Y=2 -DZ='"q r"' -pthread "-I/d e""#);
        assert_eq!(flags.include_dirs, ["/a", "/c", "/d e"]);
        let defines: Vec<_> = flags.defines.iter().map(|(n, b)| (&**n, &**b)).collect();
        assert_eq!(defines, [("X", "1"), ("Y", "2"), ("Z", "\"q r\"")]);
    }
}
