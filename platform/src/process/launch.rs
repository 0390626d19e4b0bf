//! `dotgen confined`: the process that becomes a program. Not for users.
//!
//! It ends with its parent, limits and confines itself, and becomes the program.

use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Duration;

use dotgen_codegen::process::{Access, Program, Resources};

use super::{COMMAND, confine, watcher};

const RENDER: &str = "render";

/// Exit status of a shell that cannot run a command; the other constant is for a command that is not found.
const CANNOT_RUN: u8 = 126;
const NOT_FOUND: u8 = 127;

/// The arguments that start a program.
pub(super) fn arguments(program: &Program) -> Vec<OsString> {
    let mut out = vec![COMMAND.into(), "--parent".into(), std::process::id().to_string().into()];
    limits(&mut out, program.resources);
    if let Some(access) = &program.access {
        out.push("--confine".into());
        for (option, paths) in [("--read", &access.read), ("--write", &access.write)] {
            for path in paths {
                out.extend([option.into(), path.into()]);
            }
        }
    }
    out.push("--".into());
    out.push(program.path.clone().into());
    out.extend(program.arguments.iter().cloned());
    out
}

/// The arguments that start the renderer of texts.
pub(super) fn renderer_arguments(resources: Resources) -> Vec<OsString> {
    let mut out = vec![COMMAND.into(), "--parent".into(), std::process::id().to_string().into()];
    limits(&mut out, resources);
    out.extend(["--confine".into(), "--".into(), RENDER.into()]);
    out
}

fn limits(out: &mut Vec<OsString>, resources: Resources) {
    let time = resources.time.map(|time| time.as_secs());
    for (option, value) in
        [("--memory", resources.memory), ("--time", time), ("--file", resources.file)]
    {
        if let Some(value) = value {
            out.extend([option.into(), value.to_string().into()]);
        }
    }
}

/// The parsed arguments.
#[derive(Debug, Default, PartialEq, Eq)]
struct LaunchArguments {
    parent: Option<i32>,
    resources: Resources,
    access: Option<Access>,
    program: PathBuf,
    arguments: Vec<OsString>,
}

impl LaunchArguments {
    fn read(words: &[OsString]) -> Option<LaunchArguments> {
        let mut order = LaunchArguments::default();
        let mut words = words.iter();
        loop {
            let option = words.next()?.to_str()?;
            if option == "--" {
                break;
            }
            if option == "--confine" {
                order.access.get_or_insert_default();
                continue;
            }
            let value = words.next()?;
            let number = || value.to_str()?.parse::<u64>().ok();
            match option {
                "--parent" => order.parent = i32::try_from(number()?).ok(),
                "--memory" => order.resources.memory = Some(number()?),
                "--time" => order.resources.time = Some(Duration::from_secs(number()?)),
                "--file" => order.resources.file = Some(number()?),
                "--read" => order.access.get_or_insert_default().read.push(value.into()),
                "--write" => order.access.get_or_insert_default().write.push(value.into()),
                _ => return None,
            }
        }
        order.program = words.next()?.into();
        order.arguments = words.cloned().collect();
        Some(order)
    }
}

/// Runs the subcommand if it is on the command line.
pub fn intercept() -> Option<ExitCode> {
    let words: Vec<OsString> = std::env::args_os().collect();
    let [own, command, words @ ..] = words.as_slice() else {
        return None;
    };
    // As `genom3`, this word is the name of a template.
    let stands_in = Path::new(own).file_stem() == Some(OsStr::new("genom3"));
    if command != COMMAND || stands_in {
        return None;
    }
    if words.first().map(OsString::as_os_str) == Some(OsStr::new(watcher::WORDS[1])) {
        watcher::serve(std::io::stdin().lock());
        return Some(ExitCode::SUCCESS);
    }
    let Some(order) = LaunchArguments::read(words) else {
        say("`dotgen confined` is what dotgen starts programs through; it is not for people");
        return Some(ExitCode::from(2));
    };
    Some(match carry_out(&order) {
        Ok(status) => status,
        Err((status, message)) => {
            say(&message);
            ExitCode::from(status)
        }
    })
}

fn say(message: &str) {
    // Fails if the error output is closed.
    let _ = writeln!(std::io::stderr(), "dotgen: {message}");
}

fn carry_out(order: &LaunchArguments) -> Result<ExitCode, (u8, String)> {
    let refused =
        |error: std::io::Error| (CANNOT_RUN, format!("cannot confine a program: {error}"));
    if let Some(parent) = order.parent {
        die_with_parent(parent).map_err(refused)?;
    }
    let renders = order.program.as_os_str() == RENDER;
    confine::limit(&order.resources).map_err(refused)?;
    if let Some(access) = &order.access {
        let program = (!renders).then_some(&*order.program);
        confine::confine(access, program).map_err(refused)?;
    }
    if renders {
        let input = std::io::BufReader::new(std::io::stdin());
        return match dotgen_codegen::builtin::serve_renderer(input, std::io::stdout()) {
            Ok(()) => Ok(ExitCode::SUCCESS),
            Err(message) => Err((1, message)),
        };
    }
    let error = become_program(Command::new(&order.program).args(&order.arguments));
    let name = order.program.display();
    Err(match error.kind() {
        std::io::ErrorKind::NotFound => (NOT_FOUND, format!("cannot start {name}: {error}")),
        std::io::ErrorKind::PermissionDenied if order.access.is_some() => {
            let why = "a confined template is run by tclsh itself, not by a script that starts it";
            (CANNOT_RUN, format!("cannot start {name}: {error}; {why}"))
        }
        _ => (CANNOT_RUN, format!("cannot start {name}: {error}")),
    })
}

/// Makes the system end this process when its parent ends. Remains in force after `exec`.
#[cfg(target_os = "linux")]
fn die_with_parent(parent: i32) -> std::io::Result<()> {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};
    set_parent_process_death_signal(Some(Signal::KILL))?;
    // The parent may have ended before the call.
    if getppid().map(|process| process.as_raw_nonzero().get()) != Some(parent) {
        return Err(std::io::Error::other("its parent has ended"));
    }
    Ok(())
}

/// Other systems rely on the helper.
#[cfg(not(target_os = "linux"))]
fn die_with_parent(_: i32) -> std::io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn become_program(command: &mut Command) -> std::io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Systems on which a process cannot become another program: it starts the program and waits.
#[cfg(not(unix))]
fn become_program(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotgen_codegen::process::Channels;

    #[test]
    fn words_say_what_was_wanted() {
        let program = Program {
            path: "/bin/x".into(),
            arguments: vec!["--read".into(), "--".into()],
            directory: PathBuf::new(),
            channels: Channels::Pipes,
            resources: Resources {
                memory: Some(5),
                time: Some(Duration::from_secs(6)),
                file: None,
            },
            access: Some(Access { read: vec!["/a".into(), "-b".into()], write: vec!["/c".into()] }),
            outlives: Duration::ZERO,
        };
        let words = arguments(&program);
        assert_eq!(words[0], COMMAND);
        let order = LaunchArguments::read(&words[1..]).expect("it can be read");
        assert_eq!(order.parent, i32::try_from(std::process::id()).ok());
        assert_eq!(order.resources, program.resources);
        assert_eq!(order.access, program.access);
        assert_eq!((order.program, order.arguments), (program.path, program.arguments));
        for bad in
            [&["--read"][..], &["--memory", "x", "--", "p"], &["--other", "1", "--", "p"], &["--"]]
        {
            let words: Vec<OsString> = bad.iter().map(Into::into).collect();
            assert_eq!(LaunchArguments::read(&words), None, "{bad:?}");
        }
    }
}
