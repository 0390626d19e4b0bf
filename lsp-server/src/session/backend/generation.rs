//! Generating files from an editor: the commands `dotgen.templates`, `dotgen.templateOptions`,
//! `dotgen.generate`, `dotgen.regenerate` and `dotgen.rememberTemplate` (docs/protocol.md).
//!
//! A template is a program. It runs only in a workspace that the client trusts, with every file kept in
//! memory. Files are written only after the user has seen them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Backend;
use crate::config::Generate;
use crate::features::generation::edit::{self, EditSupport, FileChange};
use crate::features::generation::plan::{Plan, plan, remember, set_mode, write};
use crate::features::generation::run::{self, Job};
use crate::features::generation::{GENERATE, OPTIONS, REMEMBER, TEMPLATES};
use crate::protocol::convert::uri;
use crate::protocol::outbox::Outbox;
use crate::protocol::progress::Running;
use crate::protocol::types::*;

/// Argument of the commands.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct GenerateParams {
    /// The specification.
    pub(crate) uri: Uri,
    /// Name of the template, or absolute path of its folder.
    #[serde(default)]
    pub(crate) template: Option<String>,
    /// Its options. The default is the options last used for this file.
    #[serde(default)]
    pub(crate) arguments: Option<Vec<String>>,
    /// `false`: the answer contains the edit, and the client applies it.
    #[serde(default = "default_true")]
    pub(crate) apply: bool,
}

fn default_true() -> bool {
    true
}

/// The state of generation: the diagnostics in template files.
#[derive(Default)]
pub(crate) struct Generation {
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

impl Backend {
    /// One of `COMMANDS`.
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
                let before = remembered.into_iter().find(|generate| generate.template == template);
                let before = before.map(|generate| generate.arguments).unwrap_or_default();
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

    /// Asks the user for a template.
    async fn choose(&self, job: &Job) -> Result<Option<String>> {
        let actions = job.templates().into_iter().map(|template| MessageActionItem {
            title: template.name,
            properties: Default::default(),
        });
        let question = format!("Generate from {} with the template", job.name());
        let client = self.dispatch.client();
        let answer = client
            .show_message_request(MessageType::INFO, question, Some(actions.collect()))
            .await?;
        Ok(answer.map(|answer| answer.title))
    }

    async fn generate(
        &self,
        mut job: Job,
        choices: Vec<Generate>,
        apply: bool,
    ) -> Result<Option<Value>> {
        job.reviewed = !apply;
        let cancel = Arc::new(AtomicBool::new(false));
        let _guard = StopOnDrop(cancel.clone());
        let names: Vec<&str> = choices.iter().map(|choice| choice.template.as_str()).collect();
        let title = format!("Generating {}", names.join(", "));
        let progress = self.begin_progress(&job, &title, &cancel).await;
        let work = job.clone();
        let stop = cancel.clone();
        let plan = blocking(move || plan(&work, choices, &stop)).await;
        if let Some(progress) = progress {
            progress.end().await;
        }
        let plan = plan?;
        if cancel.load(Ordering::Acquire) {
            return Ok(Some(json!({ "status": "cancelled" })));
        }
        self.report(&plan);
        let able = EditSupport {
            apply: job.client.applies_edits,
            create: job.client.creates_files && job.client.applies_edits,
            encoding: job.client.encoding,
        };
        let mut answer = plan.answer();
        if plan.failed {
            if apply {
                let text = plan.messages.lines().next().unwrap_or_default();
                let message = format!("{title} failed: {text}");
                self.dispatch.client().show_message(MessageType::ERROR, message).await;
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

    /// Shows the names of the files, asks once, and makes the changes.
    async fn apply(&self, plan: &Plan, title: &str, able: EditSupport) -> Result<bool> {
        let client = self.dispatch.client();
        let action = |title: &str| MessageActionItem {
            title: title.to_owned(),
            properties: Default::default(),
        };
        let actions = vec![action("Write"), action("Cancel")];
        let answer =
            client.show_message_request(MessageType::INFO, plan.question(), Some(actions)).await?;
        if answer.is_none_or(|answer| answer.title != "Write") {
            return Ok(false);
        }
        // The server writes the files that the client cannot write.
        let (ours, theirs): (Vec<FileChange>, Vec<FileChange>) = plan
            .changes
            .iter()
            .cloned()
            .partition(|change| !able.apply || (!able.create && change.before.is_none()));
        write(&ours).map_err(refused)?;
        if !theirs.is_empty() {
            let edit = edit::workspace_edit(&theirs, able);
            let params = ApplyWorkspaceEditParams { label: Some(title.to_owned()), edit };
            let answer = client.send_request::<request::ApplyWorkspaceEdit>(params).await?;
            if !answer.applied {
                return Ok(false);
            }
        }
        for change in &plan.changes {
            set_mode(change);
        }
        Ok(true)
    }

    /// Reports the place at which a template failed, and clears its earlier diagnostics.
    fn report(&self, plan: &Plan) {
        let outbox = self.dispatch.outbox();
        let mut reported = lock(&self.generation.reported);
        let found = plan.problem.as_ref().and_then(|problem| {
            let uri: Uri = serde_json::from_value(problem["uri"].clone()).ok()?;
            let line = u32::try_from(problem["line"].as_u64()?).ok()?;
            Some((uri::to_path(&uri), line, problem["message"].as_str()?.to_owned()))
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
    ) -> Option<Running> {
        if !job.client.progress {
            return None;
        }
        let cancel = cancel.clone();
        let cancel = move || cancel.store(true, Ordering::Release);
        self.dispatch.running().begin(title, cancel).await
    }

    /// `window/workDoneProgress/cancel`
    #[expect(clippy::unused_async, reason = "the library calls handlers that are asynchronous")]
    pub(crate) async fn cancel_progress(&self, params: WorkDoneProgressCancelParams) {
        self.dispatch.running().cancel(&params.token);
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
            source: Some(SOURCE.to_owned()),
            message,
            ..Diagnostic::default()
        }],
    );
}

async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T> {
    let done = tokio::task::spawn_blocking(move || dotgen_platform::panic::isolate(work)).await;
    match done {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(message)) => Err(refused(format!("internal error: {message}"))),
        Err(error) => Err(refused(error.to_string())),
    }
}

/// An error that the client shows.
fn refused(message: String) -> Error {
    Error { code: ErrorCode::ServerError(-32803), message: message.into(), data: None }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
