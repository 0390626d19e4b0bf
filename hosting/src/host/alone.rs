//! A host without an engine: it executes the `stop` codels of its activities by itself, and ends.
//!
//! The host knows the state machines of its component, and follows each activity by the codels that the
//! engine lets it execute. If the engine has ended, or gives no sign of life, no thread begins a further
//! codel. Activities are stopped one after the other, in the order of an orderly end.

use std::io::Write as _;
use std::sync::mpsc::channel;
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use dotgen_runtime::hosts::{CodelEnd, DelegatedYield, HostMachine};

use super::Host;
use crate::executing::Executing;
use crate::library::CodelOutcome;
use crate::realtime;

/// Exit status of a host that had no engine.
pub(crate) const STATUS: i32 = 113;

/// The name of the thread that watches the engine.
const WATCH: &str = "watch";

/// Looks for a sign of the engine within the time that it has for one. If this machine stands still, all of
/// its processes do: one look tells nothing.
const LOOKS: u32 = 10;

/// The activities of a host, and its codels under way.
#[derive(Default)]
pub(super) struct Activities {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    machines: Vec<HostMachine>,
    all: Vec<Activity>,
    /// Number of codels under way.
    running: usize,
    /// The engine is gone: no thread begins a codel.
    alone: bool,
}

/// An activity, or a permanent one, that has begun and not ended.
#[derive(Debug, Clone)]
struct Activity {
    machine: usize,
    /// 0 for a permanent activity.
    instance: u32,
    /// Present or next state.
    state: usize,
    /// It has been in its state `stop`.
    stopping: bool,
    /// A codel is under way.
    running: bool,
}

impl Activities {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Sets the machines of the component.
    pub(super) fn set_machines(&self, machines: Vec<HostMachine>) {
        self.lock().machines = machines;
    }

    /// Notes that a codel begins. Does not return if the engine is gone.
    pub(super) fn begin(&self, codel: u32, instance: u32) {
        let mut state = self.lock();
        while state.alone {
            state = self.changed.wait(state).unwrap_or_else(std::sync::PoisonError::into_inner);
        }
        state.running += 1;
        state.begin(codel, instance);
    }

    /// Notes that a codel has ended.
    pub(super) fn end(&self, codel: u32, instance: u32, outcome: &CodelOutcome) {
        let mut state = self.lock();
        state.running -= 1;
        state.end(codel, instance, outcome);
        if state.running == 0 {
            self.changed.notify_all();
        }
    }

    /// Forgets a request that the engine has ended.
    pub(super) fn forget(&self, instance: u32) {
        self.lock().all.retain(|activity| activity.instance != instance);
    }

    /// Lets no thread begin a codel, and waits for those under way. Returns the activities, in the order in
    /// which they stop. Does not return if another thread does the same.
    fn leave_alone(&self, within: Duration) -> Vec<(Activity, HostMachine)> {
        let mut state = self.lock();
        while state.alone {
            state = self.changed.wait(state).unwrap_or_else(std::sync::PoisonError::into_inner);
        }
        state.alone = true;
        let waited = self.changed.wait_timeout_while(state, within, |state| state.running > 0);
        let state = waited.unwrap_or_else(std::sync::PoisonError::into_inner).0;
        let with_machine = |activity: &Activity| {
            let machine = state.machines.get(activity.machine)?;
            Some((activity.clone(), machine.clone()))
        };
        let mut all: Vec<_> = state.all.iter().filter_map(with_machine).collect();
        // Activities in the order of the tasks, then permanent ones, the last task first.
        all.sort_by_key(|(activity, machine)| match activity.instance {
            0 => (1, u32::MAX - machine.lane),
            _ => (0, machine.lane),
        });
        all
    }
}

impl State {
    fn machine(&self, codel: u32) -> Option<usize> {
        let has = |machine: &HostMachine| machine.states.iter().any(|state| state.codel == codel);
        self.machines.iter().position(has)
    }

    fn begin(&mut self, codel: u32, instance: u32) {
        let Some(number) = self.machine(codel) else { return };
        let machine = &self.machines[number];
        let is = |state: &usize| machine.states.get(*state).is_some_and(|at| at.codel == codel);
        let known =
            |activity: &&mut Activity| activity.machine == number && activity.instance == instance;
        let known = self.all.iter_mut().find(known);
        // A codel of another state than the next one: the activity begins, or is interrupted.
        let next = known.as_ref().map(|activity| activity.state).filter(&is);
        let state = next.or(machine.stop.filter(&is));
        let state = state.or_else(|| (0..machine.states.len()).find(&is)).unwrap_or(0);
        let stopping = machine.stop == Some(state);
        match known {
            Some(activity) => {
                activity.state = state;
                activity.stopping |= stopping;
                activity.running = true;
            }
            None => self.all.push(Activity {
                machine: number,
                instance,
                state,
                stopping,
                running: true,
            }),
        }
    }

    fn end(&mut self, codel: u32, instance: u32, outcome: &CodelOutcome) {
        let Some(number) = self.machine(codel) else { return };
        let machine = &self.machines[number];
        self.all.retain_mut(|activity| {
            if activity.machine != number || activity.instance != instance {
                return true;
            }
            activity.running = false;
            match next(machine, activity.state, outcome) {
                Some(DelegatedYield::Next(to) | DelegatedYield::Pause(to)) => activity.state = to,
                None => return false,
            }
            true
        });
    }
}

/// Returns the state after a codel; `None` if the activity ends.
fn next(machine: &HostMachine, state: usize, outcome: &CodelOutcome) -> Option<DelegatedYield> {
    match outcome.how {
        CodelEnd::Event => machine.states.get(state)?.next_of(&outcome.name),
        _ => None,
    }
}

/// Watches the engine by its heartbeat, and stops this host if there is none.
pub(super) fn watch(host: &Arc<Host>) {
    let within = host.options.engine_within;
    if within.is_zero() || host.executing.is_none() {
        return;
    }
    let host = host.clone();
    let work = move || {
        if host.options.raised {
            realtime::raise_priority(realtime::ENGINE_PRIORITY);
        }
        let beats = || host.executing.as_ref().map_or(0, Executing::beats);
        let (mut last, mut quiet) = (beats(), 0);
        while quiet < LOOKS {
            std::thread::sleep(within / LOOKS);
            let beats = beats();
            quiet = if beats == last { quiet + 1 } else { 0 };
            last = beats;
        }
        let seconds = within.as_secs_f64();
        stop(&host, &format!("the engine gave no sign of life for {seconds} s"));
    };
    // Without the thread, the end of the channel is still seen.
    let _ = std::thread::Builder::new().name(WATCH.to_owned()).spawn(work);
}

/// Stops all activities without the engine, prints the reason `why` if there are any, and ends the process.
pub(super) fn stop(host: &Arc<Host>, why: &str) -> ! {
    let until = Instant::now() + host.options.stop_within;
    // Codels that wait for other components get no answer any more.
    host.waiting.lock().unwrap_or_else(std::sync::PoisonError::into_inner).all.clear();
    let all = host.activities.leave_alone(host.options.stop_within / 2);
    let (mut stopped, mut left) = (Vec::new(), Vec::new());
    let count = all.len();
    for (number, (activity, machine)) in all.into_iter().enumerate() {
        let name = machine.name.clone();
        let remaining = u32::try_from(count - number).unwrap_or(u32::MAX);
        let share = until.saturating_duration_since(Instant::now()) / remaining;
        if !activity.running && stop_one(host, activity, machine, share) {
            stopped.push(name);
        } else {
            left.push(name);
        }
    }
    if count > 0 {
        let mut message = format!("warning: `{}` is left alone: {why}", host.options.component);
        for (what, names) in [("stopped", stopped), ("not stopped in time", left)] {
            if !names.is_empty() {
                message += &format!("; {what}: {}", names.join(", "));
            }
        }
        // Nobody may read it any more.
        let _ = writeln!(std::io::stderr(), "{message}");
    }
    std::process::exit(STATUS);
}

/// Executes the `stop` codels of an activity. Returns false if they do not end in time.
fn stop_one(host: &Arc<Host>, activity: Activity, machine: HostMachine, within: Duration) -> bool {
    let (sender, ended) = channel::<()>();
    let host = host.clone();
    std::thread::spawn(move || {
        let task = host.options.tasks.get(&machine.lane).filter(|_| host.options.raised);
        if let Some(task) = task {
            realtime::raise_priority(task.priority);
        }
        let mut state = if activity.stopping { Some(activity.state) } else { machine.stop };
        let codel = |state: usize| machine.states.get(state).map(|state| state.codel);
        while let Some((at, codel)) = state.and_then(|at| Some((at, codel(at)?))) {
            if codel == HostMachine::SIMULATED {
                break;
            }
            let outcome = host.component.run(codel, activity.instance);
            state = match next(&machine, at, &outcome) {
                Some(DelegatedYield::Next(to)) => Some(to),
                Some(DelegatedYield::Pause(to)) => {
                    std::thread::sleep(Duration::from_nanos(machine.period));
                    Some(to)
                }
                None => None,
            };
        }
        let _ = sender.send(());
    });
    ended.recv_timeout(within).is_ok()
}
