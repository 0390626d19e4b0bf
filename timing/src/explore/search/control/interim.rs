//! Intermediate findings: final answers, reported while the exploration goes on.

use super::SearchControl;
use crate::explore::findings::Findings;
use crate::explore::run::Run;
use crate::explore::search::goals::{GoalId, PerGoal};
use crate::explore::search::layers::Layers;

pub(in crate::explore::search) type FindingsReceiver<'a> = &'a mut dyn FnMut(&Findings);

/// The receiver of findings, and the goals already reported.
pub(super) struct InterimFindings<'a> {
    receiver: FindingsReceiver<'a>,
    /// Goals already reported; `None` if there was no report yet.
    reported: Option<PerGoal<bool>>,
}

impl<'a> InterimFindings<'a> {
    pub(super) fn new(receiver: FindingsReceiver<'a>) -> Self {
        InterimFindings { receiver, reported: None }
    }
}

impl<'a> SearchControl<'a> {
    /// Reports new final answers: failures, reached predicates, and predicates that are never reached. Later
    /// findings change neither the answers nor their runs.
    pub(super) fn report_interim(&mut self, layers: &Layers<'a>) {
        let Some(mut news) = self.news.take() else {
            return;
        };
        let goals = &layers.observations.goals;
        let reported = |goal| news.reported.as_ref().is_some_and(|reported| reported[goal]);
        let is_new = |goal| !reported(goal) && self.is_known(layers, goal);
        if goals.ids().any(is_new) {
            let [missed, overdue, reached] = goals.split(goals.each(|goal| {
                let run = is_new(goal).then(|| self.known_run(layers, goal));
                run.flatten()
            }));
            news.reported = Some(goals.each(|goal| self.is_known(layers, goal)));
            let watch = layers.observations.watch;
            let found = Findings {
                missed,
                overdue,
                reached,
                response: vec![None; watch.response.len()],
                within: vec![None; watch.within.len()],
                ..Findings::default()
            };
            (news.receiver)(&found);
        }
        self.news = Some(news);
    }

    /// Returns a found run, if the run is final.
    fn final_run(&self, goal: GoalId) -> Option<&Run> {
        let found_run = self.random_search.as_ref().ok()?.found_run(goal)?;
        found_run.is_final.then_some(&found_run.run)
    }

    /// Returns true if a goal was seen, or has a final found run.
    fn is_known(&self, layers: &Layers<'a>, goal: GoalId) -> bool {
        layers.observations.seen.goals[goal].is_some() || self.final_run(goal).is_some()
    }

    fn known_run(&self, layers: &Layers<'a>, goal: GoalId) -> Option<Run> {
        let found_run = self.final_run(goal).cloned();
        found_run.or_else(|| layers.run_to(goal))
    }
}
