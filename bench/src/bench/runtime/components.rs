//! Components in folders of their own, and runs of them.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};
use serde_json::Value;

/// A component, or a scenario of two.
pub(super) struct Component {
    dotgen: PathBuf,
    folder: PathBuf,
    /// The specification or scenario, in the folder.
    file: String,
}

impl Component {
    /// Writes a component to a folder of its name.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub(super) fn new(
        dotgen: &Path,
        folder: &Path,
        specification: &str,
        source: &str,
    ) -> Result<Component> {
        let name = folder.file_name().context("a folder has a name")?;
        let name = name.to_string_lossy();
        let numbers = format!("{:?}", folder.join("numbers"));
        let codels = folder.join("codels");
        std::fs::create_dir_all(&codels)?;
        let file = format!("{name}.gen");
        std::fs::write(folder.join(&file), specification)?;
        std::fs::write(codels.join(format!("{name}.c")), source)?;
        let header = include_str!("stamp.h").replace("NUMBERS", &numbers);
        std::fs::write(codels.join("stamp.h"), header)?;
        Ok(Component { dotgen: dotgen.to_owned(), folder: folder.to_owned(), file })
    }

    /// Writes a scenario of a writer and a reader, next to the reader.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub(super) fn scenario(writer: &Component, reader: &Component) -> Result<Component> {
        let path = |component: &Component| component.folder.join(&component.file);
        let (from, to) = (path(writer), path(reader));
        let text = format!("scenario link {{\n  use {from:?};\n  use {to:?};\n}}\n");
        std::fs::write(reader.folder.join("link.scn"), text)?;
        Ok(Component {
            dotgen: reader.dotgen.clone(),
            folder: reader.folder.clone(),
            file: "link.scn".to_owned(),
        })
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The socket of runs.
    pub(super) fn socket(&self) -> PathBuf {
        self.folder.join("socket")
    }

    /// Returns the numbers that codels noted since the last call.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn numbers(&self) -> Result<Vec<u64>> {
        let path = self.folder.join("numbers");
        if !path.exists() {
            return Ok(Vec::new());
        }
        let numbers = numbers(&path)?;
        std::fs::remove_file(&path)?;
        Ok(numbers)
    }

    fn command(&self, seconds: f64, more: &[&str]) -> Command {
        let mut command = Command::new(&self.dotgen);
        command.current_dir(&self.folder).args(["run", &self.file]);
        command.args(["--clock", "real", "--bounds", "none", "--socket", "socket"]);
        command.args(["--format", "json"]).args(more);
        if seconds < f64::MAX {
            let micros = seconds * 1e6;
            command.arg("--until").arg(format!("{micros:.0}us"));
        }
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        command
    }

    /// Runs it for a time and returns its report.
    ///
    /// # Errors
    /// It cannot be run.
    pub(super) fn run(&self, seconds: f64, more: &[&str]) -> Result<Value> {
        let output = self.command(seconds, more).output();
        let output = output.context("cannot run dotgen")?;
        // 1: a check of the scenario was violated, for example a deadline.
        if !matches!(output.status.code(), Some(0 | 1)) {
            let errors = String::from_utf8_lossy(&output.stderr);
            bail!("{}: {}\n{errors}", self.file, output.status);
        }
        serde_json::from_slice(&output.stdout).context("dotgen wrote no JSON")
    }

    /// Starts a run and waits until it listens. It ends when the result is dropped.
    ///
    /// # Errors
    /// It ends before it listens.
    pub(super) fn start(&self, seconds: f64, more: &[&str]) -> Result<Running> {
        let mut command = self.command(seconds, more);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut running = Running(command.spawn().context("cannot run dotgen")?);
        let errors = running.0.stderr.take().context("it is piped")?;
        let mut lines = BufReader::new(errors).lines().map_while(Result::ok);
        let mut before = Vec::new();
        for line in lines.by_ref() {
            if line.contains("listening at") {
                // The pipe stays open and does not fill.
                std::thread::spawn(move || lines.for_each(drop));
                return Ok(running);
            }
            before.push(line);
        }
        bail!("{} has ended:\n{}", self.file, before.join("\n"))
    }
}

/// A run that is ended when it is dropped.
pub(super) struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Returns the numbers in a file, of 64 bits each.
///
/// # Errors
/// The file cannot be read.
pub(super) fn numbers(path: &Path) -> Result<Vec<u64>> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let (words, _) = bytes.as_chunks();
    Ok(words.iter().map(|word| u64::from_ne_bytes(*word)).collect())
}
