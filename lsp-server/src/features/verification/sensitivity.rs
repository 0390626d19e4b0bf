//! `dotgen/sensitivity`: how much parameters can change before deadlines are missed, or must change to meet
//! them. The request is long, reports progress, and stops when cancelled. `docs/protocol.md` describes it for
//! clients.

use std::sync::Arc;

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::model::Src;
use dotgen_timing::derive::{Extreme, InterimResult, Sensitivity};
use dotgen_timing::report::TimeUnit;
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::build::build;
use dotgen_timing::verify::{Cancel, Options, settings};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answer::{CancelOnDrop, Prepared, VerificationParams, locate};
use crate::protocol::outbox::Outbox;
use crate::protocol::types::{
    ProgressParams, ProgressParamsValue, ProgressToken, TextDocumentIdentifier, WorkDoneProgress,
    WorkDoneProgressReport, notification,
};
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::verification::Problem;
use dotgen_views::verification::summary;
use dotgen_views::verification::what_if::WhatIf;

/// Parameters of `dotgen/sensitivity`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SensitivityParams {
    /// A scenario or a specification.
    pub(crate) text_document: TextDocumentIdentifier,
    /// A variation.
    #[serde(default)]
    what_if: WhatIf,
    /// The token for progress, which is reported after each question.
    #[serde(default)]
    pub(crate) work_done_token: Option<ProgressToken>,
}

impl SensitivityParams {
    /// The parameters of a verification with the same document and variation.
    pub(crate) fn verification(&self) -> VerificationParams {
        VerificationParams::about(self.text_document.clone(), self.what_if.clone())
    }
}

/// Answer of `dotgen/sensitivity`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SensitivityResult {
    /// Version of the analysed document.
    version: Option<i32>,
    /// The errors that prevent an answer.
    errors: Vec<String>,
    /// The deadlines that the limits concern: `every deadline`.
    deadlines: String,
    /// The smallest number of cores, as text.
    cores: String,
    /// Its restriction, if it is not certain.
    cores_remark: String,
    /// The largest WCET of each codel.
    wcet: Vec<Value>,
    /// The smallest period of each task.
    period: Vec<Value>,
    /// The most critical value of a system that meets its deadlines, as text.
    next_to_break: Option<String>,
}

/// The result for a document.
pub(crate) struct SensitivityAnswer {
    version: Option<i32>,
    problem: Arc<Problem>,
    options: Options,
    found: Result<Sensitivity, Vec<String>>,
}

/// Computes the answer. Dropping the future cancels the work.
pub(crate) async fn ask(
    prepared: Prepared,
    token: Option<ProgressToken>,
    to: &Outbox,
) -> SensitivityAnswer {
    let version = prepared.version();
    let (problem, options) = match prepared.varied() {
        Ok((problem, options)) => (Arc::new(problem), options),
        Err(errors) => {
            return SensitivityAnswer {
                version,
                problem: prepared.problem(),
                options: Options::default(),
                found: Err(errors),
            };
        }
    };
    let cancel = Arc::new(Cancel::default());
    let _guard = CancelOnDrop(cancel.clone());
    let to = to.clone();
    let (asked, with) = (problem.clone(), options.clone());
    let work = tokio::task::spawn_blocking(move || {
        asked.sensitivity(&with, &cancel, &|interim_result| {
            if let (Some(token), InterimResult::Asking(progress)) = (&token, interim_result) {
                to.notify::<notification::Progress>(ProgressParams {
                    token: token.clone(),
                    value: ProgressParamsValue::WorkDone(WorkDoneProgress::Report(
                        WorkDoneProgressReport {
                            cancellable: Some(true),
                            message: Some(progress.asking.clone()),
                            percentage: Some((100 * progress.done / progress.of) as u32),
                        },
                    )),
                });
            }
        })
    });
    let found = match work.await {
        Ok(found) => found.map_err(|all| {
            all.into_iter().map(|diagnostic| diagnostic.message.to_string()).collect()
        }),
        Err(error) => {
            tracing::error!("the search for limits panicked: {error}");
            Err(vec!["the search failed; the log says more".to_owned()])
        }
    };
    SensitivityAnswer { version, problem, options, found }
}

/// The answer for a client.
pub(crate) fn shown(
    snapshot: &Snapshot,
    _: &Subject,
    asked: &SensitivityAnswer,
) -> Cancellable<SensitivityResult> {
    let mut out = SensitivityResult { version: asked.version, ..SensitivityResult::default() };
    let found = match &asked.found {
        Ok(found) => found,
        Err(errors) => {
            out.errors.clone_from(errors);
            return Ok(out);
        }
    };
    let specs = asked.problem.specs();
    let names = Names::new(&specs);
    let settings = settings(&asked.problem.scenario, &asked.options);
    let (unit, system) = (TimeUnit::of(&settings), build(&names, &settings, &|_| true).system);
    let spec = |c: usize| names.components[c].spec_index;
    let codels = system.codels.iter();
    let codels = codels.map(|codel| {
        let src = codel.site.and_then(|(c, _)| Some((spec(c), codel.src?)));
        (codel.path.to_string(), src)
    });
    let tasks = system.tasks.iter();
    let tasks = tasks.map(|task| {
        let component = &system.components[task.component].name;
        let src = task.src.map(|(c, src)| (spec(c), src));
        (format!("{component}.{}", task.name), src)
    });
    let places: Vec<(String, Option<(usize, Src)>)> = codels.chain(tasks).collect();
    let show = |limit: &Extreme| -> Cancellable<Value> {
        let (extreme, remark) = summary::extreme(limit, unit);
        let place = places.iter().find(|(path, _)| *path == limit.of);
        Ok(json!({
            "of": limit.of,
            "now": unit.show_value(limit.now),
            "extreme": extreme,
            "remark": remark,
            "location": locate(snapshot, &asked.problem, place.and_then(|place| place.1))?,
        }))
    };
    out.deadlines = summary::deadlines(&settings);
    (out.cores, out.cores_remark) = summary::cores(&found.minimum_cores);
    let next = found.next_to_break.as_ref();
    out.next_to_break = next.map(|stop| summary::next_to_break(stop, unit));
    out.wcet = found.wcet.iter().map(show).collect::<Cancellable<_>>()?;
    out.period = found.period.iter().map(show).collect::<Cancellable<_>>()?;
    Ok(out)
}
