//! Where there is nothing to verify: what holds of a system without times says nothing about the robot.

use dotgen_analysis::model::{CodelKind, CodelRef, Owner};

use super::Group;
use super::checks::Single;
use crate::report::{CheckReport, Verdict};

/// More codels than this are counted only.
const NAMED: usize = 3;

impl Group<'_> {
    /// The answer to a check of a task whose component has no execution time at all: that nothing was verified, what is
    /// missing and how to get it.
    pub(super) fn nothing(&self, check: &Single) -> Option<CheckReport> {
        let (c, _) = check.what.task()?;
        let number = *self.built.components.get(&c)?;
        let system = &self.built.system;
        let component = self.names.components[c].component;
        let codels = || {
            let all = system.codels.iter();
            all.filter(|it| it.component == number && it.site.is_some())
        };
        // Services that nobody requests execute nothing, but where only they have times, the others lack theirs.
        let has_time = |it: CodelRef| component.codel(it).wcet.is_some();
        let timed = codels().any(|it| it.upper > 0 || it.site.is_some_and(|it| has_time(it.1)));
        if timed {
            return None;
        }
        let executed: Vec<&str> = codels()
            .filter(|it| {
                let fsm = |at: CodelRef| component.codel(at).kind == CodelKind::Fsm;
                let of_task = |at: CodelRef| matches!(at.owner, Owner::Task(_)) || fsm(at);
                it.site.is_some_and(|it| of_task(it.1))
            })
            .map(|it| it.path.as_str())
            .collect();
        let mut names = executed[..executed.len().min(NAMED)].join(", ");
        if executed.len() > NAMED {
            names += &format!(" and {} more", executed.len() - NAMED);
        }
        let name = &component.name;
        let note = match executed.is_empty() {
            true => format!("`{name}` executes no codel"),
            false => format!(
                "no codel of `{name}` has an execution time: {names}; measure the longest one of each and write it as \
                 `wcet`, or as `duration` in a scenario"
            ),
        };
        Some(CheckReport {
            verdict: Verdict::Nothing,
            limit: None,
            note: Some(note),
            ..self.blank(check)
        })
    }
}
