//! The threads of a host: each executes the codels of one task, on command of the engine or, if the task is
//! delegated, at its ticks by itself.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use dotgen_runtime::hosts::{Call, CodelEnd, CodelResult, DelegatedYield, Delegation};

use super::{CONTROL, ENGINE_ENDED, Host, alone, send, send_all};
use crate::clock::monotonic_nanos;
use crate::realtime;
use crate::wire::HostMessage;

/// Execution time of a codel after which its result is sent at once, and not at the end of the cycle, in
/// nanoseconds. Compared with this time, sending takes little.
const LONG_CODEL_NANOS: u64 = 100_000;

/// A command for a thread.
enum Job {
    Codel(Call),
    Cycles(Box<Delegation>),
    /// End the cycles.
    Recall,
}

/// The results of cycles that have not been sent.
#[derive(Default)]
struct Reports {
    unsent: Mutex<Vec<CodelResult>>,
}

impl Reports {
    fn lock(&self) -> MutexGuard<'_, Vec<CodelResult>> {
        self.unsent.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Sends the results, in order, also if two threads do so.
    fn send(&self, unsent: &mut Vec<CodelResult>, host: &Host) -> io::Result<()> {
        if unsent.is_empty() {
            return Ok(());
        }
        let messages: Vec<_> = unsent.drain(..).map(HostMessage::CodelResult).collect();
        send_all(&host.output, &messages)
    }
}

/// A thread that executes the codels of a task, one after the other.
pub(super) struct Lane {
    jobs: Sender<Job>,
    reports: Arc<Reports>,
}

impl Lane {
    /// Starts the thread. `core` is the core to which it is bound, if the host has real-time rights.
    pub(super) fn start(number: u32, host: &Arc<Host>, core: Option<u32>) -> Lane {
        let (jobs, queue) = channel();
        let reports = Arc::<Reports>::default();
        let worker = Worker { number, host: host.clone(), reports: reports.clone(), queue };
        let task = host.options.tasks.get(&number);
        let name = task.map_or(CONTROL, |task| &task.name);
        let priority = task.map_or(host.options.control_priority, |task| task.priority);
        let thread = std::thread::Builder::new().name(name.to_owned());
        let work = move || {
            worker.prepare(priority, core);
            worker.work();
        };
        if thread.spawn(work).is_err() {
            // The engine reports the component as lost, as after a crash.
            std::process::exit(2);
        }
        Lane { jobs, reports }
    }

    pub(super) fn run(&self, call: Call) {
        let _ = self.jobs.send(Job::Codel(call));
    }

    pub(super) fn delegate(&self, delegation: Delegation) {
        let _ = self.jobs.send(Job::Cycles(Box::new(delegation)));
    }

    pub(super) fn recall(&self) {
        let _ = self.jobs.send(Job::Recall);
    }

    /// Sends all results of cycles, and the time until which they are all.
    pub(super) fn probe(&self, host: &Host, probe: u32) -> io::Result<()> {
        let mut unsent = self.reports.lock();
        let until = monotonic_nanos();
        self.reports.send(&mut unsent, host)?;
        send(&host.output, HostMessage::Probed { probe, until })
    }
}

enum CycleEnd {
    /// The automaton pauses in a state, since a time in nanoseconds.
    Paused(usize, u64),
    /// The engine decides what follows.
    Over,
}

struct Worker {
    number: u32,
    host: Arc<Host>,
    reports: Arc<Reports>,
    queue: Receiver<Job>,
}

impl Worker {
    /// Gives the thread its priority and its core.
    fn prepare(&self, priority: u8, core: Option<u32>) {
        let options = &self.host.options;
        if !options.real_time {
            return;
        }
        if options.raised {
            realtime::raise_priority(priority);
        }
        if let Some(core) = core.filter(|&core| !realtime::pin(core)) {
            // Without a channel nothing can be reported.
            let denied = HostMessage::Denied(format!("core {core}"));
            let _ = send(&self.host.output, denied);
        }
    }

    fn work(&self) {
        while let Ok(job) = self.queue.recv() {
            let sent = match job {
                Job::Codel(call) => {
                    let ran = self.execute(call.ticket, call.codel, call.instance);
                    send(&self.host.output, HostMessage::CodelResult(ran))
                }
                Job::Cycles(delegation) => self.cycles(&delegation),
                // The cycles have ended by themselves.
                Job::Recall => Ok(()),
            };
            if sent.is_err() {
                // Results have no receiver.
                alone::stop(&self.host, ENGINE_ENDED);
            }
        }
    }

    fn execute(&self, ticket: u32, codel: u32, instance: u32) -> CodelResult {
        self.host.activities.begin(codel, instance);
        let begun = monotonic_nanos();
        self.note_executing(Some((codel, begun)));
        let outcome = self.host.component.run(codel, instance);
        let ended = monotonic_nanos();
        self.note_executing(None);
        self.host.activities.end(codel, instance, &outcome);
        CodelResult {
            ticket,
            codel,
            nanos: ended.saturating_sub(begun),
            ended,
            how: outcome.how,
            name: outcome.name,
            detail: outcome.detail,
            written: outcome.written,
        }
    }

    /// Executes cycles until the engine recalls them or must decide.
    fn cycles(&self, delegation: &Delegation) -> io::Result<()> {
        let ticket = delegation.call.ticket;
        let (mut tick, mut state) = (delegation.first_tick, delegation.state);
        while self.is_due(tick) {
            let end = self.cycle(delegation, state)?;
            let mut unsent = self.reports.lock();
            self.reports.send(&mut unsent, &self.host)?;
            drop(unsent);
            let CycleEnd::Paused(next, ended) = end else {
                break;
            };
            state = next;
            // Several ticks during a cycle count as one: the next cycle begins at once.
            let passed = ended.saturating_sub(tick) / delegation.period.max(1);
            tick += passed.max(1) * delegation.period;
        }
        send(&self.host.output, HostMessage::Recalled { ticket })
    }

    fn note_executing(&self, executes: Option<(u32, u64)>) {
        if let Some(executing) = &self.host.executing {
            executing.set(self.number, executes);
        }
    }

    /// Waits until a tick. Returns false if the engine recalls the cycles.
    fn is_due(&self, tick: u64) -> bool {
        let left = Duration::from_nanos(tick.saturating_sub(monotonic_nanos()));
        matches!(self.queue.recv_timeout(left), Err(RecvTimeoutError::Timeout))
    }

    /// Executes codels from a state on, until the automaton pauses.
    fn cycle(&self, delegation: &Delegation, mut state: usize) -> io::Result<CycleEnd> {
        let call = &delegation.call;
        while let Some(entry) = delegation.states.get(state) {
            let mut ran = self.execute(call.ticket, entry.codel, call.instance);
            let next = match ran.how {
                CodelEnd::Event => entry.next_of(&ran.name),
                _ => None,
            };
            let long = ran.nanos >= LONG_CODEL_NANOS;
            let mut unsent = self.reports.lock();
            // A probe that has not sent this result has an earlier time.
            ran.ended = monotonic_nanos();
            let ended = ran.ended;
            unsent.push(ran);
            match next {
                Some(DelegatedYield::Next(to)) => state = to,
                Some(DelegatedYield::Pause(to)) => return Ok(CycleEnd::Paused(to, ended)),
                None => break,
            }
            if long {
                self.reports.send(&mut unsent, &self.host)?;
            }
            drop(unsent);
            if !matches!(self.queue.try_recv(), Err(TryRecvError::Empty)) {
                break;
            }
        }
        Ok(CycleEnd::Over)
    }
}
