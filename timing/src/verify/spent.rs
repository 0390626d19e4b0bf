//! The intervals of measured times, as data of a report.

use super::group::Group;
use crate::explore::{Run, Span, Spent, Within};
use crate::property::resolve;
use crate::property::{Atom, Predicate, TaskState};
use crate::report::{
    CheckReport, Endless, EndlessKind, LoopExit, Stretch, StretchKind, Value, Verdict,
};
use crate::scn::ast::Pred;
use crate::system::indexed::DeclaredTask;
use crate::system::{CodelId, ComponentId, Machine, ThreadName, TimedSystem, Yield};

impl Group<'_> {
    /// Sets what delays a response, and what goes on for ever if the response has no bound.
    pub(super) fn spent_until_response(
        &self,
        (trigger, responses): (&Pred, &[Pred]),
        (run, longest): (&Run, &Run),
        out: &mut CheckReport,
    ) {
        let predicate = |pred: &Pred| resolve::resolve(self.names, self.built, pred).ok();
        let all: Option<Vec<Predicate>> = responses.iter().map(predicate).collect();
        let (Some(trigger), Some(responses)) = (predicate(trigger), all) else { return };
        let within = Within { trigger, responses, limit: None };
        let spans = |run: &Run| {
            if run.left_out {
                Default::default()
            } else {
                run.spans_of_response(&self.built.system, &within)
            }
        };
        let late = spans(run).0;
        let awaited = spans(longest).1.and_then(|stage| within.responses.get(stage));
        let cycle = awaited.map(|response| self.cycle(longest, response));
        let (spans, codels) = cycle.unwrap_or_default();
        self.set_spent(&late, (&spans, &codels), out);
    }

    /// Sets what goes on for ever while a job of a task lasts.
    pub(super) fn spent_by_task(&self, task: DeclaredTask, longest: &Run, out: &mut CheckReport) {
        let atom = Atom::Task(self.built.tasks[&task], TaskState::Idle);
        let cycle = self.cycle(longest, &Predicate::Atom(atom));
        self.set_spent(&[], (&cycle.0, &cycle.1), out);
    }

    /// Returns the intervals of the part of a run that repeats for ever, and the codels of the response that
    /// are executed there.
    pub(super) fn cycle(&self, run: &Run, response: &Predicate) -> (Vec<Span>, Vec<CodelId>) {
        if run.cycle.is_none() || run.left_out {
            return Default::default();
        }
        let system = &self.built.system;
        (run.spans_of_cycle(system, response), run.codels_of_cycle(system, response))
    }

    /// Sets the intervals of a refuted check.
    pub(super) fn set_spent(
        &self,
        late: &[Span],
        cycle: (&[Span], &[CodelId]),
        out: &mut CheckReport,
    ) {
        if out.verdict != Verdict::Refuted {
            return;
        }
        let system = &self.built.system;
        let stretch = |span: &Span| {
            let (thread, kind) = described(system, span.spent);
            let (from, until) = (self.at(span.from), self.at(span.until));
            Stretch { from, until, thread, kind, begins: span.begins }
        };
        out.spent = late.iter().map(stretch).collect();
        if out.value.is_none_or(|value| value == Value::Unbounded) {
            out.endless = self.endless(cycle);
        }
    }

    fn endless(&self, (cycle, known): (&[Span], &[CodelId])) -> Option<Endless> {
        let system = &self.built.system;
        let mut codels: Vec<CodelId> = known.to_vec();
        for span in cycle {
            if let Spent::Executes(codel) = span.spent
                && !codels.contains(&codel)
            {
                codels.push(codel);
            }
        }
        // What several threads do is no loop of one of them.
        let thread_of = |codel: CodelId| described(system, Spent::Executes(codel)).0;
        let thread = match (cycle.last(), codels.first()) {
            (Some(last), _) if !codels.is_empty() && last.spent != Spent::Nothing => {
                described(system, last.spent).0
            }
            (_, Some(&first)) => thread_of(first),
            _ => None,
        };
        codels.retain(|&codel| thread_of(codel) == thread);
        let path = |codel: CodelId| system.codels[codel].path.clone();
        let kind = match &codels[..] {
            [] => EndlessKind::Waits(described(system, cycle.last()?.spent).1),
            all => EndlessKind::Loop {
                codels: all.iter().map(|&codel| path(codel)).collect(),
                exits: self.exits(all),
            },
        };
        let spent = codels.first().map(|&codel| Spent::Executes(codel));
        let thread = described(system, spent.or(cycle.last().map(|span| span.spent))?).0;
        Some(Endless { thread, kind })
    }

    /// Returns the yields with which codels can leave the loop that they form.
    fn exits(&self, codels: &[CodelId]) -> Vec<LoopExit> {
        let system = &self.built.system;
        let mut out = Vec::new();
        let in_loop =
            |machine: &Machine, state: usize| codels.contains(&machine.states[state].codel);
        for machine in &system.machines {
            for state in machine.states.iter().filter(|state| codels.contains(&state.codel)) {
                let codel = &system.codels[state.codel];
                let name = |state: usize| machine.states[state].name.as_str();
                let yields = state.yields.iter().filter_map(|next| match *next {
                    Yield::Next(next) if !in_loop(machine, next) => Some(name(next).to_owned()),
                    Yield::Pause(next) if !in_loop(machine, next) => {
                        Some(format!("pause::{}", name(next)))
                    }
                    Yield::End => Some("ether".to_owned()),
                    _ => None,
                });
                let spec_of = |component: usize| self.names.components[component].spec_index;
                let src = codel.site.and_then(|site| Some((spec_of(site.0), codel.src?)));
                out.extend(yields.map(|yields| LoopExit {
                    codel: codel.path.clone(),
                    yields,
                    src,
                }));
            }
        }
        out
    }
}

/// Returns the thread of an interval, and what the thread does.
fn described(system: &TimedSystem, spent: Spent) -> (Option<ThreadName>, StretchKind) {
    let path = |codel: CodelId| system.codels[codel].path.clone();
    let control =
        |component: ComponentId| ThreadName::of_component(&system.components[component].name);
    let thread = |codel: CodelId| {
        let machine = |automaton: &&crate::system::Automaton| {
            let states = &system.machines[automaton.machine].states;
            states.iter().any(|state| state.codel == codel)
        };
        match system.automata.iter().find(machine) {
            Some(automaton) => system.task_name(automaton.task),
            None => control(system.codels[codel].component),
        }
    };
    match spent {
        Spent::Executes(codel) => (Some(thread(codel)), StretchKind::Executes(path(codel))),
        Spent::Preempted(codel) => (Some(thread(codel)), StretchKind::Preempted(path(codel))),
        Spent::Locks { codel, holder } => {
            let holder = holder.map(path);
            (Some(thread(codel)), StretchKind::Locks { codel: path(codel), holder })
        }
        Spent::Core(task) => (Some(system.task_name(task)), StretchKind::Core),
        Spent::Between(task) => (Some(system.task_name(task)), StretchKind::Between),
        Spent::Unrequested(service) => {
            let component = system.services[service].component;
            (Some(control(component)), StretchKind::Unrequested(system.service_path(service)))
        }
        Spent::Control(component) => (Some(control(component)), StretchKind::Between),
        Spent::Client(client) => {
            let name = &system.clients[client].name;
            (Some(ThreadName::of_component(name)), StretchKind::Client)
        }
        Spent::Nothing => (None, StretchKind::Nothing),
    }
}
