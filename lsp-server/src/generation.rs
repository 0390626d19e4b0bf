//! Generating files from an editor: the commands `dotgen.templates`, `dotgen.templateOptions`,
//! `dotgen.generate`, `dotgen.regenerate` and `dotgen.rememberTemplate` (docs/protocol.md).
//!
//! A template is a program. It runs only in a workspace that the client trusts, with every file kept
//! in memory; nothing is written before the user has seen it.

mod choices;
mod edit;
mod run;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_codegen::disk::{Disk as _, NewContent};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::backend::Backend;
use crate::config::{self, Generate};
use crate::convert::{diagnostic, uri};
use crate::disk::SystemDisk;
use crate::outbox::Outbox;
use crate::proto::*;
use edit::{Able, FileChange};
use run::{Generated, Job};

/// Lists the templates.
pub(crate) const TEMPLATES: &str = "dotgen.templates";
/// Tells the options of a template.
pub(crate) const OPTIONS: &str = "dotgen.templateOptions";
/// Runs a template and offers what it would write.
pub(crate) const GENERATE: &str = "dotgen.generate";
/// The same with the choices made before.
pub(crate) const REGENERATE: &str = "dotgen.regenerate";
/// Keeps a choice.
pub(crate) const REMEMBER: &str = "dotgen.rememberTemplate";

/// All commands of this module.
pub(crate) const COMMANDS: [&str; 5] = [TEMPLATES, OPTIONS, GENERATE, REGENERATE, REMEMBER];

/// Argument of the commands.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct GenerateParams {
    /// The specification.
    pub(crate) uri: Uri,
    /// Name of the template, or absolute path of its folder.
    #[serde(default)]
    pub(crate) template: Option<String>,
    /// Its options; without them, those used last for this file.
    #[serde(default)]
    pub(crate) arguments: Option<Vec<String>>,
    /// `false`: the answer has the edit and the client does the rest.
    #[serde(default = "yes")]
    pub(crate) apply: bool,
}

fn yes() -> bool {
    true
}

/// What runs go on, and what was said about templates.
#[derive(Default)]
pub(crate) struct Generation {
    next: AtomicU64,
    /// Runs that can be cancelled, by the token of their progress.
    running: Mutex<BTreeMap<String, Arc<AtomicBool>>>,
    /// Files of templates with a diagnostic, by the template that failed.
    reported: Mutex<BTreeMap<String, BTreeSet<Utf8PathBuf>>>,
}

/// Stops a run when the client cancels its request.
struct StopOnDrop(Arc<AtomicBool>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// What one or several templates would do.
#[derive(Default)]
struct Plan {
    choices: Vec<Generate>,
    changes: Vec<FileChange>,
    output: String,
    messages: String,
    problem: Option<Value>,
    failed: bool,
}

impl Backend {
    /// One of [`COMMANDS`].
    pub(crate) async fn generation_command(
        &self,
        command: &str,
        argument: Value,
    ) -> Result<Option<Value>> {
        let params: GenerateParams = serde_json::from_value(argument)
            .map_err(|error| Error::invalid_params(error.to_string()))?;
        let job = self.dispatch.document(params.uri.clone(), (), run::job);
        let Some(job) = job.await? else {
            let what = "generating needs a specification that is a file: save it first";
            return Err(refused(what.to_owned()));
        };
        if !job.trusted() {
            return Err(refused(
                "templates are programs, and this workspace is not trusted: trust it in the editor \
                 (clients tell with `initializationOptions.trusted`), or run `dotgen generate` in a \
                 terminal"
                    .to_owned(),
            ));
        }
        match command {
            TEMPLATES => {
                let list = json!({
                    "templates": job.templates(),
                    "remembered": job.remembered(),
                });
                Ok(Some(list))
            }
            OPTIONS => {
                let template = params.template.unwrap_or_default();
                let asked = blocking(move || job.usage(&template)).await?;
                Ok(Some(json!({ "usage": asked.0, "options": asked.1 })))
            }
            REMEMBER => {
                let choice = Generate {
                    file: job.name(),
                    template: params.template.unwrap_or_default(),
                    arguments: params.arguments.unwrap_or_default(),
                };
                remember(&job.folder, &[choice]).map_err(refused)?;
                Ok(None)
            }
            GENERATE => {
                let remembered = job.remembered();
                let template = match params.template {
                    Some(template) => template,
                    None => match self.choose(&job).await? {
                        Some(template) => template,
                        None => return Ok(Some(json!({ "status": "cancelled" }))),
                    },
                };
                let before = remembered.into_iter().find(|it| it.template == template);
                let before = before.map(|it| it.arguments).unwrap_or_default();
                let choice = Generate {
                    file: job.name(),
                    arguments: params.arguments.unwrap_or(before),
                    template,
                };
                self.generate(*job, vec![choice], params.apply).await
            }
            _ => {
                let choices = job.remembered();
                if choices.is_empty() {
                    return Err(refused(format!(
                        "nothing was generated from {} yet: `Generate…` comes first",
                        job.name()
                    )));
                }
                self.generate(*job, choices, params.apply).await
            }
        }
    }

    /// Asks for a template.
    async fn choose(&self, job: &Job) -> Result<Option<String>> {
        let actions = job.templates().into_iter().map(|it| MessageActionItem {
            title: it.name,
            properties: Default::default(),
        });
        let question = format!("Generate from {} with the template", job.name());
        let client = self.dispatch.client();
        let answer = client
            .show_message_request(MessageType::INFO, question, Some(actions.collect()))
            .await?;
        Ok(answer.map(|it| it.title))
    }

    async fn generate(
        &self,
        job: Job,
        choices: Vec<Generate>,
        apply: bool,
    ) -> Result<Option<Value>> {
        let cancel = Arc::new(AtomicBool::new(false));
        let _guard = StopOnDrop(cancel.clone());
        let names: Vec<&str> = choices.iter().map(|it| it.template.as_str()).collect();
        let title = format!("Generating {}", names.join(", "));
        let token = self.begin_progress(&job, &title, &cancel).await;
        let work = job.clone();
        let stop = cancel.clone();
        let plan = blocking(move || plan(&work, choices, &stop)).await;
        self.end_progress(token).await;
        let plan = plan?;
        if cancel.load(Ordering::Acquire) {
            return Ok(Some(json!({ "status": "cancelled" })));
        }
        self.report(&plan);
        let able = Able {
            apply: job.client.applies_edits,
            create: job.client.creates_files && job.client.applies_edits,
            encoding: job.client.encoding,
        };
        let mut answer = plan.answer();
        if plan.failed {
            if apply {
                let text = plan.messages.lines().next().unwrap_or_default();
                let message = format!("{title} failed: {text}");
                self.dispatch
                    .client()
                    .show_message(MessageType::ERROR, message)
                    .await;
            }
            answer["status"] = json!("failed");
        } else if plan.changes.is_empty() {
            answer["status"] = json!("unchanged");
            if apply {
                remember(&job.folder, &plan.choices).map_err(refused)?;
            }
        } else if apply {
            let applied = self.apply(&plan, &title, able).await?;
            if applied {
                remember(&job.folder, &plan.choices).map_err(refused)?;
            }
            answer["status"] = json!(if applied { "applied" } else { "rejected" });
        } else {
            let edit = edit::workspace_edit(&plan.changes, able);
            answer["status"] = json!("preview");
            answer["edit"] = serde_json::to_value(edit).unwrap_or_default();
        }
        Ok(Some(answer))
    }

    /// Asks once, with the names of the files, and makes the changes.
    async fn apply(&self, plan: &Plan, title: &str, able: Able) -> Result<bool> {
        let client = self.dispatch.client();
        let action = |title: &str| MessageActionItem {
            title: title.to_owned(),
            properties: Default::default(),
        };
        let actions = vec![action("Write"), action("Cancel")];
        let answer = client
            .show_message_request(MessageType::INFO, plan.question(), Some(actions))
            .await?;
        if answer.is_none_or(|it| it.title != "Write") {
            return Ok(false);
        }
        // The server writes what the client cannot.
        let (ours, theirs): (Vec<FileChange>, Vec<FileChange>) = plan
            .changes
            .iter()
            .cloned()
            .partition(|it| !able.apply || (!able.create && it.before.is_none()));
        write(&ours).map_err(refused)?;
        if !theirs.is_empty() {
            let edit = edit::workspace_edit(&theirs, able);
            let params = ApplyWorkspaceEditParams {
                label: Some(title.to_owned()),
                edit,
            };
            let answer = client
                .send_request::<request::ApplyWorkspaceEdit>(params)
                .await?;
            if !answer.applied {
                return Ok(false);
            }
        }
        for change in &plan.changes {
            set_mode(change);
        }
        Ok(true)
    }

    /// Marks the place where a template failed, and takes back what was said of it before.
    fn report(&self, plan: &Plan) {
        let outbox = self.dispatch.outbox();
        let mut reported = lock(&self.generation.reported);
        let found = plan.problem.as_ref().and_then(|it| {
            let uri: Uri = serde_json::from_value(it["uri"].clone()).ok()?;
            let line = u32::try_from(it["line"].as_u64()?).ok()?;
            Some((uri::to_path(&uri), line, it["message"].as_str()?.to_owned()))
        });
        for choice in &plan.choices {
            let before = reported.remove(&choice.template).unwrap_or_default();
            for path in before {
                outbox.publish(&path, Vec::new());
            }
        }
        if let (Some((path, line, message)), Some(last)) = (found, plan.choices.last()) {
            publish_problem(outbox, &path, line, message);
            let known = reported.entry(last.template.clone()).or_default();
            known.insert(path);
        }
    }

    async fn begin_progress(
        &self,
        job: &Job,
        title: &str,
        cancel: &Arc<AtomicBool>,
    ) -> Option<ProgressToken> {
        if !job.client.progress {
            return None;
        }
        let number = self.generation.next.fetch_add(1, Ordering::Relaxed);
        let name = format!("dotgen/generate/{number}");
        let token = ProgressToken::String(name.clone());
        let client = self.dispatch.client();
        client.create_work_done_progress(token.clone()).await.ok()?;
        lock(&self.generation.running).insert(name, cancel.clone());
        let begin = WorkDoneProgressBegin {
            title: title.to_owned(),
            cancellable: Some(true),
            ..WorkDoneProgressBegin::default()
        };
        progress(client, &token, WorkDoneProgress::Begin(begin)).await;
        Some(token)
    }

    async fn end_progress(&self, token: Option<ProgressToken>) {
        let Some(token) = token else { return };
        if let ProgressToken::String(name) = &token {
            lock(&self.generation.running).remove(name);
        }
        let end = WorkDoneProgress::End(WorkDoneProgressEnd::default());
        progress(self.dispatch.client(), &token, end).await;
    }

    /// `window/workDoneProgress/cancel`
    pub(crate) async fn cancel_progress(&self, params: WorkDoneProgressCancelParams) {
        if let ProgressToken::String(name) = &params.token
            && let Some(run) = lock(&self.generation.running).get(name)
        {
            run.store(true, Ordering::Release);
        }
    }
}

async fn progress(client: &Client, token: &ProgressToken, value: WorkDoneProgress) {
    client
        .send_notification::<notification::Progress>(ProgressParams {
            token: token.clone(),
            value: ProgressParamsValue::WorkDone(value),
        })
        .await;
}

/// The actions on a component: the code action "Generate…", and "Regenerate" when something was
/// generated before.
pub(crate) fn actions(uri: &Uri, remembered: bool) -> Vec<(String, Command)> {
    let command = |title: &str, command: &str| {
        let argument = json!({ "uri": uri });
        let command = Command::new(title.to_owned(), command.to_owned(), Some(vec![argument]));
        (title.to_owned(), command)
    };
    let mut all = vec![command("Generate…", GENERATE)];
    if remembered {
        all.push(command("Regenerate", REGENERATE));
    }
    all
}

/// Runs templates one after the other; the first that fails ends it.
fn plan(job: &Job, choices: Vec<Generate>, cancel: &Arc<AtomicBool>) -> Plan {
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
    fn templates(&self) -> String {
        let names: Vec<&str> = self.choices.iter().map(|it| it.template.as_str()).collect();
        names.join(", ")
    }

    /// What would happen, as a question.
    fn question(&self) -> String {
        let name = |it: &FileChange| {
            let path = uri::to_path(&it.uri);
            path.file_name().unwrap_or_default().to_owned()
        };
        let list = |new: bool| -> Vec<String> {
            let of = self.changes.iter().filter(|it| it.before.is_none() == new);
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

    fn answer(&self) -> Value {
        let files = self.changes.iter().map(|it| {
            json!({
                "uri": it.uri,
                "change": if it.before.is_some() { "change" } else { "create" },
                "before": it.before,
                "after": it.after,
                "mode": it.mode,
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

fn publish_problem(outbox: &Outbox, path: &Utf8Path, line: u32, message: String) {
    let line = line.saturating_sub(1);
    let range = Range::new(Position::new(line, 0), Position::new(line, 1000));
    outbox.publish(
        path,
        vec![Diagnostic {
            range,
            severity: Some(DiagnosticSeverity::ERROR),
            code: Some(NumberOrString::String("template-failed".to_owned())),
            source: Some(diagnostic::SOURCE.to_owned()),
            message,
            ..Diagnostic::default()
        }],
    );
}

/// Adds choices to the `dotgen.toml` of a folder.
fn remember(folder: &Utf8Path, choices: &[Generate]) -> std::result::Result<(), String> {
    let path = folder.join(config::FILE_NAME);
    let before = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
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
        path: path.into(),
        bytes: text.into_bytes(),
        mode: None,
    };
    SystemDisk.write(&[file]).map_err(|it| it.to_string())
}

/// Writes what the client cannot, all or none.
fn write(changes: &[FileChange]) -> std::result::Result<(), String> {
    let content = |it: &FileChange| NewContent {
        path: uri::to_path(&it.uri).into(),
        bytes: it.after.clone().into_bytes(),
        mode: None,
    };
    let files: Vec<NewContent> = changes.iter().map(content).collect();
    SystemDisk.write(&files).map_err(|it| it.to_string())
}

fn set_mode(change: &FileChange) {
    if let Some(mode) = change.mode {
        // A client that has not saved the file yet keeps what it has.
        let _ = SystemDisk.set_mode(uri::to_path(&change.uri).as_std_path(), mode);
    }
}

async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T> {
    let done = tokio::task::spawn_blocking(move || crate::panic::isolate(work)).await;
    match done {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(message)) => Err(refused(format!("internal error: {message}"))),
        Err(error) => Err(refused(error.to_string())),
    }
}

/// An error the client shows.
fn refused(message: String) -> Error {
    Error {
        code: ErrorCode::ServerError(-32803),
        message: message.into(),
        data: None,
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
