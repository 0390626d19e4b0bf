//! Unbounded response: the search for a run that never answers.

use std::rc::Rc;

use rustc_hash::FxHashMap;

use super::observe::{self, Observer, Observers};
use super::rules::{Action, Enabled, Rules};
use super::run::Run;
use super::state::{Clocks, Stages, State};
use super::store::{Encoded, decode, encode};
use super::watch::{Limits, Stop};
use crate::cancel::Cancel;
use crate::property::Predicate;
use crate::system::{Ticks, TimedSystem};

/// Whenever `trigger` becomes true, `response` must follow on every run.
#[derive(Debug, Clone)]
pub struct LivenessQuery {
    /// Predicate that opens the obligation; `None` if the obligation is open from the start.
    pub trigger: Option<Predicate>,
    /// Predicate that must follow.
    pub response: Predicate,
}

/// The answer to a [`LivenessQuery`].
#[derive(Debug, Clone)]
pub struct Liveness {
    /// Run that never answers. It repeats from `Run::cycle` on. If that is `None`, time passes for ever after
    /// the end of the run.
    pub counterexample: Option<Run>,
    /// The obligation was open at some time, or was met at once.
    pub triggered: bool,
    /// Number of states visited.
    pub states: usize,
    /// Bytes taken by states.
    pub bytes: usize,
    /// Reason for an incomplete exploration.
    pub stopped: Option<Stop>,
}

/// Decides a query. States are neither merged nor covered, because a cycle must be a cycle of the system.
pub fn liveness(
    system: &TimedSystem,
    query: &LivenessQuery,
    limits: Limits,
    cancel: &Cancel,
) -> Liveness {
    decide(&Rules::new(system), query, limits, cancel)
}

fn decide(rules: &Rules, query: &LivenessQuery, limits: Limits, cancel: &Cancel) -> Liveness {
    let clocks = Clocks {
        within: vec![Stages { count: 1, measured: false }],
        ..Clocks::none(rules.system().tasks.len())
    };
    let rules = rules.with_clocks(&clocks);
    // The trigger "always": true in the initial state.
    let always = || {
        Predicate::Or(
            Box::new(query.response.clone()),
            Box::new(Predicate::Not(Box::new(query.response.clone()))),
        )
    };
    let responses = vec![Observer {
        trigger: query.trigger.clone().unwrap_or_else(always),
        responses: vec![query.response.clone()],
    }];
    let observers = Observers { responses, monitors: Vec::new() };
    Graph { rules, observers, once: query.trigger.is_none(), limits, cancel }.search()
}

/// Number of states between two polls of the limits.
const STEPS_PER_POLL: usize = 64;

struct Graph<'a> {
    rules: Rules<'a>,
    observers: Observers,
    /// Nothing matters after the first answer.
    once: bool,
    limits: Limits,
    cancel: &'a Cancel,
}

/// The step from one state to another.
#[derive(Clone, Copy)]
enum Edge {
    Act(Action),
    Pass(Ticks),
}

struct Visit {
    state: Rc<Encoded>,
    parent: u32,
    edge: Edge,
    time: u64,
}

impl Graph<'_> {
    fn search(&self) -> Liveness {
        let mut visits: Vec<Visit> = Vec::new();
        let mut ids: FxHashMap<Rc<Encoded>, u32> = FxHashMap::default();
        let mut successors: Vec<Vec<u32>> = Vec::new();
        let mut initial = self.rules.initial();
        observe::observe(&self.rules, &self.observers, None, &mut initial);
        let trigger = &self.observers.responses[0].trigger;
        let mut triggered = observe::predicate(&self.rules, None, &initial, trigger);
        let mut first = Encoded::default();
        encode(self.rules.frame(), &initial, &mut first);
        let mut bytes = weight(&first);
        let first = Rc::new(first);
        ids.insert(first.clone(), 0);
        visits.push(Visit { state: first, parent: u32::MAX, edge: Edge::Pass(0), time: 0 });
        let mut enabled = Enabled::default();
        let mut stopped = None;
        let mut at = 0;
        while at < visits.len() {
            // A list that grows is copied: its old memory is still in use meanwhile.
            let about_to_grow = visits.capacity() - visits.len() < STEPS_PER_POLL;
            let with_copy = bytes + if about_to_grow { bytes / 4 } else { 0 };
            let full = visits.len() > self.limits.states || with_copy > self.limits.bytes;
            if full || at.is_multiple_of(STEPS_PER_POLL) {
                stopped = Stop::reason(visits.len(), with_copy, self.limits, self.cancel);
                if stopped.is_some() {
                    break;
                }
            }
            let s = decode(self.rules.frame(), &visits[at].state.key, &visits[at].state.dims);
            let mut next_ids = Vec::new();
            if self.open(&s) || !self.once {
                for (edge, next, forever) in self.successors(&s, &mut enabled) {
                    triggered |= observe::predicate(&self.rules, Some(&s), &next, trigger);
                    if forever {
                        // Time passes and no event ever follows: the state is a cycle of its own.
                        next_ids.push(at as u32);
                        continue;
                    }
                    let mut encoding = Encoded::default();
                    encode(self.rules.frame(), &next, &mut encoding);
                    let jump = match edge {
                        Edge::Pass(jump) => u64::from(jump),
                        Edge::Act(_) => 0,
                    };
                    let time = visits[at].time + jump;
                    let id = if let Some(&id) = ids.get(&encoding) {
                        id
                    } else {
                        bytes += weight(&encoding);
                        let state = Rc::new(encoding);
                        ids.insert(state.clone(), visits.len() as u32);
                        visits.push(Visit { state, parent: at as u32, edge, time });
                        visits.len() as u32 - 1
                    };
                    next_ids.push(id);
                }
            }
            bytes += next_ids.capacity() * size_of::<u32>();
            successors.push(next_ids);
            at += 1;
        }
        successors.resize(visits.len(), Vec::new());
        let counterexample = self
            .unanswered(&visits)
            .and_then(|open| self.cycle(&successors, &open))
            .map(|cycle| self.run(&visits, &successors, &cycle));
        if self.cancel.is_too_late() {
            // A missing counterexample proves nothing if the search was stopped.
            stopped = Stop::reason(visits.len(), bytes, self.limits, self.cancel);
        }
        self.cancel.ended(visits.len());
        Liveness { counterexample, triggered, states: visits.len(), bytes, stopped }
    }

    /// Returns, by state, whether the obligation is still open; `None` if the search must end.
    fn unanswered(&self, visits: &[Visit]) -> Option<Vec<bool>> {
        let mut open = Vec::with_capacity(visits.len());
        for (i, visit) in visits.iter().enumerate() {
            if i.is_multiple_of(STEPS_PER_POLL) && self.cancel.is_too_late() {
                return None;
            }
            let s = decode(self.rules.frame(), &visit.state.key, &visit.state.dims);
            open.push(self.open(&s));
        }
        Some(open)
    }

    fn open(&self, s: &State) -> bool {
        self.rules.frame().is_open(s, 0)
    }

    fn successors(&self, s: &State, enabled: &mut Enabled) -> Vec<(Edge, State, bool)> {
        let mut out = Vec::new();
        self.rules.enabled(s, enabled);
        for &action in &enabled.actions {
            let mut next = s.clone();
            self.rules.apply(&mut next, action);
            observe::observe(&self.rules, &self.observers, Some(s), &mut next);
            out.push((Edge::Act(action), next, false));
        }
        if !enabled.urgent && !enabled.forced {
            match self.rules.next_moment(s, &|_| false) {
                Some(jump) => {
                    let mut next = s.clone();
                    self.rules.elapse(&mut next, jump);
                    out.push((Edge::Pass(jump), next, false));
                }
                None => out.push((Edge::Pass(0), s.clone(), true)),
            }
        }
        out
    }

    /// Returns the run to the first state of a cycle and once around the cycle.
    fn run(&self, visits: &[Visit], successors: &[Vec<u32>], cycle: &[u32]) -> Run {
        let mut path = vec![cycle[0]];
        while visits[path[path.len() - 1] as usize].parent != u32::MAX {
            path.push(visits[path[path.len() - 1] as usize].parent);
        }
        path.reverse();
        let mut run = Run::default();
        let mut time = 0;
        for &path in &path[1..] {
            let visit = &visits[path as usize];
            time = visit.time;
            if let Edge::Act(action) = visit.edge {
                run.steps.push((time, action));
            }
        }
        let stuck = cycle.len() == 1 && successors[cycle[0] as usize] == [cycle[0]];
        run.end = time;
        let forever = {
            let state = &visits[cycle[0] as usize].state;
            let s = decode(self.rules.frame(), &state.key, &state.dims);
            self.rules.next_moment(&s, &|_| false).is_none()
        };
        if stuck && forever {
            return run;
        }
        run.cycle = Some(run.steps.len());
        let mut enabled = Enabled::default();
        for (i, &visit) in cycle.iter().enumerate() {
            let to = &visits[cycle[(i + 1) % cycle.len()] as usize].state;
            let from = &visits[visit as usize].state;
            let s = decode(self.rules.frame(), &from.key, &from.dims);
            for (edge, next, _) in self.successors(&s, &mut enabled) {
                let mut encoded = Encoded::default();
                encode(self.rules.frame(), &next, &mut encoded);
                if encoded == **to {
                    match edge {
                        Edge::Act(action) => run.steps.push((time, action)),
                        Edge::Pass(jump) => time += u64::from(jump),
                    }
                    break;
                }
            }
        }
        run.end = time;
        run
    }
}

/// Returns the bytes of a visited state: its own, those of the visit, of the index and of the successors.
fn weight(encoding: &Encoded) -> usize {
    let list = size_of::<Vec<u32>>();
    let counts = 2 * size_of::<usize>();
    let index = 2 * size_of::<(Rc<Encoded>, u32)>();
    let own = size_of::<Encoded>()
        + encoding.key.capacity()
        + encoding.dims.capacity() * size_of::<Ticks>();
    own + counts + index + 2 * (size_of::<Visit>() + list)
}

impl Graph<'_> {
    /// Returns a cycle through states that are all `open`.
    fn cycle(&self, successors: &[Vec<u32>], open: &[bool]) -> Option<Vec<u32>> {
        // Depth-first search with colours: a back edge closes a cycle.
        let n = successors.len();
        let mut colour = vec![0u8; n];
        let mut steps = 0usize;
        for root in 0..n {
            if !open[root] || colour[root] != 0 {
                continue;
            }
            let mut stack: Vec<(u32, usize)> = vec![(root as u32, 0)];
            colour[root] = 1;
            while let Some(top) = stack.last_mut() {
                steps += 1;
                if steps.is_multiple_of(16 * STEPS_PER_POLL) && self.cancel.is_too_late() {
                    return None;
                }
                let node = top.0 as usize;
                let Some(&next) = successors[node].get(top.1) else {
                    colour[node] = 2;
                    stack.pop();
                    continue;
                };
                top.1 += 1;
                if !open[next as usize] {
                    continue;
                }
                match colour[next as usize] {
                    0 => {
                        colour[next as usize] = 1;
                        stack.push((next, 0));
                    }
                    1 => {
                        let from = stack.iter().position(|&(number, _)| number == next)?;
                        return Some(stack[from..].iter().map(|&(number, _)| number).collect());
                    }
                    _ => {}
                }
            }
        }
        None
    }
}
