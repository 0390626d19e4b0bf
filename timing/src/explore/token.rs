//! Cause-effect chains (section 19): one write of the first datum is marked, and the data that depend on it
//! are followed.
//!
//! Rules with a [`Token`] keep in their states, in addition: the places that hold marked data, and the
//! executors of codels that began with marked data. The marked write is a free choice, offered
//! after each write ([`Action::Mark`]). There is one token at a time, so one clock measures it. This module
//! does not depend on components: a [`Chain`] lists the places that each codel reads and writes.
//!
//! *Reaction*: marks stay, as a later write of a place is made of later data. The first codel that began with
//! marked data and writes the last datum ends the measurement. *Age*: an unmarked write clears a place, and
//! the time counts while the last datum is marked.
//!
//! Reductions leave out orders of actions that commute in the system, but not for the token. So all of them
//! are off.

use super::findings::{Bound, Measured};
use super::rules::{Action, Enabled, Rules, Work};
use super::run::Run;
use super::state::{Clocks, State};
use crate::scn::ast::ChainKind;
use crate::system::chain::{Chain, DataPlace};
use crate::system::{CodelId, ComponentId, FOREVER, Ticks, TimedSystem};

/// Returns the greatest age, in base units, up to which invisible ages are counted. Greater ages would be
/// unbounded, or nearly so.
pub(super) fn greatest_age(system: &TimedSystem) -> Ticks {
    let periods = system.tasks.iter().filter_map(|task| task.period);
    let uppers = (system.codels.iter())
        .map(|codel| if codel.upper == FOREVER { codel.lower } else { codel.upper });
    let sum = periods.chain(uppers).fold(16, Ticks::saturating_add);
    sum.saturating_mul(32)
}

/// Removes marks from runs: they are not actions of the system.
pub(super) fn without_marks(measurement: &mut Measured) {
    let strip = |run: &mut Run| {
        let is_mark = |action: &Action| matches!(action, Action::Mark { .. });
        if let Some(cycle) = &mut run.cycle {
            let before = run.steps.iter().take(*cycle);
            *cycle -= before.filter(|step| is_mark(&step.1)).count();
        }
        run.steps.retain(|step| !is_mark(&step.1));
    };
    strip(&mut measurement.longest);
    if let Some(excess) = &mut measurement.excess {
        strip(excess);
    }
}

/// The status of the token.
mod status {
    /// No datum is marked yet.
    pub(super) const IDLE: u16 = 0;
    /// The last write can be marked.
    pub(super) const OFFERED: u16 = 1;
    /// Some datum is marked.
    pub(super) const ALIVE: u16 = 2;
    /// The measurement has ended, or no marked datum is left.
    pub(super) const OVER: u16 = 3;
}

/// Bits of a number of the discrete part.
const BITS: usize = u16::BITS as usize;

/// The token of a chain.
#[derive(Debug)]
pub(crate) struct Token<'c> {
    pub(super) chain: &'c Chain,
    /// Place of the token in the discrete part.
    token: usize,
    /// Number of executors.
    pub(super) executors: usize,
    cap: Ticks,
}

impl<'c> Token<'c> {
    /// Returns the rules of a system with a token.
    pub(super) fn rules(system: &'c TimedSystem, chain: &'c Chain, clocks: &Clocks) -> Rules<'c> {
        let plain = Rules::with(system, clocks);
        let executors = plain.frame().executors();
        let places = chain.shared + chain.locals * holders(&plain);
        let clocks = Clocks {
            token: 1 + 2 * executors.div_ceil(BITS) + places.div_ceil(BITS),
            ..clocks.clone()
        };
        let mut rules = Rules::with(system, &clocks);
        let token = rules.frame().token_place();
        rules.token = Some(Token { chain, token, executors, cap: greatest_age(system) });
        rules
    }

    fn status(&self, s: &State) -> u16 {
        s.d[self.token]
    }

    /// Returns the place of a bit: executors that began in this step, executors with marked data, places with
    /// marked data.
    fn fresh(&self, executor: usize) -> (usize, u16) {
        self.bit(0, executor)
    }

    pub(super) fn marked_executor(&self, executor: usize) -> (usize, u16) {
        self.bit(self.executors.div_ceil(BITS), executor)
    }

    pub(super) fn marked_place(&self, place: DataPlace, holder: usize) -> (usize, u16) {
        let number = match place {
            DataPlace::Shared(index) => index,
            DataPlace::Local(local) => self.chain.shared + holder * self.chain.locals + local,
        };
        self.bit(2 * self.executors.div_ceil(BITS), number)
    }

    fn bit(&self, words: usize, number: usize) -> (usize, u16) {
        (self.token + 1 + words + number / BITS, 1 << (number % BITS))
    }

    /// Returns the present codel of an executor, and the holder of its local variables: the place of an
    /// activity (also of one whose request is handled), or the request itself.
    pub(super) fn codel(
        &self,
        rules: &Rules,
        s: &State,
        executor: usize,
    ) -> Option<(CodelId, usize)> {
        match rules.work(s, executor)? {
            Work::State { codel, slot, .. } => Some((codel, slot)),
            Work::Control { codel, service, .. } => {
                let component = rules.system().services[service].component;
                let given = rules.requested_place(s, component);
                Some((codel, given.unwrap_or_else(|| self.request(rules, component))))
            }
            Work::Delay { .. } => None,
        }
    }

    /// Returns the holder of the variables of the request that the control task of a component handles.
    fn request(&self, rules: &Rules, component: ComponentId) -> usize {
        rules.places() + usize::from(component)
    }

    fn reads_first(&self, codel: CodelId) -> bool {
        self.chain.reads[codel].contains(&DataPlace::Shared(self.chain.first))
    }

    /// Follows the effects of a step on data. `before`: the state before, and the executor whose codel has
    /// ended.
    pub(super) fn follow(
        &self,
        rules: &Rules,
        before: Option<(&State, Option<usize>)>,
        s: &mut State,
    ) {
        let ended = before.and_then(|(_, ended)| ended);
        if self.status(s) == status::OVER {
            return;
        }
        let mut offered = before.is_none() && self.offers_any_time();
        if let (Some((before, _)), Some(executor)) = (before, ended)
            && let Some((codel, holder)) = self.codel(rules, before, executor)
            && rules.frame().is_executing(before, executor)
        {
            offered |= self.write(s, executor, codel, holder);
            self.hand_over(rules, before, s);
        }
        for executor in 0..self.executors {
            let frame = rules.frame();
            let was = before.is_some_and(|(state, _)| frame.is_executing(state, executor));
            if !frame.is_executing(s, executor) || (was && ended != Some(executor)) {
                continue;
            }
            let Some((codel, holder)) = self.codel(rules, s, executor) else {
                continue;
            };
            set(s, self.fresh(executor), true);
            let reads = self.chain.reads[codel].iter();
            let mut bits = reads.map(|&place| self.marked_place(place, holder));
            let marked = bits.any(|bit| is_set(s, bit)) && self.chain.carries[codel];
            set(s, self.marked_executor(executor), marked);
            // A datum that arrives just after a read waits longest for the next read; a datum that is read is
            // assumed to have just arrived.
            offered |= self.chain.external && self.reads_first(codel);
        }
        self.forget_locals(rules, s);
        if offered && self.status(s) == status::IDLE {
            s.d[self.token] = status::OFFERED;
        } else {
            (0..self.executors).for_each(|executor| set(s, self.fresh(executor), false));
        }
        self.settle(rules, s);
    }

    fn offers_any_time(&self) -> bool {
        self.chain.external && self.chain.kind == ChainKind::Reaction
    }

    /// Performs the writes of a codel that ends. Returns true if the first datum is written.
    fn write(&self, s: &mut State, executor: usize, codel: CodelId, holder: usize) -> bool {
        let chain = self.chain;
        let marked = is_set(s, self.marked_executor(executor));
        set(s, self.marked_executor(executor), false);
        for &place in &chain.writes[codel] {
            let bit = self.marked_place(place, holder);
            // A new first datum is another datum, whatever it is made of.
            let is_first = place == DataPlace::Shared(chain.first);
            match chain.kind {
                ChainKind::Reaction if marked && place == DataPlace::Shared(chain.last) => {
                    s.d[self.token] = status::OVER;
                }
                ChainKind::Reaction if marked => set(s, bit, true),
                ChainKind::Reaction => {}
                ChainKind::Age => set(s, bit, marked && !is_first),
            }
        }
        chain.writes[codel].contains(&DataPlace::Shared(chain.first))
    }

    /// Moves the variables of a request to the activity that gets its place when the request is accepted.
    fn hand_over(&self, rules: &Rules, before: &State, s: &mut State) {
        if self.chain.locals == 0 {
            return;
        }
        for place in 0..rules.places() {
            let Some(automaton) = rules.activity(s, place) else {
                continue;
            };
            let is_new = rules.activity(before, place).is_none();
            let system = rules.system();
            let Some(service) = system.automata[automaton].service.filter(|_| is_new) else {
                continue;
            };
            let request = self.request(rules, system.services[service].component);
            for local in (0..self.chain.locals).map(DataPlace::Local) {
                let marked = is_set(s, self.marked_place(local, request));
                set(s, self.marked_place(local, place), marked);
            }
        }
    }

    /// Clears local variables at the end of their activity or request.
    fn forget_locals(&self, rules: &Rules, s: &mut State) {
        if self.chain.locals == 0 || self.status(s) != status::ALIVE {
            return;
        }
        let free = (0..rules.places()).filter(|&index| rules.activity(s, index).is_none());
        let handled = (rules.system().components.keys())
            .filter(|&component| rules.handling(s, component).is_none())
            .map(|component| self.request(rules, component));
        for holder in free.chain(handled).collect::<Vec<_>>() {
            for local in (0..self.chain.locals).map(DataPlace::Local) {
                set(s, self.marked_place(local, holder), false);
            }
        }
    }

    /// Opens and ends the measurement.
    fn settle(&self, rules: &Rules, s: &mut State) {
        let marks = self.token + 1 + self.executors.div_ceil(BITS)..self.end(rules);
        if self.status(s) == status::ALIVE && s.d[marks].iter().all(|&number| number == 0) {
            s.d[self.token] = status::OVER;
        }
        if self.status(s) == status::OVER {
            let token = self.token + 1..self.end(rules);
            s.d[token].fill(0);
        }
        let last = self.marked_place(DataPlace::Shared(self.chain.last), 0);
        let open = self.status(s) == status::ALIVE
            && match self.chain.kind {
                ChainKind::Reaction => true,
                ChainKind::Age => is_set(s, last),
            };
        let frame = rules.frame();
        let stage = frame.stages(0).start;
        frame.set_open_at(s, stage, open);
        if let Some(clock) = frame.stage_clock(stage)
            && self.status(s) != status::ALIVE
        {
            s.t[clock] = 0;
        }
    }

    fn end(&self, rules: &Rules) -> usize {
        let places = self.chain.shared + self.chain.locals * holders(rules);
        self.token + 1 + 2 * self.executors.div_ceil(BITS) + places.div_ceil(BITS)
    }

    /// Returns the executors whose read of the first datum can be marked, if the datum is new at every read.
    fn readers(&self, rules: &Rules, s: &State) -> Vec<usize> {
        let fresh = (0..self.executors).filter(|&executor| is_set(s, self.fresh(executor)));
        let reads = |index: &usize| {
            let codel = self.codel(rules, s, *index);
            codel.is_some_and(|(codel, _)| self.reads_first(codel) && self.chain.carries[codel])
        };
        fresh.filter(reads).collect()
    }

    /// Marks the offered datum, or not (`taken` is false).
    fn mark(&self, rules: &Rules, s: &mut State, executor: Option<usize>, taken: bool) {
        s.d[self.token] = if taken { status::ALIVE } else { status::IDLE };
        if taken {
            match (self.chain.external, executor) {
                (true, Some(executor)) => set(s, self.marked_executor(executor), true),
                (external, _) => {
                    set(s, self.marked_place(DataPlace::Shared(self.chain.first), 0), true);
                    // An executor that began by the same step sees the written datum.
                    let seen = if external { Vec::new() } else { self.readers(rules, s) };
                    for executor in seen {
                        set(s, self.marked_executor(executor), true);
                    }
                }
            }
        }
        (0..self.executors).for_each(|executor| set(s, self.fresh(executor), false));
        self.settle(rules, s);
    }

    /// Returns true if no further event is of interest.
    pub(super) fn is_over(&self, s: &State) -> bool {
        self.status(s) == status::OVER
    }

    /// Lists the actions of a state, unless they are those of the system: returns true then.
    pub(super) fn enabled(&self, rules: &Rules, s: &State, out: &mut Enabled) -> bool {
        match self.status(s) {
            status::OFFERED => {
                out.actions.clear();
                (out.urgent, out.committed, out.forced) = (true, true, false);
                let mark = |executor, taken| Action::Mark { executor, taken };
                out.actions.push(mark(None, false));
                if self.chain.external && self.chain.kind == ChainKind::Age {
                    let readers = self.readers(rules, s).into_iter();
                    out.actions.extend(readers.map(|reader| mark(Some(reader), true)));
                } else {
                    out.actions.push(mark(None, true));
                }
                false
            }
            status::OVER => {
                out.actions.clear();
                (out.urgent, out.committed, out.forced) = (false, false, false);
                false
            }
            _ => true,
        }
    }

    /// Performs an action, and follows its effects on data.
    pub(super) fn apply(&self, rules: &Rules, s: &mut State, action: Action) {
        if let Action::Mark { executor, taken } = action {
            return self.mark(rules, s, executor, taken);
        }
        let before = s.clone();
        rules.act(s, action);
        let ended = match action {
            Action::Finish { executor, .. } => Some(executor),
            _ => None,
        };
        self.follow(rules, Some((&before, ended)), s);
    }

    /// Lets time pass for an age that is not visible.
    pub(super) fn elapse(&self, rules: &Rules, s: &mut State, time: Ticks) {
        let frame = rules.frame();
        let stage = frame.stages(0).start;
        if let Some(clock) = frame.stage_clock(stage)
            && self.status(s) == status::ALIVE
            && !frame.is_open_at(s, stage)
        {
            s.t[clock] = s.t[clock].saturating_add(time).min(self.cap);
        }
    }
}

/// Returns the number of holders of local variables: the places of activities, and the request that each
/// control task handles.
pub(super) fn holders(rules: &Rules) -> usize {
    rules.places() + rules.system().components.len()
}

pub(super) fn is_set(s: &State, (word, bit): (usize, u16)) -> bool {
    s.d[word] & bit != 0
}

fn set(s: &mut State, (word, bit): (usize, u16), value: bool) {
    if value { s.d[word] |= bit } else { s.d[word] &= !bit }
}

/// Returns true if the measured value of a chain is exact.
pub fn is_exact(system: &TimedSystem, chain: &Chain, bound: Bound) -> bool {
    match (chain.kind, bound) {
        (ChainKind::Age, Bound::Finite(value)) => value < greatest_age(system),
        _ => true,
    }
}
