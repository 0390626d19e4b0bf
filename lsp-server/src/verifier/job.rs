//! The work itself: quick bounds, the exact answer, then the number of cores.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use camino::Utf8PathBuf;
use dotgen_timing::derive::minimum_cores;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::Verdict;
use dotgen_timing::verify::{Cancel, Options, SystemInput};
use tokio::runtime::Handle;
use tokio::sync::mpsc::{UnboundedSender, WeakUnboundedSender};

use super::Answer;
use crate::panic;
use crate::state::Event;
use crate::verification::{Problem, TaskBound, quick_bounds};

/// The number of cores is only asked for when the verification itself took at most so long: every
/// number is a verification of its own.
const QUICK_SECONDS: f64 = 1.0;

/// Answers that come sooner after others than this are told with them.
const PACE: Duration = Duration::from_millis(50);

/// One verification at a time: they are after the same memory, and the editor wants the other cores.
static TURN: Mutex<()> = Mutex::new(());

/// What was found on the way.
pub(crate) enum Found {
    /// Quick bounds.
    Bounds(Arc<Vec<TaskBound>>),
    /// What is known of the exact answer.
    SoFar(Arc<Answer>),
    /// The exact answer; again when the number of cores has come.
    Answer(Arc<Answer>),
}

/// News of a job.
pub(crate) struct Verified {
    pub(crate) path: Utf8PathBuf,
    pub(crate) number: u64,
    pub(crate) found: Found,
}

pub(super) struct Job {
    pub(super) path: Utf8PathBuf,
    pub(super) number: u64,
    pub(super) problem: Arc<Problem>,
    pub(super) options: Options,
    pub(super) limit: Duration,
}

impl Job {
    pub(super) fn spawn(
        self,
        cancel: Arc<Cancel>,
        events: UnboundedSender<Event>,
        runtime: &Handle,
    ) {
        // The writer goes when its queue is dropped: a job must not keep it.
        let events = events.downgrade();
        let pace = runtime.clone();
        runtime.spawn_blocking(move || {
            let Job {
                path,
                number,
                problem,
                options,
                limit,
            } = self;
            // The last part of an answer that was not told yet.
            let held: Arc<Mutex<Option<Verified>>> = Arc::default();
            let send = |events: &WeakUnboundedSender<Event>, it: Verified| {
                if let Some(events) = events.upgrade() {
                    let _ = events.send(Event::Verified(Box::new(it)));
                }
            };
            let tell = |found: Found| {
                let part = matches!(found, Found::SoFar(_));
                let it = Verified {
                    path: path.clone(),
                    number,
                    found,
                };
                if !part {
                    return send(&events, it);
                }
                if lock(&held).replace(it).is_none() {
                    let (held, events) = (held.clone(), events.clone());
                    pace.spawn(async move {
                        tokio::time::sleep(PACE).await;
                        let it = lock(&held).take();
                        it.into_iter().for_each(|it| send(&events, it));
                    });
                }
            };
            if let Err(message) = panic::isolate(|| run(problem, options, limit, &cancel, tell)) {
                tracing::error!(%path, "verification panicked: {message}");
            }
        });
    }
}

fn lock<T>(it: &Mutex<T>) -> MutexGuard<'_, T> {
    it.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Verifies within a time limit and tells what it finds. Tells nothing more once cancelled.
pub(crate) fn run(
    problem: Arc<Problem>,
    options: Options,
    limit: Duration,
    cancel: &Cancel,
    tell: impl Fn(Found) + Sync,
) {
    let _turn = lock(&TURN);
    if cancel.is_abandoned() {
        return;
    }
    cancel.limit(limit);
    let bounds = Arc::new(quick_bounds(&problem, &options));
    tell(Found::Bounds(bounds.clone()));
    let answer = |report, cores| {
        Arc::new(Answer {
            problem: problem.clone(),
            options: options.clone(),
            report,
            bounds: bounds.clone(),
            cores,
        })
    };
    let report = problem.verify(&options, cancel, &|so_far| {
        tell(Found::SoFar(answer(so_far.clone(), None)));
    });
    if cancel.is_abandoned() {
        return;
    }
    tell(Found::Answer(answer(report.clone(), None)));
    let deadlines = || {
        report
            .checks
            .iter()
            .filter(|it| it.kind == PropertyKind::Schedulable)
    };
    let worth_it = report.seconds < QUICK_SECONDS
        && deadlines().next().is_some()
        && deadlines().all(|it| it.verdict == Verdict::Proved);
    if worth_it && !cancel.is_over() {
        let input = SystemInput {
            specs: problem.specs(),
        };
        let cores = minimum_cores(&input, &problem.scenario, &options, cancel);
        let decided = |it: &dotgen_timing::derive::MinimumCores| {
            it.cores.is_some() && it.tried.iter().all(|it| it.1 != Verdict::Unknown)
        };
        if let Some(cores) = cores.ok().filter(decided)
            && !cancel.is_abandoned()
        {
            tell(Found::Answer(answer(report, Some(cores))));
        }
    }
}
