//! Cause-effect chains (section 19): one write of the first datum is marked, and the data that depend on it
//! are followed.
//!
//! Rules with a [token](super::token) also keep in their states: the places that hold marked data, and the
//! executors of codels that began with marked data. The marked write is a free choice, offered after each
//! write ([`Action::Mark`]). There is one token at a time, so one clock measures it. This module
//! does not depend on components: a [`Chain`] lists the places that each codel reads and writes.
//!
//! *Reaction*: marks stay, as a later write of a place is made of later data. The first codel that began with
//! marked data and writes the last datum ends the measurement. *Age*: an unmarked write clears a place, and
//! the time counts while the last datum is marked.
//!
//! Reductions leave out orders of actions that commute in the system, but not for the token. So all of them
//! are off.

use super::token::{BITS, Token, greatest_age, is_set, set, status};
use super::{Action, Enabled, Rules, Work};
use crate::explore::state::{Clocks, State};
use crate::scn::ast::ChainKind;
use crate::system::chain::{Chain, DataPlace};
use crate::system::{CodelId, ComponentId, Ticks, TimedSystem};

impl<'s> Rules<'s> {
    /// Returns the rules of a system with a token.
    pub(in crate::explore) fn for_chain(
        system: &'s TimedSystem,
        chain: &'s Chain,
        clocks: &Clocks,
    ) -> Self {
        let plain = Rules::with(system, clocks);
        let executors = plain.frame().executors();
        let places = chain.shared + chain.locals * plain.holders();
        let clocks = Clocks {
            token: 1 + 2 * executors.div_ceil(BITS) + places.div_ceil(BITS),
            ..clocks.clone()
        };
        let mut rules = Rules::with(system, &clocks);
        let place = rules.frame().token_place();
        let cap = greatest_age(system);
        rules.token = Some(Token { chain, place, executors, cap });
        rules
    }
}

impl Rules<'_> {
    /// Returns the present codel of an executor, and the holder of its local variables: the place of an
    /// activity (also of one whose request is handled), or the request itself.
    pub(in crate::explore) fn codel_and_holder(
        &self,
        s: &State,
        executor: usize,
    ) -> Option<(CodelId, usize)> {
        match self.work(s, executor)? {
            Work::State { codel, slot, .. } => Some((codel, slot)),
            Work::Control { codel, service, .. } => {
                let component = self.system().services[service].component;
                let given = self.requested_place(s, component);
                Some((codel, given.unwrap_or_else(|| self.holder_of_request(component))))
            }
            Work::Delay { .. } => None,
        }
    }

    /// Returns the holder of the variables of the request that the control task of a component handles.
    fn holder_of_request(&self, component: ComponentId) -> usize {
        self.places() + usize::from(component)
    }

    /// Follows the effects of a step on data. `before`: the state before, and the executor whose codel has
    /// ended.
    pub(super) fn follow_data(
        &self,
        token: &Token,
        before: Option<(&State, Option<usize>)>,
        s: &mut State,
    ) {
        let ended = before.and_then(|(_, ended)| ended);
        if token.status(s) == status::OVER {
            return;
        }
        let mut offered = before.is_none() && token.offers_any_time();
        if let (Some((before, _)), Some(executor)) = (before, ended)
            && let Some((codel, holder)) = self.codel_and_holder(before, executor)
            && self.frame().is_executing(before, executor)
        {
            offered |= token.write(s, executor, codel, holder);
            self.hand_over(token, before, s);
        }
        for executor in 0..token.executors {
            let frame = self.frame();
            let was = before.is_some_and(|(state, _)| frame.is_executing(state, executor));
            if !frame.is_executing(s, executor) || (was && ended != Some(executor)) {
                continue;
            }
            let Some((codel, holder)) = self.codel_and_holder(s, executor) else {
                continue;
            };
            set(s, token.fresh(executor), true);
            let reads = token.chain.reads[codel].iter();
            let mut bits = reads.map(|&place| token.marked_place(place, holder));
            let marked = bits.any(|bit| is_set(s, bit)) && token.chain.carries[codel];
            set(s, token.marked_executor(executor), marked);
            // A datum that arrives just after a read waits longest for the next read; a datum that is read is
            // assumed to have just arrived.
            offered |= token.chain.external && token.reads_first(codel);
        }
        self.forget_locals(token, s);
        if offered && token.status(s) == status::IDLE {
            s.d[token.place] = status::OFFERED;
        } else {
            (0..token.executors).for_each(|executor| set(s, token.fresh(executor), false));
        }
        self.settle_token(token, s);
    }

    /// Moves the variables of a request to the activity that gets its place when the request is accepted.
    fn hand_over(&self, token: &Token, before: &State, s: &mut State) {
        if token.chain.locals == 0 {
            return;
        }
        for place in 0..self.places() {
            let Some(automaton) = self.activity(s, place) else {
                continue;
            };
            let is_new = self.activity(before, place).is_none();
            let system = self.system();
            let Some(service) = system.automata[automaton].service.filter(|_| is_new) else {
                continue;
            };
            let request = self.holder_of_request(system.services[service].component);
            for local in (0..token.chain.locals).map(DataPlace::Local) {
                let marked = is_set(s, token.marked_place(local, request));
                set(s, token.marked_place(local, place), marked);
            }
        }
    }

    /// Clears local variables at the end of their activity or request.
    fn forget_locals(&self, token: &Token, s: &mut State) {
        if token.chain.locals == 0 || token.status(s) != status::ALIVE {
            return;
        }
        let free = (0..self.places()).filter(|&place| self.activity(s, place).is_none());
        let handled = (self.system().components.keys())
            .filter(|&component| self.handling(s, component).is_none())
            .map(|component| self.holder_of_request(component));
        for holder in free.chain(handled).collect::<Vec<_>>() {
            for local in (0..token.chain.locals).map(DataPlace::Local) {
                set(s, token.marked_place(local, holder), false);
            }
        }
    }

    /// Opens and ends the measurement.
    fn settle_token(&self, token: &Token, s: &mut State) {
        let marks = token.place + 1 + token.executors.div_ceil(BITS)..self.end_of_token(token);
        if token.status(s) == status::ALIVE && s.d[marks].iter().all(|&number| number == 0) {
            s.d[token.place] = status::OVER;
        }
        if token.status(s) == status::OVER {
            let token = token.place + 1..self.end_of_token(token);
            s.d[token].fill(0);
        }
        let last = token.marked_place(DataPlace::Shared(token.chain.last), 0);
        let open = token.status(s) == status::ALIVE
            && match token.chain.kind {
                ChainKind::Reaction => true,
                ChainKind::Age => is_set(s, last),
            };
        let frame = self.frame();
        let stage = frame.stages(0).start;
        frame.set_open_at(s, stage, open);
        if let Some(clock) = frame.stage_clock(stage)
            && token.status(s) != status::ALIVE
        {
            s.t[clock] = 0;
        }
    }

    fn end_of_token(&self, token: &Token) -> usize {
        let places = token.chain.shared + token.chain.locals * self.holders();
        token.place + 1 + 2 * token.executors.div_ceil(BITS) + places.div_ceil(BITS)
    }

    /// Returns the executors whose read of the first datum can be marked, if the datum is new at every read.
    fn readers_of_first(&self, token: &Token, s: &State) -> Vec<usize> {
        let fresh = (0..token.executors).filter(|&executor| is_set(s, token.fresh(executor)));
        let reads = |index: &usize| {
            let codel = self.codel_and_holder(s, *index);
            codel.is_some_and(|(codel, _)| token.reads_first(codel) && token.chain.carries[codel])
        };
        fresh.filter(reads).collect()
    }

    /// Marks the offered datum, or not (`taken` is false).
    fn mark_data(&self, token: &Token, s: &mut State, executor: Option<usize>, taken: bool) {
        s.d[token.place] = if taken { status::ALIVE } else { status::IDLE };
        if taken {
            match (token.chain.external, executor) {
                (true, Some(executor)) => set(s, token.marked_executor(executor), true),
                (external, _) => {
                    set(s, token.marked_place(DataPlace::Shared(token.chain.first), 0), true);
                    // An executor that began by the same step sees the written datum.
                    let seen = if external { Vec::new() } else { self.readers_of_first(token, s) };
                    for executor in seen {
                        set(s, token.marked_executor(executor), true);
                    }
                }
            }
        }
        (0..token.executors).for_each(|executor| set(s, token.fresh(executor), false));
        self.settle_token(token, s);
    }

    /// Lists the actions of a state, unless they are those of the system: returns true then.
    pub(super) fn list_marks(&self, token: &Token, s: &State, out: &mut Enabled) -> bool {
        match token.status(s) {
            status::OFFERED => {
                out.actions.clear();
                (out.urgent, out.committed, out.forced) = (true, true, false);
                let mark = |executor, taken| Action::Mark { executor, taken };
                out.actions.push(mark(None, false));
                if token.chain.external && token.chain.kind == ChainKind::Age {
                    let readers = self.readers_of_first(token, s).into_iter();
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
    pub(super) fn act_with_data(&self, token: &Token, s: &mut State, action: Action) {
        if let Action::Mark { executor, taken } = action {
            return self.mark_data(token, s, executor, taken);
        }
        let before = s.clone();
        self.act(s, action);
        let ended = match action {
            Action::Finish { executor, .. } => Some(executor),
            _ => None,
        };
        self.follow_data(token, Some((&before, ended)), s);
    }

    /// Lets time pass for an age that is not visible.
    pub(super) fn age(&self, token: &Token, s: &mut State, time: Ticks) {
        let frame = self.frame();
        let stage = frame.stages(0).start;
        if let Some(clock) = frame.stage_clock(stage)
            && token.status(s) == status::ALIVE
            && !frame.is_open_at(s, stage)
        {
            s.t[clock] = s.t[clock].saturating_add(time).min(token.cap);
        }
    }

    /// Returns the number of holders of local variables: the places of activities, and the request that each
    /// control task handles.
    pub(in crate::explore) fn holders(&self) -> usize {
        self.places() + self.system().components.len()
    }
}
