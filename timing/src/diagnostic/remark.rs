//! Remarks: assumptions about a model that the user should know, of one thing or of several in one sentence.

use std::ops::Range;

use dotgen_analysis::model::Seconds;
use dotgen_analysis::quantity;

use super::{Diagnostic, Place};

/// An assumption about one thing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Remark {
    /// A codel without execution time.
    NoWcet {
        /// Function of the codel.
        codel: String,
        /// Path: `component.owner.state`.
        path: String,
    },
    /// A cycle of states that a turn can repeat without limit.
    StateCycle {
        /// `component.task` or `component.service`.
        machine: String,
        /// `a → b → a`
        cycle: String,
        /// A loop limit is possible for the machine.
        can_be_limited: bool,
    },
    /// A codel that blocks the head of the lock queue, and a task behind the head that shares nothing with
    /// the codel.
    LockQueue {
        /// Executing codel: `component.owner.state`.
        codel: String,
        /// Its greatest time, in seconds.
        time: Seconds,
        /// Waiting codel at the head of the queue.
        head: String,
        /// Task behind the head, with a period that is no longer than this time.
        task: String,
        /// Period of the task, in seconds.
        period: Seconds,
    },
    /// A request that is always refused: a service that must succeed before it is never requested, or is
    /// always refused itself.
    OnlyRefused {
        /// `component.service`
        service: String,
        /// Names of services that would have to succeed before.
        missing: Vec<String>,
    },
    /// A codel that holds a port that a task of another component needs.
    PortHold {
        /// Holding codel: `component.owner.state`.
        codel: String,
        /// Its greatest time, in seconds.
        time: Seconds,
        /// Waiting codel.
        other: String,
        /// Task of the waiting codel.
        task: String,
        /// Period of the task, in seconds, which is no longer than this time.
        period: Seconds,
    },
}

/// An observation during an exploration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sighting {
    /// A request for a service was refused because all its slots were in use.
    NoSlot {
        /// `component.service`
        service: String,
    },
    /// Two waiting instances of a service that interrupts itself have interrupted each other.
    RestartsEndBoth {
        /// `component.service`
        service: String,
    },
}

impl std::fmt::Display for Sighting {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Sighting::NoSlot { service } => {
                write!(f, "a request of {service} can be refused because all its slots are in use")
            }
            Sighting::RestartsEndBoth { service } => write!(
                f,
                "two requests of {service} that come while an instance of it is being stopped interrupt each other, and \
                 neither is executed; let clients await the end of the first one before they send the next"
            ),
        }
    }
}

/// Number of names in a message; further names are only counted.
const NAMED: usize = 6;

impl Remark {
    /// Returns the remark as a warning: at a place of the scenario, if there is one, and about places of the
    /// specifications.
    pub(crate) fn warning(self, range: Range<usize>, places: Vec<Place>) -> Diagnostic {
        let about =
            Diagnostic { places, ..Diagnostic::warning(self.code(), range, words(&self, &[])) };
        Diagnostic { remark: Some(Box::new(self)), ..about }
    }

    fn code(&self) -> &'static str {
        match self {
            Remark::NoWcet { .. } => "timing-no-wcet",
            Remark::StateCycle { .. } => "timing-state-cycle",
            Remark::LockQueue { .. } => "timing-lock-queue",
            Remark::PortHold { .. } => "timing-port-hold",
            Remark::OnlyRefused { .. } => "timing-only-refused",
        }
    }

    /// Returns true if one sentence can contain both remarks.
    fn joins(&self, other: &Remark) -> bool {
        match (self, other) {
            (Remark::NoWcet { .. }, Remark::NoWcet { .. }) => true,
            (Remark::StateCycle { machine: a, .. }, Remark::StateCycle { machine: b, .. }) => {
                a == b
            }
            _ => false,
        }
    }

    /// Returns the subject, which distinguishes it from others of its kind.
    fn name(&self) -> &str {
        match self {
            Remark::NoWcet { path, .. } => path,
            Remark::StateCycle { cycle, .. } => cycle,
            Remark::LockQueue { codel, .. } | Remark::PortHold { codel, .. } => codel,
            Remark::OnlyRefused { service, .. } => service,
        }
    }
}

/// Joins remarks that fit in one sentence: the codels of a specification that have no execution time, the
/// state cycles of one machine. Other diagnostics and the order remain.
pub fn together(all: &[Diagnostic]) -> Vec<Diagnostic> {
    let mut groups: Vec<Vec<&Diagnostic>> = Vec::new();
    for diagnostic in all {
        let joins = |group: &&mut Vec<&Diagnostic>| {
            let first = group[0];
            let spec = |diagnostic: &Diagnostic| diagnostic.places.first().map(|place| place.spec);
            let pair = first.remark.as_ref().zip(diagnostic.remark.as_ref());
            pair.is_some_and(|(a, b)| a.joins(b))
                && first.range == diagnostic.range
                && spec(first) == spec(diagnostic)
        };
        match groups.iter_mut().find(joins) {
            Some(group) => group.push(diagnostic),
            None => groups.push(vec![diagnostic]),
        }
    }
    groups.into_iter().map(|diagnostics| joined(&diagnostics)).collect()
}

fn joined(group: &[&Diagnostic]) -> Diagnostic {
    let mut out = group[0].clone();
    let Some(first) = &out.remark else {
        return out;
    };
    let mut others: Vec<&Remark> = Vec::new();
    for &diagnostic in &group[1..] {
        // A codel of several states is named once.
        let known = |place: &Place| out.places.iter().any(|other| other.at() == place.at());
        let is_codel = matches!(diagnostic.remark.as_deref(), Some(Remark::NoWcet { .. }));
        if is_codel && diagnostic.places.iter().all(known) {
            continue;
        }
        others.extend(diagnostic.remark.as_deref());
        for place in &diagnostic.places {
            if out.places.iter().all(|other| other.at() != place.at()) {
                out.places.push(place.clone());
            }
        }
    }
    out.message = words(first, &others).into();
    out
}

fn words(first: &Remark, others: &[&Remark]) -> String {
    let count = others.len() + 1;
    let all = std::iter::once(&first).chain(others);
    let mut names: Vec<&str> = all.map(|remark| remark.name()).collect();
    names.truncate(NAMED);
    let mut names = names.join(", ");
    if count > NAMED {
        names += &format!(" and {} more", count - NAMED);
    }
    match first {
        Remark::NoWcet { codel, path } => {
            let what = match count {
                1 => format!("codel {codel} ({path}) has no `wcet` and is taken to need no time"),
                _ => {
                    format!("{count} codels have no `wcet` and are taken to need no time: {names}")
                }
            };
            format!("{what}; add the measured worst case, or a `duration` in a scenario")
        }
        Remark::StateCycle { machine, can_be_limited, .. } => {
            let what = match count {
                1 => "state cycle without pause".to_owned(),
                _ => format!("{count} state cycles without pause"),
            };
            let advice = match (can_be_limited, count) {
                (true, _) => format!("unless a scenario says `loop once {machine};`"),
                (false, 1) => {
                    "until one of its codels yields `pause::` or `ether` instead".to_owned()
                }
                (false, _) => {
                    "until a codel of each yields `pause::` or `ether` instead".to_owned()
                }
            };
            format!("{machine}: {what}: {names}; a turn may take arbitrarily long {advice}")
        }
        Remark::LockQueue { codel, time, head, task, period } => {
            let [time, period] = [time, period].map(|time| quantity::time(*time));
            format!(
                "while {head} waits for {codel}, which takes up to {time}, the lock queue stands still: {task}, which shares \
                 nothing with it, waits behind and can miss its period of {period}; shorten what {codel} does with \
                 shared data, for example by a `local` copy"
            )
        }
        Remark::OnlyRefused { service, missing } => {
            format!(
                "every request of {service} is refused, because it comes after {}, and no request of that can succeed before; let a \
                 client request it first, or write `order off;`",
                missing.join(", ")
            )
        }
        Remark::PortHold { codel, time, other, task, period } => {
            let [time, period] = [time, period].map(|time| quantity::time(*time));
            format!(
                "{codel} holds a port for up to {time}; {other} waits for it meanwhile, and {task} can miss its period of \
                 {period}; let {codel} work on a `local` copy, and use the port in a short codel of its own"
            )
        }
    }
}
