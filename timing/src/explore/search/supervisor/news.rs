//! Intermediate findings: final answers, reported while the exploration goes on.

use super::Supervisor;
use crate::explore::findings::{Findings, Found};
use crate::explore::reductions::Reduced;
use crate::explore::run::Run;
use crate::explore::search::goals::{GoalId, PerGoal};
use crate::explore::search::layers::Layers;

/// Receiver of findings.
pub(in crate::explore::search) type Teller<'a> = &'a mut dyn FnMut(&Findings);

/// The receiver of findings, and the goals already reported.
pub(super) struct News<'a> {
    teller: Teller<'a>,
    /// Goals already reported; `None` if there was no report yet.
    told: Option<PerGoal<bool>>,
    /// The result of zones was reported.
    proved: bool,
}

impl<'a> News<'a> {
    pub(super) fn new(teller: Teller<'a>) -> Self {
        News {
            teller,
            told: None,
            proved: false,
        }
    }
}

impl<'a, R: Reduced> Supervisor<'a, R> {
    /// Reports new final answers: failures, reached predicates, and predicates that are never reached. Later
    /// findings change neither the answers nor their runs.
    pub(super) fn tell_news(&mut self, layers: &Layers<'a, R>) {
        let Some(mut news) = self.news.take() else {
            return;
        };
        let goals = &layers.watching.goals;
        let told = |goal| news.told.as_ref().is_some_and(|told| told[goal]);
        let is_new = |goal| !told(goal) && self.is_known(layers, goal);
        if goals.ids().any(is_new) || news.proved != self.proving.is_done() {
            let [missed, overdue, reached] = goals.split(goals.each(|goal| {
                let run = is_new(goal).then(|| self.known_run(layers, goal));
                run.flatten().map(|run| Found { run })
            }));
            news.told = Some(goals.each(|goal| self.is_known(layers, goal)));
            news.proved = self.proving.is_done();
            let watch = layers.watching.watch;
            let found = Findings {
                missed,
                overdue,
                reached,
                never: self.never(watch),
                absent: self.proving.absent().cloned().unwrap_or_default(),
                no_deadlock: self.proving.never_deadlocked(),
                response: vec![None; watch.response.len()],
                within: vec![None; watch.within.len()],
                ..Findings::default()
            };
            (news.teller)(&found);
        }
        self.news = Some(news);
    }

    /// Returns the run of a catch, if the catch is final.
    fn final_catch(&self, goal: GoalId) -> Option<&Run> {
        let caught = self.hunt.as_ref().ok()?.caught(goal)?;
        caught.is_final.then_some(&caught.run)
    }

    /// Returns true if a goal was seen, or has a final catch.
    fn is_known(&self, layers: &Layers<'a, R>, goal: GoalId) -> bool {
        layers.watching.seen.goals[goal].is_some() || self.final_catch(goal).is_some()
    }

    /// Returns the run to a goal.
    fn known_run(&self, layers: &Layers<'a, R>, goal: GoalId) -> Option<Run> {
        let caught = self.final_catch(goal).cloned();
        caught.or_else(|| layers.run_to(goal))
    }
}
