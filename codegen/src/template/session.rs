//! One run of a template: answers the questions of the interpreter.

mod questions;
mod sources;

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{SystemTime, UNIX_EPOCH};

use dotgen_syntax::encoding::latin1;

use super::api::Answer;
use super::console::Console;
use super::error_location::{self, Script};
use super::host::Host;
use super::object::Registry;
use super::output::{Environment, Output, posix};
use super::readable_files::ReadableFiles;
use super::{Failure, Run, TemplateResult, tcl};
use crate::compiler::Compiler;
use crate::frontend::Compiled;
use crate::lang::Language;
use crate::process::Processes;

/// The state of a run.
pub(super) struct TemplateRun<'a> {
    run: &'a Run<'a>,
    host: Host,
    compiler: &'a mut Compiler,
    console: &'a mut dyn Console,
    compiled: Compiled,
    registry: Rc<Registry>,
    /// Objects without commands yet, because the parse that added them failed.
    unannounced: Vec<String>,
    output: Output,
    tmpdir: PathBuf,
    /// The readable files, if the run is confined.
    reach: Option<ReadableFiles>,
    temporaries: u32,
    scripts: Vec<Script>,
    deps: Vec<String>,
    notice: Option<String>,
    printed: u64,
    files: u64,
}

/// The end of the template, as the interpreter reports it.
struct ScriptEnd {
    failed: bool,
    status: i32,
    message: String,
    trace: String,
}

type Reply = Result<Answer, Failure>;

pub(super) fn run(
    run: &Run<'_>,
    compiler: &mut Compiler,
    console: &mut dyn Console,
    output: Output,
    tmpdir: PathBuf,
) -> TemplateResult {
    let name = run.name();
    let reach = run.confined.map(|_| {
        ReadableFiles::new(&*run.disk, &run.dir, run.search, &run.base, &run.args, &tmpdir)
    });
    if reach.is_some() {
        let gaps = run.processes.gaps();
        if !gaps.is_empty() {
            let gaps: Vec<String> = gaps.iter().map(ToString::to_string).collect();
            console.err(&format!(
                "{name}: this system does not confine templates: nothing but the engine's own checks \
                 keeps this one from {}",
                gaps.join(", ")
            ));
        }
    }
    let host = Host::start(
        &*run.processes,
        &run.limits,
        &run.base,
        // Error output of a confined template is data, which the console makes harmless.
        !console.is_terminal() || reach.is_some(),
        reach.as_ref().map(ReadableFiles::access),
    );
    let host = match host {
        Ok(host) => host,
        Err(message) => {
            console.err(&format!("{name}: {message}"));
            return TemplateResult {
                status: 2,
                sink: output.finish(true).0,
                error: Some(message),
                place: None,
            };
        }
    };
    let compiled = compiler.compiled();
    let mut session = TemplateRun {
        run,
        host,
        compiler,
        console,
        compiled,
        registry: Rc::new(Registry::default()),
        unannounced: Vec::new(),
        output,
        tmpdir,
        reach,
        temporaries: 0,
        scripts: Vec::new(),
        deps: Vec::new(),
        notice: None,
        printed: 0,
        files: 0,
    };
    let ended = session.serve();
    session.conclude(ended)
}

impl TemplateRun<'_> {
    /// Reports the end of the template and writes the output.
    fn conclude(mut self, ended: Result<ScriptEnd, String>) -> TemplateResult {
        let name = self.run.name();
        // Output of a template that failed stays, as with GenoM3. If dotgen ended the template, nothing is
        // written.
        let ended_by_us = ended.is_err();
        let mut place = None;
        let (status, error) = match ended {
            Ok(done) => {
                self.host.finish();
                if done.failed {
                    place = error_location::place(
                        &*self.run.disk,
                        &self.run.dir,
                        &done.message,
                        &done.trace,
                    );
                }
                let shown = if self.run.verbose { &done.trace } else { &done.message };
                let error = done.failed.then(|| shown.clone());
                (done.status, error)
            }
            Err(message) => (2, Some(message)),
        };
        let captured = self.host.take_errors();
        for line in String::from_utf8_lossy(&captured).lines() {
            self.console.err(line);
        }
        if let Some(error) = &error {
            self.console.err(&format!("{name}: {error}"));
        }
        let unwritten = self.output.files.changed();
        let (sink, written) = self.output.finish(ended_by_us);
        let mut outcome = TemplateResult { status, sink, error, place };
        if let Err(problem) = written {
            let message = problem.to_string();
            self.console.err(&format!("{name}: {message}"));
            outcome.status = 2;
            outcome.error = Some(message);
        } else if ended_by_us && unwritten > 0 && !outcome.sink.preview {
            let message = format!("{name}: nothing was written, since the template did not end");
            self.console.err(&message);
        }
        outcome
    }

    /// Answers messages until the template has ended.
    ///
    /// # Errors
    /// Fails if the run cannot continue.
    fn serve(&mut self) -> Result<ScriptEnd, String> {
        loop {
            let words = self.host.receive()?;
            if words.first().is_some_and(|word| word == b"done") {
                let word =
                    |index: usize| words.get(index).map(|word| String::from_utf8_lossy(word));
                let word = |index: usize| word(index).unwrap_or_default().into_owned();
                return Ok(ScriptEnd {
                    failed: word(1) != "0",
                    status: word(2).parse().unwrap_or(2),
                    message: word(3),
                    trace: word(4),
                });
            }
            self.answer(words)?;
        }
    }

    /// Answers one message.
    ///
    /// # Errors
    /// Fails if the run cannot continue.
    fn answer(&mut self, words: Vec<Vec<u8>>) -> Result<(), String> {
        match words.first().map(Vec::as_slice) {
            Some(b"out") => {
                let text = words.get(1).map_or(&[][..], Vec::as_slice);
                self.printed += text.len() as u64;
                self.check_output(self.printed)?;
                self.console.out(text);
                return Ok(());
            }
            Some(b"stdin") => {
                let max = words.get(1).and_then(|word| std::str::from_utf8(word).ok());
                let max = max.and_then(|word| word.parse().ok()).unwrap_or(4096);
                let bytes = self.console.read(max);
                return self.host.send(&[b"bytes", &bytes]);
            }
            _ => {}
        }
        let words: Vec<String> = words
            .into_iter()
            .map(|word| {
                String::from_utf8(word).unwrap_or_else(|error| tcl::decode(error.as_bytes()))
            })
            .collect();
        let mut more = String::new();
        match self.dispatch(&words, &mut more) {
            Ok(answer) => {
                let pure: &[u8] = if answer.pure { b"1" } else { b"0" };
                self.host.send(&[
                    b"ok",
                    latin1(&answer.text).as_bytes(),
                    pure,
                    latin1(&more).as_bytes(),
                ])
            }
            Err(Failure::Error(message)) => {
                // The failure of a question depends on the same inputs as its answer.
                let pure: &[u8] = if words[0] == "query" { b"1" } else { b"0" };
                self.host.send(&[b"error", message.as_bytes(), pure, b""])
            }
            Err(Failure::Fatal(message)) => {
                self.host.send(&[b"fatal", message.as_bytes(), b"0", b""])
            }
            Err(Failure::Stop(message)) => Err(message),
        }
    }

    fn check_output(&self, size: u64) -> Result<(), String> {
        match self.run.limits.output {
            Some(limit) if size > limit => {
                Err(format!("stopped: the template printed or wrote more than {} MiB", limit >> 20))
            }
            _ => Ok(()),
        }
    }

    fn dispatch(&mut self, words: &[String], more: &mut String) -> Reply {
        let word = |index: usize| words.get(index).map_or("", String::as_str);
        let rest = |from: usize| words.get(from..).unwrap_or_default();
        let nothing = || Ok(Answer::volatile(String::new()));
        match word(0) {
            "hello" => self.hello(word(1)),
            "query" => {
                let language = Language::from_name(word(1)).unwrap_or_default();
                self.query(language, word(2), rest(3), more)
            }
            "parse" => self.parse(word(1), rest(2)),
            "marker" => self.translate(word(1), word(2)),
            "done_source" => {
                let name = self.scripts.iter().rev().find(|script| script.path == word(1));
                let name = name.map(|name| name.name.clone()).unwrap_or_default();
                // GenoM3 searches for the path as given and adds it normalized: one with `..` is added each
                // time.
                let path = self.run.dir.join(&name);
                if name != "<string>" && !self.deps.contains(&path.display().to_string()) {
                    self.deps.push(self.normalize(&path));
                }
                nothing()
            }
            "dep" => {
                let path = PathBuf::from(word(1));
                self.check_read(&path)?;
                self.scripts.push(Script {
                    path: word(1).to_owned(),
                    name: word(1).to_owned(),
                    text: (self.run.disk.read(&path))
                        .map(|bytes| tcl::decode(&bytes))
                        .unwrap_or_default(),
                });
                self.add_dep(&path);
                nothing()
            }
            "deps" => {
                let own = self.run.dir.join("template.tcl").display().to_string();
                if !self.deps.contains(&own) {
                    self.deps.push(own);
                }
                Ok(Answer::volatile(tcl::list(&self.deps)))
            }
            "message" => {
                self.message(word(1));
                nothing()
            }
            "blame" => self.blame(rest(1)),
            "commit" => {
                self.commit(word(1), word(2), word(3))?;
                nothing()
            }
            "commit_file" => {
                self.check_read(Path::new(word(3)))?;
                let text = self.run.disk.read(Path::new(word(3))).map_err(|error| {
                    Failure::Error(format!("couldn't open \"{}\": {}", word(3), posix(&error)))
                })?;
                self.commit(word(1), word(2), &tcl::decode(&text))?;
                nothing()
            }
            "too_much" => {
                Err(Failure::Stop(format!("stopped: a file grew beyond {} characters", word(1))))
            }
            "engine" => self.engine(word(1), rest(2)),
            other => Err(Failure::Error(format!("unknown request {other}"))),
        }
    }

    fn hello(&self, version: &str) -> Reply {
        if !version.starts_with("8.6") && !version.starts_with("8.7") {
            return Err(Failure::Stop(format!(
                "templates need Tcl 8.6, and tclsh is version {version}: install Tcl 8.6, or set \
                 DOTGEN_TCLSH to its tclsh"
            )));
        }
        let confined = self.reach.is_some();
        let limit = self.run.limits.output.unwrap_or(0);
        Ok(Answer::volatile(tcl::list([
            if confined { "1" } else { "0" },
            &self.run.name(),
            &self.run.dir.display().to_string(),
            &self.tmpdir.display().to_string(),
            &limit.to_string(),
            &tcl::list(&self.run.args),
        ])))
    }

    fn check_read(&self, path: &Path) -> Result<(), Failure> {
        match &self.reach {
            Some(reach) => reach.check_read(&*self.run.disk, &self.run.base.join(path)),
            None => Ok(()),
        }
    }

    /// A path as Tcl's `file normalize` gives it.
    fn normalize(&self, path: &Path) -> String {
        let disk = &*self.run.disk;
        let normal = crate::disk::normalize(disk, path);
        let normal = normal.unwrap_or_else(|| disk.absolute(path));
        normal.display().to_string()
    }

    fn add_dep(&mut self, path: &Path) {
        let path = self.normalize(path);
        if !self.deps.contains(&path) {
            self.deps.push(path);
        }
    }
}

impl Environment for TemplateRun<'_> {
    fn console(&mut self) -> &mut dyn Console {
        &mut *self.console
    }

    fn temporary(&mut self) -> PathBuf {
        self.temporaries += 1;
        self.tmpdir.join(format!("template{:08}", self.temporaries))
    }

    fn format_time(&mut self, time: SystemTime) -> String {
        let seconds = time.duration_since(UNIX_EPOCH).unwrap_or_default();
        let seconds = seconds.as_secs().to_string();
        // Tcl provides the time zone and its names.
        self.evaluate(&format!("clock format {seconds}")).unwrap_or(seconds)
    }

    fn processes(&self) -> &dyn Processes {
        &*self.run.processes
    }

    fn message(&mut self, text: &str) {
        if self.run.verbose {
            self.console.err(&format!("{}: {text}", self.run.name()));
        }
    }
}
