//! The work of a verification: quick bounds, the exact answer, then the number of cores.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use camino::Utf8PathBuf;
use dotgen_timing::verify::{Cancel, Options};
use tokio::runtime::Handle;

use super::News;
use crate::session::post::Post;
use dotgen_platform::panic;
use dotgen_views::verification::Problem;
use dotgen_views::verification::run::{Interim, run};

/// Minimum interval between two results; results in between are sent together.
const RESULT_INTERVAL: Duration = Duration::from_millis(50);

pub(crate) struct JobResult {
    pub(crate) path: Utf8PathBuf,
    pub(crate) number: u64,
    pub(crate) found: Interim,
}

pub(super) struct Job {
    pub(super) path: Utf8PathBuf,
    pub(super) number: u64,
    pub(super) problem: Arc<Problem>,
    pub(super) options: Options,
    pub(super) limit: Duration,
}

impl Job {
    pub(super) fn spawn(self, cancel: Arc<Cancel>, events: Post<News>, runtime: &Handle) {
        let pace = runtime.clone();
        runtime.spawn_blocking(move || {
            let Job { path, number, problem, options, limit } = self;
            // The last interim answer that was not sent yet.
            let held: Arc<Mutex<Option<JobResult>>> = Arc::default();
            let send = |events: &Post<News>, answer: JobResult| {
                events.send(News::JobResult(Box::new(answer)));
            };
            let tell = |found: Interim| {
                let part = matches!(found, Interim::SoFar(_));
                let answer = JobResult { path: path.clone(), number, found };
                if !part {
                    return send(&events, answer);
                }
                if lock(&held).replace(answer).is_none() {
                    let (held, events) = (held.clone(), events.clone());
                    pace.spawn(async move {
                        tokio::time::sleep(RESULT_INTERVAL).await;
                        let kept = lock(&held).take();
                        if let Some(kept) = kept {
                            send(&events, kept);
                        }
                    });
                }
            };
            if let Err(message) = panic::isolate(|| run(problem, options, limit, &cancel, tell)) {
                tracing::error!(%path, "verification panicked: {message}");
            }
        });
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
