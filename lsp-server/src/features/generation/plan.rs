//! The results of templates before they are written, and the way they are written.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use camino::Utf8Path;
use dotgen_analysis::terminal;
use dotgen_codegen::disk::{Disk as _, NewContent};
use serde_json::{Value, json};

use super::choices;
use super::edit::{self, FileChange};
use super::run::{Generated, Job};
use crate::config::{self, Generate};
use crate::protocol::convert::uri;
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::read_regular_to_string;

/// The results of one or several templates.
#[derive(Default)]
pub(crate) struct Plan {
    pub(crate) choices: Vec<Generate>,
    pub(crate) changes: Vec<FileChange>,
    pub(crate) output: String,
    pub(crate) messages: String,
    pub(crate) problem: Option<Value>,
    pub(crate) failed: bool,
}

/// Runs templates one after the other, up to the first that fails.
pub(crate) fn plan(job: &Job, choices: Vec<Generate>, cancel: &Arc<AtomicBool>) -> Plan {
    let mut plan = Plan::default();
    let mut files = BTreeMap::new();
    for choice in choices {
        let done = job.run(&choice.template, &choice.arguments, cancel.clone());
        plan.choices.push(choice);
        plan.output += &done.output;
        plan.messages += &done.messages;
        if done.status != 0 {
            plan.failed = true;
            plan.problem = problem(&done);
            return plan;
        }
        files.extend(done.files);
    }
    match edit::changes(&files) {
        Ok(changes) => plan.changes = changes,
        Err(message) => {
            plan.failed = true;
            plan.messages += &message;
        }
    }
    plan
}

fn problem(done: &Generated) -> Option<Value> {
    let place = done.failed_at.as_ref()?;
    let uri = uri::from_path(Utf8Path::from_path(&place.file)?)?;
    Some(json!({ "uri": uri, "line": place.line, "message": place.message }))
}

impl Plan {
    pub(crate) fn templates(&self) -> String {
        let names: Vec<&str> = self.choices.iter().map(|choice| choice.template.as_str()).collect();
        names.join(", ")
    }

    /// A description of the changes, as a question to the user.
    pub(crate) fn question(&self) -> String {
        let name = |change: &FileChange| {
            let path = uri::to_path(&change.uri);
            let name = terminal::name(path.file_name().unwrap_or_default()).into_owned();
            match change.concern {
                // The name alone does not show that a folder is hidden.
                Some(what) if what.hidden => {
                    format!("{} ({what})", terminal::name(path.as_str()))
                }
                Some(what) => format!("{name} ({what})"),
                None => name,
            }
        };
        let list = |new: bool| -> Vec<String> {
            let of = self.changes.iter().filter(|change| change.before.is_none() == new);
            of.map(name).collect()
        };
        let mut parts = Vec::new();
        for (word, names) in [("create", list(true)), ("change", list(false))] {
            if !names.is_empty() {
                parts.push(format!("{word} {}", names.join(", ")));
            }
        }
        format!("{} would {}.", self.templates(), parts.join(" and "))
    }

    pub(crate) fn answer(&self) -> Value {
        let files = self.changes.iter().map(|change| {
            json!({
                "uri": change.uri,
                "change": if change.before.is_some() { "change" } else { "create" },
                "before": change.before,
                "after": change.after,
                "mode": change.mode,
                "concern": change.concern.map(|concern| concern.to_string()),
            })
        });
        json!({
            "files": files.collect::<Vec<_>>(),
            "choices": self.choices,
            "output": self.output,
            "messages": self.messages,
            "problem": self.problem,
        })
    }
}

/// Adds choices to the `dotgen.toml` of a folder.
pub(crate) fn remember(folder: &Utf8Path, choices: &[Generate]) -> std::result::Result<(), String> {
    let path = folder.join(config::FILE_NAME);
    let (existing, before) = match read_regular_to_string(path.as_std_path()) {
        Ok(text) => (true, text),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => (false, String::new()),
        Err(error) => return Err(format!("cannot read {path}: {error}")),
    };
    let mut text = before.clone();
    for choice in choices {
        text = choices::remember(&text, choice)
            .map_err(|error| format!("cannot remember the choice in {path}: {error}"))?;
    }
    if text == before {
        return Ok(());
    }
    let file = NewContent {
        before: existing.then(|| before.into_bytes()).into(),
        within: vec![folder.into()],
        ..NewContent::new(path, text.into_bytes())
    };
    SystemDisk.write(&[file]).map_err(|error| error.to_string())
}

/// Writes the files that the client cannot write: all or none.
pub(crate) fn write(changes: &[FileChange]) -> std::result::Result<(), String> {
    let content = |change: &FileChange| NewContent {
        before: change.before.clone().map(String::into_bytes).into(),
        ..NewContent::new(uri::to_path(&change.uri), change.after.clone().into_bytes())
    };
    let files: Vec<NewContent> = changes.iter().map(content).collect();
    SystemDisk.write(&files).map_err(|error| error.to_string())
}

pub(crate) fn set_mode(change: &FileChange) {
    if let Some(mode) = change.mode {
        // The mode of a file that the client has not saved yet is unchanged.
        let _ = SystemDisk.set_mode(uri::to_path(&change.uri).as_std_path(), mode);
    }
}
