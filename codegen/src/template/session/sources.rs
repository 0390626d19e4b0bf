//! Sources of templates, the places of their errors, and the engine's operations on files.

use std::path::Path;

use super::{Reply, TemplateRun};
use crate::template::api::Answer;
use crate::template::error_location::{self, Frame, Script};
use crate::template::output::{Environment, Output, OutputSink, join, posix};
use crate::template::{Failure, marker, tcl};

impl TemplateRun<'_> {
    /// Translates a source and puts the program in a file; returns its path.
    pub(super) fn translate(&mut self, kind: &str, source: &str) -> Reply {
        let (name, text) = if kind == "file" {
            let path = join(&self.run.dir.display().to_string(), source);
            self.message(&format!("reading {path}"));
            self.check_read(path.as_ref())?;
            let bytes = self.run.disk.read(Path::new(&path)).map_err(|error| {
                Failure::Error(format!("couldn't open \"{path}\": {}", posix(&error)))
            })?;
            (source.to_owned(), tcl::decode(&bytes))
        } else {
            ("<string>".to_owned(), tcl::low_bytes(source))
        };
        let program = marker::translate(&text)
            .map_err(|error| Failure::Error(format!("{name}:{}: {}", error.line, error.fault)))?;
        let path = self.temporary();
        if self.output.modes.is_on("debug") && !self.output.modes.is_on("silent") {
            self.print(&format!("generating template code for {name} in {}", path.display()));
        }
        self.run.disk.put(&path, program.text.as_bytes()).map_err(|error| {
            Failure::Error(format!("couldn't open \"{}\": {}", path.display(), posix(&error)))
        })?;
        let path = path.display().to_string();
        self.scripts.push(Script { path: path.clone(), name, text: program.text });
        Ok(Answer::volatile(path))
    }

    pub(super) fn blame(&mut self, words: &[String]) -> Reply {
        let [name, _program, message, trace, frames] = words else {
            return Err(Failure::Error("malformed request".into()));
        };
        let words = tcl::parse_list(frames).unwrap_or_default();
        let frames: Vec<Frame> = words
            .chunks_exact(3)
            .map(|chunk| Frame {
                file: chunk[0].clone(),
                line: chunk[1].parse().unwrap_or(1),
                command: chunk[2].clone(),
            })
            .collect();
        let scripts = std::mem::take(&mut self.scripts);
        let text = error_location::explain(name, message, trace, &frames, &scripts, |procedure| {
            let body = tcl::list(["info", "body", procedure]);
            self.evaluate(&tcl::list(["slave", "eval", &body])).ok()
        });
        self.scripts = scripts;
        Ok(Answer::volatile(text))
    }

    pub(super) fn commit(
        &mut self,
        name: &str,
        permissions: &str,
        text: &str,
    ) -> Result<(), Failure> {
        self.files += text.len() as u64;
        self.check_output(self.files).map_err(Failure::Stop)?;
        let mut output = {
            let disk = std::sync::Arc::clone(&self.run.disk);
            let empty =
                Output::new(String::new(), Default::default(), false, disk, OutputSink::DIRECT);
            std::mem::replace(&mut self.output, empty)
        };
        let result = output.commit(name, permissions, text, self);
        self.output = output;
        result
    }

    pub(super) fn engine(&mut self, what: &str, words: &[String]) -> Reply {
        let usage =
            |usage: &str| Failure::Error(format!("wrong # args: should be \"engine {usage}\""));
        let text = match (what, words) {
            ("mode", []) => tcl::list(self.output.modes.show()),
            ("mode", words) => {
                for word in words {
                    if let Some((name, on)) = self.output.modes.set(word)? {
                        let value = if on { "on" } else { "off" };
                        self.message(&format!("{name} mode {value}"));
                    }
                }
                String::new()
            }
            ("merge-tool", [tool]) => {
                self.output.set_merge_tool(tool)?;
                tool.clone()
            }
            ("merge-tool", _) => return Err(usage("merge-tool tool")),
            ("chdir", [dir]) => {
                if self.output.dir != *dir {
                    self.output.dir.clone_from(dir);
                    self.message(&format!("set output directory to '{dir}'"));
                }
                String::new()
            }
            ("chdir", _) => return Err(usage("chdir d")),
            ("pwd", []) if self.output.dir.is_empty() => ".".into(),
            ("pwd", []) => self.output.dir.clone(),
            ("pwd", _) => return Err(usage("pwd")),
            ("mktemp", []) => self.temporary().display().to_string(),
            _ => return Err(usage("mktemp")),
        };
        Ok(Answer::volatile(text))
    }
}
