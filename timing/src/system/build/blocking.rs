//! Codels that keep a task of another component, or one that shares nothing with them, waiting for a whole
//! period.

use num_rational::Ratio;

use super::Builder;
use crate::diagnostic::remark::Remark;
use crate::scn::semantics::LockRule;
use crate::system::locks::live_codels;
use crate::system::{FOREVER, Ticks};

/// A codel that can be executed, and who executes it: a task, or (`None`) the control task of its component.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Live {
    codel: usize,
    component: usize,
    task: Option<usize>,
}

impl Live {
    fn same_thread(self, other: Live) -> bool {
        (self.component, self.task) == (other.component, other.task)
    }
}

impl Builder<'_> {
    /// Reports codels that hold up the lock queue, or a port, for as long as the period of a task that waits.
    pub(super) fn blocking(&mut self) {
        let live = self.live();
        let mut found = Vec::new();
        for &long in &live {
            let time = self.out.system.codels[long.codel].upper;
            if time == FOREVER || time == 0 {
                continue;
            }
            let remark = self.holds_port(&live, long, time);
            let remark = remark.or_else(|| self.holds_up_queue(&live, long, time));
            let codel = &self.out.system.codels[long.codel];
            if let (Some(remark), Some((c, _)), Some(src)) = (remark, codel.site, codel.src) {
                found.push(remark.warning(0..0, vec![self.place(c, src, "this codel")]));
            }
        }
        for it in found {
            self.report(it);
        }
    }

    fn live(&self) -> Vec<Live> {
        let system = &self.out.system;
        let mut task_of = vec![None; system.codels.len()];
        for automaton in &system.automata {
            for state in &system.machines[automaton.machine].states {
                task_of[state.codel] = Some(automaton.task);
            }
        }
        let live = live_codels(&self.out).into_iter().enumerate();
        live.filter(|it| it.1)
            .map(|(codel, _)| Live {
                codel,
                component: system.codels[codel].component,
                task: task_of[codel],
            })
            .collect()
    }

    fn waits_for(&self, waiting: Live, it: Live) -> bool {
        let system = &self.out.system;
        !waiting.same_thread(it) && system.codels[waiting.codel].conflicts.contains(it.codel)
    }

    /// The shortest period of a task that is no longer than a time, of the tasks of some codels.
    fn shortest<'l>(
        &self,
        codels: impl Iterator<Item = &'l Live>,
        time: Ticks,
    ) -> Option<(&'l Live, usize, Ticks)> {
        let with_period = codels.filter_map(|it| {
            let task = it.task?;
            Some((it, task, self.out.system.tasks[task].period?))
        });
        let too_short = with_period.filter(|it| it.2 <= time);
        too_short.min_by_key(|it| it.2)
    }

    fn holds_port(&self, live: &[Live], long: Live, time: Ticks) -> Option<Remark> {
        let others = live.iter().filter(|it| it.component != long.component);
        let waiting = others.filter(|it| self.waits_for(**it, long));
        let (other, task, period) = self.shortest(waiting, time)?;
        let system = &self.out.system;
        Some(Remark::PortHold {
            codel: system.codels[long.codel].path.clone(),
            time: self.seconds(time),
            other: system.codels[other.codel].path.clone(),
            task: system.task_path(task),
            period: self.seconds(period),
        })
    }

    fn holds_up_queue(&self, live: &[Live], long: Live, time: Ticks) -> Option<Remark> {
        let semantics = self.settings.semantics();
        if semantics.is_published() || semantics.locks != LockRule::Queue {
            return None;
        }
        let own = || live.iter().filter(|it| it.component == long.component);
        let heads: Vec<Live> = own()
            .filter(|it| self.waits_for(**it, long))
            .copied()
            .collect();
        // Who waits for it anyway is no news, and whoever does can be at the head.
        let shares = |it: &Live| heads.iter().any(|head| head.same_thread(*it));
        let behind = own().filter(|it| !it.same_thread(long) && !shares(it));
        let (_, task, period) = self.shortest(behind, time)?;
        let system = &self.out.system;
        Some(Remark::LockQueue {
            codel: system.codels[long.codel].path.clone(),
            time: self.seconds(time),
            head: system.codels[heads.first()?.codel].path.clone(),
            task: system.task_path(task),
            period: self.seconds(period),
        })
    }

    fn seconds(&self, time: Ticks) -> dotgen_analysis::model::Seconds {
        self.out.system.unit * Ratio::from_integer(i128::from(time))
    }
}
