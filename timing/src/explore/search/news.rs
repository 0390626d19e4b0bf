//! What has been seen, or is proved, for good while the exploration goes on: told at once.

use super::Search;
use crate::explore::findings::{Findings, Found};
use crate::explore::reductions::Reduced;
use crate::explore::run::Run;

/// Whom to tell.
pub(super) type Teller<'a> = &'a mut dyn FnMut(&Findings);

/// Whom to tell, and what was told already, by the lists of the watch.
pub(super) struct News<'a> {
    teller: Teller<'a>,
    told: [Vec<bool>; 3],
    /// What zones have proved was told.
    proved: bool,
}

impl<'a> News<'a> {
    pub(super) fn new(teller: Teller<'a>) -> Self {
        News {
            teller,
            told: Default::default(),
            proved: false,
        }
    }
}

impl<R: Reduced> Search<'_, R> {
    /// Tells what is new: what fails, is reached, or never is. What comes later does not change that, nor the
    /// run that shows it.
    pub(super) fn tell_news(&mut self) {
        let Some(mut news) = self.news.take() else {
            return;
        };
        let told = |list: usize, i: usize| news.told[list].get(i) == Some(&true);
        let is_new = |list, i| !told(list, i) && self.is_known(list, i);
        let any = (0..3).any(|list| (0..self.sights()[list].len()).any(|i| is_new(list, i)));
        if any || news.proved != self.is_proved() {
            let [missed, overdue, reached] = self.for_each(|list, i| {
                let run = is_new(list, i).then(|| self.known_run(list, i));
                run.flatten().map(|run| Found { run })
            });
            news.told = self.for_each(|list, i| self.is_known(list, i));
            news.proved = self.is_proved();
            let watch = self.watch;
            let found = Findings {
                missed,
                overdue,
                reached,
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

    /// The run that was caught, if it is final.
    fn final_catch(&self, list: usize, i: usize) -> Option<&Run> {
        let caught = self.hunt.as_ref()?.caught(list, i)?;
        caught.is_final.then_some(&caught.run)
    }

    /// Whether something was seen, or caught for good.
    fn is_known(&self, list: usize, i: usize) -> bool {
        self.sights()[list][i].is_some() || self.final_catch(list, i).is_some()
    }

    /// The run that shows it.
    fn known_run(&self, list: usize, i: usize) -> Option<Run> {
        let caught = self.final_catch(list, i).cloned();
        caught.or_else(|| self.seen_run(list, i))
    }
}
