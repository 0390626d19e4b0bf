//! Requests that read: admission by the writer in order of arrival, work on the blocking pool, then the
//! answer or an error.
//!
//! - A change that arrives during the work cancels it. The work is repeated if the document of the request is
//!   unchanged; otherwise the client gets `ContentModified`.
//! - A client that cancels drops the future here; the guard then stops the work too.
//! - A panic is an internal error of that request and affects no other request.

use std::pin::{Pin, pin};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use dotgen_analysis::host::{Cancellable, CancellationToken, Cancelled};
use dotgen_analysis::progress::Progress;
use tokio::sync::{Notify, Semaphore, oneshot};

use crate::features::features_of;
use crate::features::language::{Handler, LanguageFeatures};
use crate::protocol::outbox::Outbox;
use crate::protocol::progress::ProgressReporter;
use crate::protocol::types::{self, MessageType, Uri};
use crate::session::post::Post;
use crate::workspace::snapshot::{Snapshot, Subject, or_empty};
use dotgen_platform::panic;

/// Maximum number of attempts of a request. At the start the list of files and the settings arrive shortly
/// after one another. More attempts would make the client wait too long if other files change often.
const MAX_ATTEMPTS: u32 = 4;

/// Interval at which the progress of an answer is read.
const TICK: Duration = Duration::from_millis(100);

/// Number of ticks after which progress is shown.
const TICKS_BEFORE_PROGRESS: u32 = 5;

/// A request on its way to the writer.
pub(crate) struct ReadRequest {
    /// The document of the request; `None` for the workspace.
    pub(crate) subject: Option<Uri>,
    /// True if the request reads many files.
    pub(crate) bulk: bool,
    /// True if the request needs the whole workspace: it waits until all files are known.
    pub(crate) whole: bool,
    /// True if the answer contains edits: files that changed on disk are read again first.
    pub(crate) edits: bool,
    /// True if the files of the workspace were listed for this request.
    pub(crate) is_listed: bool,
    /// Version of that document at the first attempt.
    pub(crate) expected: Option<Option<i32>>,
    /// For cancellation by the client.
    pub(crate) control: Arc<Control>,
    /// Runs on the blocking pool.
    pub(crate) work: Box<dyn FnOnce(Admission) + Send>,
}

/// The decision of the writer on a request.
pub(crate) enum Admission {
    /// The request may run.
    Admitted(Box<Snapshot>, Option<Subject>),
    /// The document is unknown: neither open nor on disk, or different from the client's text.
    UnknownDocument,
    /// The document changed since the first attempt.
    Outdated,
}

/// The cancellation of a request, shared by the waiting handler and the working thread.
#[derive(Default)]
pub(crate) struct Control {
    cancelled: AtomicBool,
    token: Mutex<Option<CancellationToken>>,
}

impl Control {
    /// True if the client no longer waits.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Acquire)
    }

    /// Lets the snapshot of `token` be cancelled.
    pub(crate) fn attach(&self, token: CancellationToken) {
        *self.token.lock().unwrap_or_else(PoisonError::into_inner) = Some(token);
        if self.is_cancelled() {
            self.cancel();
        }
    }

    fn cancel(&self) {
        self.cancelled.store(true, Ordering::Release);
        let token = self.token.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(token) = &*token {
            token.cancel();
        }
    }
}

struct CancelOnDrop(Arc<Control>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// The state of the work, for the waiting handler.
#[derive(Default)]
struct HandlerState {
    progress: Arc<Progress>,
    /// The work has begun, and the client can show progress.
    wanted: AtomicBool,
}

impl HandlerState {
    fn percent(&self) -> u32 {
        let (done, known) = self.progress.parts();
        u32::try_from(done * 100 / known.max(1)).unwrap_or(100)
    }
}

enum HandlerResult<R> {
    Done(R),
    Unknown,
    Outdated,
    Cancelled(Option<i32>),
    Panicked(String),
}

/// The scope of a request, in addition to its document.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RequestScope {
    /// Many files.
    bulk: bool,
    /// All of the workspace.
    whole: bool,
    /// The answer contains edits.
    edits: bool,
}

impl RequestScope {
    /// An answer with edits.
    pub(crate) const EDITS: RequestScope = RequestScope { bulk: false, whole: false, edits: true };
    /// Many files.
    pub(crate) const BULK: RequestScope = RequestScope { bulk: true, whole: false, edits: false };
}

/// Sends requests to the writer and waits for their results.
#[derive(Clone)]
pub(crate) struct Dispatcher {
    reads: Post<ReadRequest>,
    background: Arc<Semaphore>,
    panic_shown: Arc<AtomicBool>,
    outbox: Outbox,
    running: ProgressReporter,
}

impl Dispatcher {
    pub(crate) fn new(reads: Post<ReadRequest>, outbox: Outbox) -> Dispatcher {
        Dispatcher {
            reads,
            background: Arc::new(Semaphore::new(2)),
            panic_shown: Arc::default(),
            running: ProgressReporter::new(outbox.client().clone()),
            outbox,
        }
    }

    /// The client, for commands that ask the user.
    pub(crate) fn client(&self) -> &types::Client {
        self.outbox.client()
    }

    /// The progress shown by the client.
    pub(crate) fn running(&self) -> &ProgressReporter {
        &self.running
    }

    /// Messages in order.
    pub(crate) fn outbox(&self) -> &Outbox {
        &self.outbox
    }

    /// Asks the client to show a place.
    pub(crate) fn show(&self, place: types::Location) {
        self.outbox.run_conversation(|client| async move {
            let params = types::ShowDocumentParams {
                uri: place.uri,
                external: None,
                take_focus: Some(true),
                selection: Some(place.range),
            };
            if let Err(error) = client.show_document(params).await {
                tracing::warn!("the client shows nothing: {error}");
            }
        });
    }

    /// A request beyond the protocol, or for diagnostics, about a document of dotgen's own languages. Empty
    /// for documents in other languages and unknown documents.
    pub(crate) async fn document<P, R>(
        &self,
        uri: Uri,
        params: P,
        handler: fn(&Snapshot, &Subject, &P) -> Cancellable<R>,
    ) -> types::Result<R>
    where
        P: Send + Sync + 'static,
        R: Default + Send + 'static,
    {
        let scope = RequestScope::default();
        let work = move |features: &LanguageFeatures, snapshot: &_, subject: &_, params: &_| {
            if features.is_own { handler(snapshot, subject, params) } else { Ok(R::default()) }
        };
        self.language(scope, uri, params, work).await
    }

    /// A request that the language of the document answers, with one of its features.
    pub(crate) async fn feature<P, R>(
        &self,
        uri: Uri,
        params: P,
        feature: fn(&LanguageFeatures) -> Handler<P, R>,
    ) -> types::Result<R>
    where
        P: Send + Sync + 'static,
        R: Default + Send + 'static,
    {
        let work = move |features: &LanguageFeatures, snapshot: &_, subject: &_, params: &_| {
            or_empty(feature(features)(snapshot, subject, params))
        };
        self.language(RequestScope::default(), uri, params, work).await
    }

    /// A request whose answer depends on the language of the document.
    pub(crate) async fn language<P, R>(
        &self,
        scope: RequestScope,
        uri: Uri,
        params: P,
        handler: impl Fn(&LanguageFeatures, &Snapshot, &Subject, &P) -> Cancellable<R>
        + Send
        + Copy
        + 'static,
    ) -> types::Result<R>
    where
        P: Send + Sync + 'static,
        R: Default + Send + 'static,
    {
        let work = move |snapshot: &Snapshot, subject: Option<&Subject>, params: &P| match subject {
            Some(subject) => {
                let features = features_of(snapshot, &subject.path);
                handler(features, snapshot, subject, params)
            }
            None => Ok(R::default()),
        };
        self.run(Some(uri), scope, params, Arc::default(), work).await
    }

    /// A request whose answer is wrong if a part of the workspace is unknown: an edit of every place. It
    /// waits until all files are listed, with progress. If the answer then takes long, its progress is shown
    /// too, and the user can cancel it.
    pub(crate) async fn everywhere<P, R>(
        &self,
        title: &str,
        uri: Option<Uri>,
        params: P,
        handler: fn(&Snapshot, Option<&Subject>, &P) -> Cancellable<R>,
    ) -> types::Result<R>
    where
        P: Send + Sync + 'static,
        R: Default + Send + 'static,
    {
        let _permit = self.background.acquire().await;
        let work = move |snapshot: &Snapshot, subject: Option<&Subject>, params: &P| {
            handler(snapshot, subject, params)
        };
        let about = RequestScope { whole: true, bulk: true, edits: true };
        let seen = Arc::new(HandlerState::default());
        let answer = pin!(self.run(uri, about, params, seen.clone(), work));
        self.shown(title, &seen, answer).await
    }

    /// Waits for an answer, and shows progress if the answer takes long.
    async fn shown<R>(
        &self,
        title: &str,
        seen: &HandlerState,
        mut answer: Pin<&mut impl Future<Output = types::Result<R>>>,
    ) -> types::Result<R> {
        let mut ticks = tokio::time::interval(TICK);
        ticks.tick().await;
        for _ in 0..TICKS_BEFORE_PROGRESS {
            tokio::select! {
                answer = &mut answer => return answer,
                _ = ticks.tick() => {}
            }
        }
        // Until the request is admitted, the progress of the listing is shown.
        while !seen.wanted.load(Ordering::Acquire) {
            tokio::select! {
                answer = &mut answer => return answer,
                _ = ticks.tick() => {}
            }
        }
        let running = tokio::select! {
            answer = &mut answer => return answer,
            running = self.running.create() => running,
        };
        let Some(running) = running else {
            return answer.await;
        };
        let stopped = Arc::new(Notify::new());
        let stop = stopped.clone();
        running.show(title, move || stop.notify_one()).await;
        let mut told = 0;
        let answer = loop {
            tokio::select! {
                answer = &mut answer => break answer,
                () = stopped.notified() => break Err(types::Error::request_cancelled()),
                _ = ticks.tick() => {
                    let percent = seen.percent();
                    if percent > told {
                        told = percent;
                        running.report(told).await;
                    }
                }
            }
        };
        running.end().await;
        answer
    }

    /// A request whose parameters do not name a document: the resolve of an item, or one about the workspace.
    /// The number of requests about many files at a time is limited, so that other requests are answered.
    pub(crate) async fn anywhere<P, R>(
        &self,
        scope: RequestScope,
        params: P,
        handler: fn(&Snapshot, &P) -> Cancellable<R>,
    ) -> types::Result<R>
    where
        P: Send + Sync + 'static,
        R: Default + Send + 'static,
    {
        let _permit = if scope.bulk { self.background.acquire().await.ok() } else { None };
        let work =
            move |snapshot: &Snapshot, _: Option<&Subject>, params: &P| handler(snapshot, params);
        self.run(None, scope, params, Arc::default(), work).await
    }

    async fn run<P, R, F>(
        &self,
        uri: Option<Uri>,
        about: RequestScope,
        params: P,
        seen: Arc<HandlerState>,
        work: F,
    ) -> types::Result<R>
    where
        P: Send + Sync + 'static,
        R: Default + Send + 'static,
        F: Fn(&Snapshot, Option<&Subject>, &P) -> Cancellable<R> + Send + Copy + 'static,
    {
        let params = Arc::new(params);
        let control = Arc::new(Control::default());
        let _guard = CancelOnDrop(control.clone());
        let mut expected = None;
        for _attempt in 0..MAX_ATTEMPTS {
            let (reply, answer) = oneshot::channel();
            let (params, seen) = (params.clone(), seen.clone());
            self.reads.send(ReadRequest {
                subject: uri.clone(),
                bulk: about.bulk,
                whole: about.whole,
                edits: about.edits,
                is_listed: false,
                expected,
                control: control.clone(),
                work: Box::new(move |admission| {
                    // The client may have disconnected.
                    let _ = reply.send(attempt(admission, &*params, &seen, work));
                }),
            });
            match answer.await {
                Ok(HandlerResult::Done(value)) => return Ok(value),
                Ok(HandlerResult::Unknown) => return Ok(R::default()),
                Ok(HandlerResult::Outdated) => break,
                Ok(HandlerResult::Cancelled(version)) => expected = Some(version),
                Ok(HandlerResult::Panicked(message)) => return Err(self.panicked(&message)),
                Err(_) => return Err(types::Error::request_cancelled()),
            }
        }
        Err(types::Error::content_modified())
    }

    fn panicked(&self, message: &str) -> types::Error {
        tracing::error!("a request panicked: {message}");
        if !self.panic_shown.swap(true, Ordering::Relaxed) {
            let text = format!("dotgen met an internal error and goes on: {message}");
            self.outbox.show(MessageType::ERROR, text);
        }
        let mut error = types::Error::internal_error();
        error.message = format!("internal error: {message}").into();
        error
    }
}

/// One attempt, on the blocking pool. The snapshot is dropped before this function returns.
fn attempt<P, R>(
    admission: Admission,
    params: &P,
    seen: &HandlerState,
    work: impl Fn(&Snapshot, Option<&Subject>, &P) -> Cancellable<R>,
) -> HandlerResult<R> {
    let (snapshot, subject) = match admission {
        Admission::Admitted(mut snapshot, subject) => {
            snapshot.progress = seen.progress.clone();
            let wanted = snapshot.client.progress;
            seen.wanted.store(wanted, Ordering::Release);
            (snapshot, subject)
        }
        Admission::UnknownDocument => return HandlerResult::Unknown,
        Admission::Outdated => return HandlerResult::Outdated,
    };
    let question = std::any::type_name::<P>();
    let path = subject.as_ref().map(|subject| subject.path.as_str());
    let version = subject.as_ref().and_then(|subject| subject.version);
    let _span = tracing::debug_span!("request", question, path, version).entered();
    let start = Instant::now();
    let result = panic::isolate(|| work(&snapshot, subject.as_ref(), params));
    tracing::debug!(elapsed = ?start.elapsed(), ok = matches!(result, Ok(Ok(_))), "answered");
    match result {
        Ok(Ok(value)) => HandlerResult::Done(value),
        // Salsa reports `PropagatedPanic` for any unwinding of the thread that this one waited for. The cause
        // is nearly always a pending write. After a true panic the next attempt panics itself.
        Ok(Err(Cancelled::PendingWrite | Cancelled::Local | Cancelled::PropagatedPanic)) => {
            HandlerResult::Cancelled(version)
        }
        Err(message) => HandlerResult::Panicked(message),
    }
}
