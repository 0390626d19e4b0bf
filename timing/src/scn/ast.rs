//! The syntax tree of scenarios. Every name keeps its range, for diagnostics and editor features.

use std::ops::{Range, RangeInclusive};

pub use super::semantics::{Durations, Policy};
use super::semantics::{LockRule, PauseRule, PortRule, Preset, TickRule, TurnRule};
use super::times::TimesFile;

pub use super::pattern::{MonitorKind, Pattern, PatternForm, ScopeWord};
pub use super::values::{Bound, Comparison, Interval, Operator, Path, Pred, Spanned, Unit};

/// The possible numbers of slots of an activity. Each additional slot multiplies the number of states.
pub const SLOTS: RangeInclusive<u32> = 1..=32;

/// Greatest number of activities of a task at the same time in the servers, unless a scenario says otherwise.
pub const DEFAULT_PLACES: u32 = 16;

/// Slots of an activity in the published models unless a scenario says otherwise.
pub const DEFAULT_SLOTS: u32 = 2;

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Scenario {
    /// Name; empty if it is missing.
    pub name: String,
    /// Bytes of the name.
    pub name_range: Range<usize>,
    /// Items, in order.
    pub items: Vec<Item>,
    /// Contents of the files of execution times. The parser reads no file: its caller adds them.
    pub times: Vec<TimesFile>,
}

impl Scenario {
    /// Returns the checks in order, with those of measures.
    pub fn checks(&self) -> impl Iterator<Item = &Check> {
        self.items.iter().filter_map(|item| match item {
            Item::Check(check) => Some(check),
            Item::Client(client) => client.trigger.as_ref().map(|trigger| &trigger.check),
            _ => None,
        })
    }
}

/// One item of a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// `use "FILE.gen";`
    Use(Spanned<String>),
    /// `times "FILE.wcet";`
    Times(Spanned<String>),
    /// `weights "FILE.proba";`
    Weights(Spanned<String>),
    /// `unit 1 ms;`
    Unit(u64, Unit),
    /// `cores 4;`; `None`: `free`.
    Cores(Option<u32>),
    /// `policy`
    Policy(Policy),
    /// `durations`
    Durations(Durations),
    /// `duration PATH INTERVAL UNIT;`
    Duration(Path, Interval, Unit),
    /// `loop once [PATH];`; `None`: `free`. With the range of the item.
    Loop(Option<u32>, Option<Path>, Range<usize>),
    /// `idle keep [PATH];` (`true`) or `idle drop [PATH];`
    Idle(bool, Option<Path>),
    /// `semantics servers;`
    Semantics(Preset),
    /// `ticks component;`
    Ticks(TickRule),
    /// `turns codel;`
    Turns(TurnRule),
    /// `locks queue;`
    Locks(LockRule),
    /// `ports copy;`
    Ports(PortRule),
    /// `pause events;`
    Pause(PauseRule),
    /// `exceptions on [PATH];` (`true`) or `exceptions off [PATH];`
    Exceptions(bool, Option<Path>),
    /// `order on;` (`true`) or `order off;`
    Order(bool),
    /// `affinity PATH INT;`
    Affinity(Path, u32),
    /// `async free;` (`true`) or `async held;`
    AsyncFree(bool),
    /// `aperiodic core;` (`true`) or `aperiodic free;`
    AperiodicCore(bool),
    /// `connect PATH to PATH;` or `to none;`
    Connect(Path, Option<Path>),
    /// `slots PATH INT;`
    Slots(Path, u32),
    /// `client ID { … }` or `on late PATH { … }`
    Client(Client),
    /// `check [ID:] …;`
    Check(Check),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Client {
    /// Name. That of a measure may be made from its trigger; its range is then that of `on`.
    pub name: Spanned<String>,
    pub steps: Vec<Step>,
    /// What the client waits for before its first step, if it is a measure: `on late PATH { … }`.
    pub trigger: Option<Trigger>,
}

/// What a measure waits for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trigger {
    /// Kind of event.
    pub kind: TriggerKind,
    /// Codels and tasks, components, names of checks, or ports; any of them.
    pub of: Vec<Path>,
    /// Age of the data of a port that is stale.
    pub after: Option<(u64, Unit)>,
    /// The time from the event to the end of the measure.
    pub check: Check,
}

/// The kind of event that a measure waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TriggerKind {
    /// `on late`: a codel takes longer than its time, or a task misses a deadline.
    Late,
    /// `on violation of`: a check is violated.
    Violation,
    /// `on lost`: the process of a component has ended.
    Lost,
    /// `on stale … after`: a port was not written for some time, since it was written once.
    Stale,
}

impl Trigger {
    /// The label of all steps of a measure after its event.
    pub const BEGUN: &str = "begun";

    /// What begins the label of all steps of a measure after a step with a label.
    pub const AFTER: &str = "after_";

    /// Returns the label of the step that interrupts an activity.
    pub(crate) fn abort_label(activity: &Path) -> String {
        format!("abort_{}", activity.text().replace('.', "_"))
    }
}

/// A step of a client, with its label if it has one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// `LABEL:`
    pub label: Option<Spanned<String>>,
    /// Action.
    pub kind: StepKind,
    /// Range of the step.
    pub range: Range<usize>,
}

impl Step {
    /// Returns all steps of a list, also those in other steps, in the order of the text.
    pub fn all(list: &[Step]) -> Vec<&Step> {
        let mut out = Vec::new();
        for step in list {
            out.push(step);
            match &step.kind {
                StepKind::Repeat(_, body) => out.extend(Step::all(body)),
                StepKind::Choice(branches) => {
                    out.extend(branches.iter().flat_map(|branch| Step::all(branch)));
                }
                _ => {}
            }
        }
        out
    }
}

/// The outcome of a request that a client awaits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Ending {
    /// Any outcome.
    Any,
    /// The request has succeeded.
    Ok,
    /// The request has failed: it was refused, ended by an exception, or was interrupted and has no `stop`.
    Failed,
}

/// The action of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepKind {
    /// `send PATH;`
    Send(Path),
    /// `await accepted [PATH];`
    AwaitAccepted(Option<Path>),
    /// `await ended [ok|failed] [PATH];`
    AwaitEnded(Ending, Option<Path>),
    /// `abort PATH;`: of an activity, or the label of a `send` of the same client.
    Abort(Path),
    /// `kill COMPONENT;`
    Kill(Path),
    /// `connect COMPONENT;`
    Connect(Path),
    /// `delay INTERVAL UNIT;`
    Delay(Interval, Unit),
    /// `repeat N { … }`; `None`: for ever.
    Repeat(Option<u32>, Vec<Step>),
    /// `choice { … } or { … }`
    Choice(Vec<Vec<Step>>),
    /// `stop;`: the run ends. The last step of a measure.
    Stop,
}

/// `check [ID:] …;`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    pub name: Option<Spanned<String>>,
    /// What the check of a measure is about, in words; `None` for a check that is written.
    pub subject: Option<String>,
    pub kind: CheckKind,
    /// Range of the check.
    pub range: Range<usize>,
}

/// The delay of a cause-effect chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChainKind {
    /// Reaction time: the longest time from a write of the first datum until the last datum is first written
    /// by a codel whose data depend on it.
    Reaction,
    /// Data age: the longest time since the write of the first datum on which the visible last datum depends.
    Age,
}

/// The ports of a cause-effect chain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChainPath {
    /// Port of the first datum.
    pub from: Path,
    /// Port of the last datum.
    pub to: Path,
    /// Codels, tasks, services and ports on the chain; empty for any.
    pub via: Vec<Path>,
}

impl ChainPath {
    /// Returns normalised text.
    pub fn text(&self) -> String {
        let via: Vec<String> = self.via.iter().map(Path::text).collect();
        let via = if via.is_empty() { String::new() } else { format!(" via {}", via.join(", ")) };
        format!("{} -> {}{via}", self.from.text(), self.to.text())
    }

    /// Returns all paths, as they are written.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [&self.from, &self.to].into_iter().chain(&self.via)
    }
}

/// The kind of a check, with its parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CheckKind {
    /// `schedulable PATH`; `None`: all tasks.
    Schedulable(Option<Path>),
    /// `no-overdue PATH`
    NoOverdue(Option<Path>),
    /// `response PATH [<= BOUND]`
    Response(Option<Path>, Bound),
    /// `within P => Q [then R …] [<= BOUND]`; the responses are in order.
    Within(Pred, Vec<Pred>, Bound),
    /// `reaction PORT -> PORT [via PATH, …] [<= BOUND]`, or `age`
    Chain(ChainKind, ChainPath, Bound),
    /// `leadsto P => Q`
    LeadsTo(Pred, Pred),
    /// `eventually P`
    Eventually(Pred),
    /// `always P`
    Always(Pred),
    /// `reachable P`
    Reachable(Pred),
    /// A pattern of predicates in time.
    Pattern(Pattern),
    /// `deadlock`: there is no deadlock.
    Deadlock,
}

impl CheckKind {
    /// Returns the task of the check, if the check names one.
    pub fn task(&self) -> Option<&Path> {
        match self {
            CheckKind::Schedulable(path)
            | CheckKind::NoOverdue(path)
            | CheckKind::Response(path, _) => path.as_ref(),
            _ => None,
        }
    }

    /// Returns the comparisons of data in the predicates of the check.
    pub(crate) fn comparisons(&self) -> impl Iterator<Item = &Comparison> {
        self.predicates().flat_map(Pred::comparisons)
    }

    /// Returns the predicates of the check, as they are written.
    pub fn predicates(&self) -> impl Iterator<Item = &Pred> {
        let (one, others) = match self {
            CheckKind::Within(p, list, _) => (Some(p), &**list),
            CheckKind::LeadsTo(p, q) => (Some(p), std::slice::from_ref(q)),
            CheckKind::Pattern(pattern) => (None, &*pattern.predicates),
            CheckKind::Eventually(p) | CheckKind::Always(p) | CheckKind::Reachable(p) => {
                (Some(p), &[][..])
            }
            CheckKind::Schedulable(_)
            | CheckKind::NoOverdue(_)
            | CheckKind::Response(..)
            | CheckKind::Chain(..)
            | CheckKind::Deadlock => (None, &[][..]),
        };
        one.into_iter().chain(others)
    }
}
