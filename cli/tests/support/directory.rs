//! A directory with files, and the program run in it.

#![allow(dead_code, reason = "no test file needs all of it")]

use std::path::Path;
use std::process::{Command, Output};

/// Variables of the environment that change what the program does.
pub(crate) const UNSET: [&str; 7] = [
    "PKG_CONFIG",
    "PKG_CONFIG_PATH",
    "PKG_CONFIG_LIBDIR",
    "DOTGEN_GENOM_RELEASE",
    "DOTGEN_BUILTIN_TEMPLATES",
    "GENOM_TMPL_PATH",
    "NO_COLOR",
];

/// A directory with files, in which the program runs.
pub(crate) struct Directory(tempfile::TempDir);

impl Directory {
    pub(crate) fn new(files: &[(&str, &str)]) -> Directory {
        let directory = Directory(tempfile::tempdir().expect("a directory"));
        for (name, text) in files {
            directory.write(name, text.as_bytes());
        }
        directory
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().expect("it has one")).expect("a directory");
        std::fs::write(path, bytes).expect("a file");
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program runs")
    }

    /// With a text on standard input.
    pub(crate) fn pipe(&self, arguments: &[&str], input: &[u8]) -> Output {
        use std::io::Write as _;
        use std::process::Stdio;
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        let mut stdin = child.stdin.take().expect("it is piped");
        // A program that refuses its arguments reads nothing.
        let _ = stdin.write_all(input);
        drop(stdin);
        child.wait_with_output().expect("the program runs")
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dotgen"));
        command.args(arguments).current_dir(self.0.path());
        for variable in UNSET {
            command.env_remove(variable);
        }
        command
    }

    /// The text of a file.
    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.path().join(name)).expect("a file")
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }
}

pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

pub(crate) fn status(output: &Output) -> i32 {
    output.status.code().expect("it exits")
}
