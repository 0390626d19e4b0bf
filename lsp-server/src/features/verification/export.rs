//! `dotgen/exportModel`: the formal model of a document, as files for a tool of others. The client writes
//! them. `docs/protocol.md` describes the request for clients.

use std::ops::Range;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::model::Src;
use dotgen_export::{Format, check_name, export};
use dotgen_timing::diagnostic::remark::together;
use dotgen_timing::scn::ast::Item;
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::{Machine, TimedSystem, unfolded};
use dotgen_timing::verify::{self, Cancel, Options, Prepared, SystemInput};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answer::CancelOnDrop;
use super::problems::problem_of;
use crate::protocol::convert::Lines;
use crate::protocol::types::{Error, Location, Result, TextDocumentIdentifier, Uri};
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::verification::Problem;

/// Maximum size of a system: the sum, over the states of all machines with loops unfolded, of the number of
/// codels that exclude the codel of the state. Text and time grow with it: about 60 bytes of text for each.
const MAX_SIZE: usize = 100_000;

/// Maximum size of the files together, in bytes.
const MAX_BYTES: usize = 16 << 20;

/// Parameters of `dotgen/exportModel`.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct ExportParams {
    /// A scenario or a specification.
    pub(crate) text_document: TextDocumentIdentifier,
    #[serde(with = "FormatName")]
    format: Format,
}

/// The names of formats, as on the command line.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Format", rename_all = "lowercase")]
enum FormatName {
    Uppaal,
    TChecker,
    Fiacre,
    Bip,
}

/// The system of a document with the texts of its files, copied from a snapshot.
pub(crate) struct ModelInput {
    problem: Problem,
    options: Options,
    format: Format,
    texts: FxHashMap<Utf8PathBuf, (Uri, Arc<Lines>)>,
}

/// A reason against a model, with its place.
type Reason = (String, Utf8PathBuf, Range<usize>);

/// Finds the system of a document; none in other languages.
pub(crate) fn to_export(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &ExportParams,
) -> Cancellable<Option<ModelInput>> {
    let Some(problem) = problem_of(snapshot, &subject.path)? else {
        return Ok(None);
    };
    let mut texts = FxHashMap::default();
    for path in problem.files() {
        if let Some((uri, lines)) = snapshot.uri(path).zip(snapshot.lines(path)?) {
            texts.insert(path.to_owned(), (uri, lines));
        }
    }
    let options = snapshot.config.verification.options();
    Ok(Some(ModelInput { problem, options, format: params.format, texts }))
}

impl ModelInput {
    /// Writes the model. It runs without a snapshot, because a snapshot would delay edits. Dropping the
    /// future ends the work after its current step.
    ///
    /// # Errors
    ///
    /// `InternalError` after a panic.
    pub(crate) async fn export(self) -> Result<Value> {
        let cancel = Arc::new(Cancel::default());
        let _guard = CancelOnDrop(cancel.clone());
        let work = tokio::task::spawn_blocking(move || match self.files(&cancel) {
            Ok(files) => json!({ "files": files }),
            // The reasons against a model: errors, and everything that the model cannot contain.
            Err(reasons) => {
                let place = |(message, path, range): &Reason| {
                    let location = self.location(path, range);
                    json!({ "message": message, "location": location })
                };
                json!({ "refusals": reasons.iter().map(place).collect::<Vec<_>>() })
            }
        });
        work.await.map_err(|error| {
            tracing::error!("the export panicked: {error}");
            Error::internal_error()
        })
    }

    fn files(&self, cancel: &Cancel) -> std::result::Result<Vec<Value>, Vec<Reason>> {
        let problem = &self.problem;
        let failures = |found: &mut dyn Iterator<Item = Diagnostic>| -> Vec<Reason> {
            let found = found.filter(|diagnostic| diagnostic.severity == Severity::Error);
            found.map(|error| (error.message.to_string(), error.path, error.range)).collect()
        };
        if !problem.errors.is_empty() {
            return Err(failures(&mut problem.errors.iter().cloned()));
        }
        let input = SystemInput { specs: problem.specs() };
        let prepared = verify::prepare(&input, &problem.scenario, &self.options);
        if prepared.report.has_errors() {
            let found = together(&prepared.report.diagnostics);
            return Err(failures(&mut found.iter().map(|entry| problem.diagnostic(entry))));
        }
        let whole = |message: String| vec![self.reason(message, &prepared, "")];
        if cancel.is_abandoned() || size(&prepared.built.system) > MAX_SIZE {
            let most = "the system is too large for an editor; use `dotgen export`".to_owned();
            return Err(whole(most));
        }
        let names = Names::new(&input.specs);
        let place = |component: usize, src: Src| {
            let (path, range) = problem.place(names.components.get(component)?.spec_index, src)?;
            let line = 1 + self.location(&path, &range)?.range.start.line;
            Some(format!("{}:{line}", path.file_name()?))
        };
        let files = export(&prepared, &place, self.format).map_err(|refusals| {
            let reason = |refusal: &dotgen_export::Refusal| {
                let place = refusal.place.as_deref().unwrap_or_default();
                self.reason(refusal.to_string(), &prepared, place)
            };
            refusals.iter().map(reason).collect::<Vec<_>>()
        })?;
        if files.iter().map(|file| file.text.len()).sum::<usize>() > MAX_BYTES {
            let most =
                format!("the model is larger than {} MB; use `dotgen export`", MAX_BYTES >> 20);
            return Err(whole(most));
        }
        let files = files.iter();
        Ok(files.map(|file| json!({ "name": file.name, "text": file.text })).collect())
    }

    /// A reason at the check, client, task or service with a name, or else at the name of the scenario.
    fn reason(&self, message: String, prepared: &Prepared, name: &str) -> Reason {
        let Problem { path, scenario, .. } = &self.problem;
        let reports = prepared.checks.iter().map(|check| &check.report);
        let check = reports
            .filter(|report| check_name(report) == name)
            .find_map(|report| Some(scenario.checks().nth(report.id.written)?.range.clone()));
        let client = scenario.items.iter().find_map(|item| match item {
            Item::Client(client) if client.name.value == name => Some(client.name.range.clone()),
            _ => None,
        });
        let written = self.problem.is_written();
        if let Some(range) = check.or(client).filter(|_| written) {
            return (message, path.clone(), range);
        }
        let (path, range) = self.declared(name).unwrap_or_else(|| {
            let range = if written { scenario.name_range.clone() } else { 0..0 };
            (path.clone(), range)
        });
        (message, path, range)
    }

    /// The place of `COMPONENT.TASK` or `COMPONENT.SERVICE`.
    fn declared(&self, name: &str) -> Option<(Utf8PathBuf, Range<usize>)> {
        let (component, local) = name.split_once('.')?;
        let specs = self.problem.specs();
        let names = Names::new(&specs);
        let mut members = names.components.iter();
        let member = members.find(|member| member.component.name == component)?;
        let tasks = member.component.tasks.iter().map(|task| (&task.name, task.src));
        let services = member.component.services.iter().map(|service| (&service.name, service.src));
        let (_, src) = tasks.chain(services).find(|(own, _)| *own == local)?;
        self.problem.place(member.spec_index, src)
    }

    fn location(&self, path: &Utf8Path, range: &Range<usize>) -> Option<Location> {
        let (uri, lines) = self.texts.get(path)?;
        Some(Location::new(uri.clone(), lines.range(range)))
    }
}

/// The size of a system, as [`MAX_SIZE`] counts it.
fn size(system: &TimedSystem) -> usize {
    let of_machine = |machine: &Machine| {
        let states = machine.loop_limit.and_then(|_| unfolded(machine));
        let states = states.as_ref().unwrap_or(machine).states.iter();
        states.map(|state| 1 + system.codels[state.codel].conflicts.iter().count()).sum::<usize>()
    };
    system.machines.iter().map(of_machine).sum()
}
