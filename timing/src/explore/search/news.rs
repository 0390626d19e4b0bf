//! What has been seen, or is proved, for good while the exploration goes on: told at once.

use super::trace::Goal;
use super::{Search, Sight};
use crate::explore::findings::{Findings, Found};
use crate::explore::run::Run;

/// Whom to tell.
pub(super) type Teller<'a> = &'a mut dyn FnMut(&Findings);

/// Whom to tell, and what was told already, by the lists of the watch.
pub(super) struct News<'a> {
    teller: Teller<'a>,
    missed: Vec<bool>,
    overdue: Vec<bool>,
    reached: Vec<bool>,
    /// What zones have proved was told.
    proved: bool,
}

impl<'a> News<'a> {
    pub(super) fn new(teller: Teller<'a>) -> Self {
        News {
            teller,
            missed: Vec::new(),
            overdue: Vec::new(),
            reached: Vec::new(),
            proved: false,
        }
    }
}

/// A run that was caught and is final.
type Caught<'s> = &'s dyn Fn(usize) -> Option<&'s Run>;

impl Search<'_> {
    /// Tells what is new: what fails, is reached, or never is. What comes later does not change that, nor the run that shows it.
    pub(super) fn tell_news(&mut self) {
        let Some(mut news) = self.news.take() else {
            return;
        };
        let hunt = self.hunt.as_ref();
        let missed: Caught = &|i| hunt?.told_missed(i);
        let overdue: Caught = &|i| hunt?.told_overdue(i);
        let reached: Caught = &|i| hunt?.told_reached(i);
        let any = is_new(&news.missed, &self.missed, missed)
            || is_new(&news.overdue, &self.overdue, overdue)
            || is_new(&news.reached, &self.reached, reached)
            || news.proved != self.is_proved();
        if any {
            news.proved = self.is_proved();
            let watch = self.watch;
            let found = Findings {
                missed: self.found(&mut news.missed, (&self.missed, missed), |i| {
                    Goal::Missed(watch.schedulable[i])
                }),
                overdue: self.found(&mut news.overdue, (&self.overdue, overdue), |i| {
                    Goal::Overdue(watch.overdue[i])
                }),
                reached: self.found(&mut news.reached, (&self.reached, reached), |i| {
                    Goal::Reach(&watch.reach[i])
                }),
                never: (0..watch.reach.len())
                    .map(|it| self.never_reached(it))
                    .collect(),
                no_deadlock: self.never_deadlocked(),
                response: vec![None; watch.response.len()],
                within: vec![None; watch.within.len()],
                ..Findings::default()
            };
            (news.teller)(&found);
        }
        self.news = Some(news);
    }

    /// What was seen or caught, and not told, which it is now.
    fn found<'g>(
        &self,
        told: &mut Vec<bool>,
        (seen, caught): (&[Option<Sight>], Caught),
        goal: impl Fn(usize) -> Goal<'g>,
    ) -> Vec<Option<Found>> {
        told.resize(seen.len(), false);
        let all = seen.iter().zip(told).enumerate();
        all.map(|(i, (seen, told))| {
            if *told {
                return None;
            }
            let run = match (caught(i), seen) {
                (Some(run), _) => run.clone(),
                (None, Some(at)) => self.trace(*at, &goal(i)),
                (None, None) => return None,
            };
            *told = true;
            Some(Found { run })
        })
        .collect()
    }
}

fn is_new(told: &[bool], seen: &[Option<Sight>], caught: Caught) -> bool {
    let mut all = seen.iter().enumerate();
    all.any(|(i, seen)| told.get(i) != Some(&true) && (seen.is_some() || caught(i).is_some()))
}
