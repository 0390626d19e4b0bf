//! Running commands, with messages about each step and its duration.

use std::io::{BufRead, BufReader, IsTerminal};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, bail};

/// Announces a step: the time since the first step, the action, and the reason if it takes long.
pub fn step(what: &str) {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let seconds = START.elapsed().as_secs();
    let (minutes, seconds) = (seconds / 60, seconds % 60);
    if std::io::stderr().is_terminal() {
        eprintln!("\x1b[1m==> {minutes}:{seconds:02} {what}\x1b[0m");
    } else {
        eprintln!("==> {minutes}:{seconds:02} {what}");
    }
}

thread_local! {
    static OF: std::cell::Cell<&'static str> = const { std::cell::Cell::new("") };
}

/// From now on, lines of the commands of this thread begin with a text, because other threads print as well.
pub fn prefix(text: &'static str) {
    OF.set(text);
}

/// A command in `directory`, without standard input, so that it cannot wait for an answer.
pub fn command(directory: &Path, program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(directory).stdin(Stdio::null());
    command
}

/// True if builds lint.
static LINTS: AtomicBool = AtomicBool::new(false);

/// From now on, each cargo lints the crates of the workspace while it builds them: Clippy is the compiler, so
/// that lints need no second build. Its artifacts are separate from those of rustc.
pub fn lint_while_building() {
    LINTS.store(true, Ordering::Relaxed);
}

/// The cargo that runs xtask.
pub fn cargo(arguments: &[&str]) -> Command {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let mut cargo = command(crate::root(), &cargo, arguments);
    if LINTS.load(Ordering::Relaxed) {
        cargo.env("RUSTC_WORKSPACE_WRAPPER", "clippy-driver");
    }
    // `cargo run` sets it for xtask; the cargo below determines its own.
    cargo.env_remove("CARGO_MANIFEST_DIR");
    cargo
}

/// Runs a command to its end; its output goes to the terminal.
pub fn run(mut command: Command) -> Result<()> {
    let shown = show(&command);
    let started = Instant::now();
    let status = command.status().with_context(|| format!("cannot run {shown}"))?;
    if !status.success() {
        bail!("{shown}: {status}");
    }
    eprintln!("    {shown}: {:.1} s", started.elapsed().as_secs_f32());
    Ok(())
}

/// Runs a command to its end and returns its output, which is shown only after a failure.
pub fn capture(mut command: Command) -> Result<String> {
    let shown = show(&command);
    let started = Instant::now();
    let output = command.output().with_context(|| format!("cannot run {shown}"))?;
    if !output.status.success() {
        bail!(
            "{shown}: {}\n{}{}",
            output.status,
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
    }
    eprintln!("    {shown}: {:.1} s", started.elapsed().as_secs_f32());
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Runs a command to its end, shows its output at once, and passes every line of standard output to `line` as
/// well. Returns true if it succeeded.
pub fn watch(command: Command, mut line: impl FnMut(&str)) -> Result<bool> {
    let of = OF.get();
    lines(command, |text| {
        println!("{of}{text}");
        line(text);
    })
}

/// Runs a command to its end, and passes every line of standard output to `line` at once, without showing it.
/// Returns true if it succeeded.
pub fn lines(mut command: Command, mut line: impl FnMut(&str)) -> Result<bool> {
    let shown = show(&command);
    eprintln!("    {shown}");
    let mut child =
        command.stdout(Stdio::piped()).spawn().with_context(|| format!("cannot run {shown}"))?;
    if let Some(stdout) = child.stdout.take() {
        for text in BufReader::new(stdout).split(b'\n') {
            let text = text?;
            line(&String::from_utf8_lossy(&text));
        }
    }
    Ok(child.wait()?.success())
}

fn show(command: &Command) -> String {
    let mut shown = Path::new(command.get_program())
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    for argument in command.get_args().take(6) {
        shown.push(' ');
        shown.push_str(&argument.to_string_lossy());
    }
    shown
}
