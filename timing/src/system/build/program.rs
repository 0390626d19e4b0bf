//! Clients as graphs of steps.

use super::Builder;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{self, Ending, Interval, Path, Step, StepKind, Trigger, Unit};
use crate::system::{Builtin, Client, ClientAction, ClientStep, FOREVER, ServiceId, Ticks};

/// Upper limit on the number of steps.
const STEPS: usize = 20_000;

/// The request that a tracker follows.
#[derive(Debug, Clone, PartialEq, Eq)]
enum TrackedRequest {
    /// The last request.
    Last,
    /// The last request for a service.
    Service(ServiceId),
    /// The last accepted request for an activity.
    Accepted(ServiceId),
    /// The last accepted request of the steps with a label.
    Labelled(String),
}

/// Compiles a client. `ticks` converts its times to base units.
pub(crate) fn compile(
    client: &ast::Client,
    builder: &Builder<'_>,
    ticks: &dyn Fn(u64, Unit) -> Ticks,
) -> Result<Client, Diagnostic> {
    let mut program = Program {
        steps: Vec::new(),
        trackers: Vec::new(),
        labels: labelled(&client.steps).collect(),
        builder,
        ticks,
        loops: 0,
        is_measure: client.trigger.is_some(),
    };
    program.followed(&client.steps)?;
    let mut first = program.sequence(&client.steps, vec![DONE])?;
    let mut awaits_event = None;
    if program.is_measure {
        let event = program.push(ClientAction::Delay(0, FOREVER), first, None);
        awaits_event = Some(event);
        first = vec![event];
    }
    let done = program.steps.len();
    for step in &mut program.steps {
        finish_list(&mut step.next, done);
    }
    finish_list(&mut first, done);
    if done > STEPS {
        let message = format!("this client has more than {STEPS} steps; repeat less often");
        return Err(Diagnostic::error("scn-client-size", client.name.range.clone(), message));
    }
    Ok(Client {
        name: client.name.value.clone(),
        steps: program.steps,
        first,
        trackers: program.trackers.len(),
        awaits_event,
    })
}

fn finish_list(next: &mut Vec<usize>, done: usize) {
    for index in &mut *next {
        if *index == DONE {
            *index = done;
        }
    }
    next.sort_unstable();
    next.dedup();
}

/// Placeholder for the position after the last step, until it is known.
const DONE: usize = usize::MAX;

/// Returns the labels of requests, each with the requested path.
pub(crate) fn labelled(steps: &[Step]) -> impl Iterator<Item = (&str, &Path)> {
    Step::all(steps).into_iter().filter_map(|step| match (&step.label, &step.kind) {
        (Some(label), StepKind::Send(path)) => Some((&*label.value, path)),
        _ => None,
    })
}

struct Program<'p> {
    steps: Vec<ClientStep>,
    trackers: Vec<TrackedRequest>,
    /// Labels of requests, each with the requested path.
    labels: Vec<(&'p str, &'p Path)>,
    builder: &'p Builder<'p>,
    ticks: &'p dyn Fn(u64, Unit) -> Ticks,
    /// Number of loops so far. Each has a number below [`DONE`] as a placeholder for its beginning.
    loops: usize,
    /// Its aborts interrupt all instances.
    is_measure: bool,
}

impl Program<'_> {
    /// Collects all requests to follow: requests whose end is awaited, instances that are aborted.
    fn followed(&mut self, steps: &[Step]) -> Result<(), Diagnostic> {
        for step in Step::all(steps) {
            let request = match &step.kind {
                StepKind::AwaitEnded(_, path) => self.awaited(path.as_ref())?,
                StepKind::Abort(path) if !self.interrupts(path) => self.aborted(path)?,
                _ => continue,
            };
            if !self.trackers.contains(&request) {
                self.trackers.push(request);
            }
        }
        Ok(())
    }

    /// Returns true if an abort of this path interrupts all instances.
    fn interrupts(&self, path: &Path) -> bool {
        self.is_measure && path.names.len() > 1
    }

    fn awaited(&self, path: Option<&Path>) -> Result<TrackedRequest, Diagnostic> {
        Ok(match path {
            None => TrackedRequest::Last,
            Some(path) => TrackedRequest::Service(self.builder.service(path)?),
        })
    }

    /// Returns the request that `abort` names: one for an activity, or one with a label.
    fn aborted(&self, path: &Path) -> Result<TrackedRequest, Diagnostic> {
        if let [name] = path.names.as_slice() {
            let mut requests = self.labels.iter().filter(|label| label.0 == name.value).peekable();
            if requests.peek().is_none() {
                let message = format!(
                    "`{0}` is no label of a request of this client; write `abort COMPONENT.ACTIVITY;`, or \
                        `{0}:` before a `send`",
                    name.value
                );
                return Err(Diagnostic::error("scn-abort", name.range.clone(), message));
            }
            for &(_, requested) in requests {
                self.builder.activity(requested)?;
            }
            return Ok(TrackedRequest::Labelled(name.value.clone()));
        }
        Ok(TrackedRequest::Accepted(self.builder.activity(path)?))
    }

    fn tracker(&self, of: &TrackedRequest) -> usize {
        self.trackers.iter().position(|tracker| tracker == of).unwrap_or(0)
    }

    /// Returns the action of a request of any kind.
    fn request(
        &self,
        service: ServiceId,
        label: Option<&str>,
        aborts: Option<usize>,
    ) -> ClientAction {
        let trackers = |follows: &dyn Fn(&TrackedRequest) -> bool| {
            let all = self.trackers.iter().enumerate();
            all.filter(|(_, tracked)| follows(tracked)).map(|(at, _)| at).collect()
        };
        ClientAction::Send {
            service,
            trackers: trackers(&|request| match request {
                TrackedRequest::Last => true,
                TrackedRequest::Service(of) => *of == service,
                TrackedRequest::Accepted(_) | TrackedRequest::Labelled(_) => false,
            }),
            accepted: trackers(&|request| match request {
                TrackedRequest::Last | TrackedRequest::Service(_) => false,
                TrackedRequest::Accepted(of) => *of == service,
                TrackedRequest::Labelled(of) => Some(of.as_str()) == label,
            }),
            aborts,
        }
    }

    /// Adds steps that continue at `next`, from last to first, and returns their beginnings.
    fn sequence(&mut self, steps: &[Step], next: Vec<usize>) -> Result<Vec<usize>, Diagnostic> {
        let mut next = next;
        for step in steps.iter().rev() {
            next = self.step(step, next)?;
        }
        Ok(next)
    }

    fn step(&mut self, step: &Step, next: Vec<usize>) -> Result<Vec<usize>, Diagnostic> {
        let label = step.label.as_ref().map(|label| label.value.clone());
        let action = match &step.kind {
            StepKind::Send(path) => {
                let service = self.builder.service(path)?;
                let name = path.names.last().map(|name| name.value.clone());
                let action = self.request(service, label.as_deref(), None);
                return Ok(vec![self.push(action, next, label.or(name))]);
            }
            StepKind::Stop => return Ok(next),
            StepKind::Abort(path) if self.interrupts(path) => {
                let service = self.builder.builtin(path, Builtin::Interrupt)?;
                let action = self.request(service, None, None);
                return Ok(vec![self.push(action, next, Some(Trigger::abort_label(path)))]);
            }
            StepKind::Abort(path) => {
                let aborted = self.aborted(path)?;
                let tracker = self.tracker(&aborted);
                let of = match path.names.as_slice() {
                    [name] => (self.labels.iter())
                        .find(|label| label.0 == name.value)
                        .map_or(path, |label| label.1),
                    _ => path,
                };
                let service = self.builder.builtin(of, Builtin::Abort)?;
                self.request(service, None, Some(tracker))
            }
            StepKind::Kill(path) => {
                let service = self.builder.builtin(path, Builtin::Kill)?;
                self.request(service, None, None)
            }
            StepKind::Connect(path) => {
                let service = self.builder.builtin(path, Builtin::Connect)?;
                self.request(service, None, None)
            }
            StepKind::AwaitAccepted(path) => {
                if let Some(path) = path {
                    self.builder.service(path)?;
                }
                ClientAction::AwaitAccepted
            }
            StepKind::AwaitEnded(ending, path) => {
                let tracker = self.tracker(&self.awaited(path.as_ref())?);
                let succeeded = match ending {
                    Ending::Any => {
                        let action = ClientAction::AwaitEnded(tracker);
                        return Ok(vec![self.push(action, next, label)]);
                    }
                    Ending::Ok => true,
                    Ending::Failed => false,
                };
                let action = ClientAction::AwaitOutcome(tracker, succeeded);
                let outcome = self.push(action, next, label.clone());
                return Ok(vec![self.push(ClientAction::AwaitAny, vec![outcome], label)]);
            }
            StepKind::Delay(Interval { lower, upper }, unit) => ClientAction::Delay(
                (self.ticks)(*lower, *unit),
                upper.map_or(FOREVER, |number| (self.ticks)(number, *unit)),
            ),
            StepKind::Repeat(Some(count), body) => {
                let mut next = next;
                for _ in 0..*count {
                    next = self.sequence(body, next)?;
                    if self.steps.len() > STEPS {
                        break;
                    }
                }
                return Ok(next);
            }
            StepKind::Repeat(None, body) => return self.forever(body, step),
            StepKind::Choice(branches) => {
                let mut first = Vec::new();
                for branch in branches {
                    first.extend(self.sequence(branch, next.clone())?);
                }
                return Ok(self.any_outcome(first));
            }
        };
        Ok(vec![self.push(action, next, label)])
    }

    /// Merges the branches that wait for an outcome: the first outcome to come is taken.
    fn any_outcome(&mut self, first: Vec<usize>) -> Vec<usize> {
        let waits = |&index: &usize| {
            let step = self.steps.get(index);
            step.is_some_and(|step| step.action == ClientAction::AwaitAny)
        };
        let (waiting, mut out): (Vec<usize>, Vec<usize>) = first.into_iter().partition(waits);
        match waiting.as_slice() {
            [] | [_] => out.extend(waiting),
            several => {
                let outcomes = several.iter().flat_map(|&step| &self.steps[step].next);
                let outcomes = outcomes.copied().collect();
                out.push(self.push(ClientAction::AwaitAny, outcomes, None));
            }
        }
        out
    }

    /// Adds a loop. The body is followed by its own beginning, which is known only afterwards.
    fn forever(&mut self, body: &[Step], step: &Step) -> Result<Vec<usize>, Diagnostic> {
        self.loops += 1;
        let beginning = DONE - self.loops;
        let first = self.sequence(body, vec![beginning])?;
        if first.contains(&beginning) {
            let message = "this repetition may do nothing for ever; add a step".to_owned();
            return Err(Diagnostic::error("scn-empty-repeat", step.range.clone(), message));
        }
        for step in &mut self.steps {
            if step.next.contains(&beginning) {
                step.next.retain(|&next| next != beginning);
                step.next.extend(&first);
            }
        }
        Ok(first)
    }

    fn push(&mut self, action: ClientAction, next: Vec<usize>, label: Option<String>) -> usize {
        self.steps.push(ClientStep { action, next, label });
        self.steps.len() - 1
    }
}
