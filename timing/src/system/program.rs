//! Clients as graphs of steps.

use super::{Client, ClientAction, ClientStep, FOREVER, Ticks};
use crate::scn::Diagnostic;
use crate::scn::ast::{self, Interval, Path, Step, StepKind, Unit};

/// More steps than this are refused.
const STEPS: usize = 20_000;

/// Looks paths of services up.
pub(crate) type Resolve<'r> = &'r dyn Fn(&Path) -> Result<usize, Diagnostic>;

/// Compiles a client. `ticks` converts its times.
pub(crate) fn compile(
    client: &ast::Client,
    resolve: Resolve,
    ticks: &dyn Fn(u64, Unit) -> Ticks,
) -> Result<Client, Diagnostic> {
    let mut trackers = Vec::new();
    awaited(&client.steps, resolve, &mut trackers)?;
    let mut program = Program {
        steps: Vec::new(),
        trackers,
        resolve,
        ticks,
        loops: 0,
    };
    let first = program.sequence(&client.steps, vec![DONE])?;
    let done = program.steps.len();
    for step in &mut program.steps {
        finish_list(&mut step.next, done);
    }
    let mut first = first;
    finish_list(&mut first, done);
    if done > STEPS {
        let message = format!("this client has more than {STEPS} steps; repeat less often");
        return Err(Diagnostic::error(
            "scn-client-size",
            client.name.range.clone(),
            message,
        ));
    }
    Ok(Client {
        name: client.name.value.clone(),
        steps: program.steps,
        first,
        trackers: program.trackers.len(),
    })
}

fn finish_list(next: &mut Vec<usize>, done: usize) {
    for it in &mut *next {
        if *it == DONE {
            *it = done;
        }
    }
    next.sort_unstable();
    next.dedup();
}

/// Stands for the position after the last step until that is known.
const DONE: usize = usize::MAX;

/// Requests whose end is awaited: `None` for "the last one".
fn awaited(
    steps: &[Step],
    resolve: Resolve,
    out: &mut Vec<Option<usize>>,
) -> Result<(), Diagnostic> {
    for step in steps {
        match &step.kind {
            StepKind::AwaitEnded(path) => {
                let service = path.as_ref().map(resolve).transpose()?;
                if !out.contains(&service) {
                    out.push(service);
                }
            }
            StepKind::Repeat(_, body) => awaited(body, resolve, out)?,
            StepKind::Choice(branches) => {
                for branch in branches {
                    awaited(branch, resolve, out)?;
                }
            }
            _ => {}
        }
    }
    Ok(())
}

struct Program<'p> {
    steps: Vec<ClientStep>,
    trackers: Vec<Option<usize>>,
    resolve: Resolve<'p>,
    ticks: &'p dyn Fn(u64, Unit) -> Ticks,
    /// Loops whose beginning has been stood for by a number below [`DONE`].
    loops: usize,
}

impl Program<'_> {
    /// Adds steps that go on at `next`; returns where they begin. From last to first.
    fn sequence(&mut self, steps: &[Step], next: Vec<usize>) -> Result<Vec<usize>, Diagnostic> {
        let mut next = next;
        for step in steps.iter().rev() {
            next = self.step(step, next)?;
        }
        Ok(next)
    }

    fn step(&mut self, step: &Step, next: Vec<usize>) -> Result<Vec<usize>, Diagnostic> {
        let label = step.label.as_ref().map(|it| it.value.clone());
        let action = match &step.kind {
            StepKind::Send(path) => {
                let service = (self.resolve)(path)?;
                let trackers = (0..self.trackers.len())
                    .filter(|&it| self.trackers[it].is_none_or(|it| it == service))
                    .collect();
                let name = path.names.last().map(|it| it.value.clone());
                let action = ClientAction::Send { service, trackers };
                return Ok(vec![self.push(action, next, label.or(name))]);
            }
            StepKind::AwaitAccepted(path) => {
                if let Some(path) = path {
                    (self.resolve)(path)?;
                }
                ClientAction::AwaitAccepted
            }
            StepKind::AwaitEnded(path) => {
                let service = path.as_ref().map(self.resolve).transpose()?;
                let tracker = self.trackers.iter().position(|it| *it == service);
                ClientAction::AwaitEnded(tracker.unwrap_or(0))
            }
            StepKind::Delay(Interval { lower, upper }, unit) => ClientAction::Delay(
                (self.ticks)(*lower, *unit),
                upper.map_or(FOREVER, |it| (self.ticks)(it, *unit)),
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
                return Ok(first);
            }
        };
        Ok(vec![self.push(action, next, label)])
    }

    /// What follows the body is its own beginning, known only afterwards.
    fn forever(&mut self, body: &[Step], step: &Step) -> Result<Vec<usize>, Diagnostic> {
        self.loops += 1;
        let beginning = DONE - self.loops;
        let first = self.sequence(body, vec![beginning])?;
        if first.contains(&beginning) {
            let message = "this repetition may do nothing for ever; add a step".to_owned();
            return Err(Diagnostic::error(
                "scn-empty-repeat",
                step.range.clone(),
                message,
            ));
        }
        for it in &mut self.steps {
            if it.next.contains(&beginning) {
                it.next.retain(|&it| it != beginning);
                it.next.extend(&first);
            }
        }
        Ok(first)
    }

    fn push(&mut self, action: ClientAction, next: Vec<usize>, label: Option<String>) -> usize {
        self.steps.push(ClientStep {
            action,
            next,
            label,
        });
        self.steps.len() - 1
    }
}
