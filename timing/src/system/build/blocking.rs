//! Codels that block a task of another component, or a task with which they share nothing, for a whole
//! period.

use typed_index_collections::{TiVec, ti_vec};

use super::Builder;
use crate::diagnostic::remark::Remark;
use crate::scn::semantics::LockRule;
use crate::system::locks::live_codels;
use crate::system::{CodelId, ComponentId, FOREVER, TaskId, Ticks};

/// A codel that can run, and its thread: a task, or the control task of its component (`None`).
#[derive(Clone, Copy, PartialEq, Eq)]
struct RunnableCodel {
    codel: CodelId,
    component: ComponentId,
    task: Option<TaskId>,
}

impl RunnableCodel {
    fn same_thread(self, other: RunnableCodel) -> bool {
        (self.component, self.task) == (other.component, other.task)
    }
}

impl Builder<'_> {
    /// Reports codels that hold up the lock queue, or a port, for the whole period of a task that waits.
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
        for diagnostic in found {
            self.report(diagnostic);
        }
    }

    fn live(&self) -> Vec<RunnableCodel> {
        let system = &self.out.system;
        let mut task_of: TiVec<CodelId, _> = ti_vec![None; system.codels.len()];
        for automaton in &system.automata {
            for state in &system.machines[automaton.machine].states {
                task_of[state.codel] = Some(automaton.task);
            }
        }
        let live = live_codels(&self.out).into_iter_enumerated();
        live.filter(|(_, live)| *live)
            .map(|(codel, _)| RunnableCodel {
                codel,
                component: system.codels[codel].component,
                task: task_of[codel],
            })
            .collect()
    }

    fn waits_for(&self, waiting: RunnableCodel, codel: RunnableCodel) -> bool {
        let system = &self.out.system;
        !waiting.same_thread(codel) && system.codels[waiting.codel].conflicts.contains(codel.codel)
    }

    /// Returns the task with the shortest period of at most `time`, among the tasks of some codels.
    fn shortest<'l>(
        &self,
        codels: impl Iterator<Item = &'l RunnableCodel>,
        time: Ticks,
    ) -> Option<(&'l RunnableCodel, TaskId, Ticks)> {
        let with_period = codels.filter_map(|codel| {
            let task = codel.task?;
            Some((codel, task, self.out.system.tasks[task].period?))
        });
        let too_short = with_period.filter(|period| period.2 <= time);
        too_short.min_by_key(|period| period.2)
    }

    fn holds_port(
        &self,
        live: &[RunnableCodel],
        long: RunnableCodel,
        time: Ticks,
    ) -> Option<Remark> {
        let others = live.iter().filter(|codel| codel.component != long.component);
        let waiting = others.filter(|codel| self.waits_for(**codel, long));
        let (other, task, period) = self.shortest(waiting, time)?;
        let system = &self.out.system;
        Some(Remark::PortHold {
            codel: system.codels[long.codel].path.to_string(),
            time: self.seconds(time),
            other: system.codels[other.codel].path.to_string(),
            task: system.task_path(task),
            period: self.seconds(period),
        })
    }

    fn holds_up_queue(
        &self,
        live: &[RunnableCodel],
        long: RunnableCodel,
        time: Ticks,
    ) -> Option<Remark> {
        let semantics = self.settings.semantics();
        if semantics.locks != LockRule::Queue {
            return None;
        }
        let own = || live.iter().filter(|codel| codel.component == long.component);
        let heads: Vec<RunnableCodel> =
            own().filter(|codel| self.waits_for(**codel, long)).copied().collect();
        // A task that shares a lock with the codel waits in any case, and is not reported. Any codel of such
        // a task can be at the head of the queue.
        let shares = |codel: &RunnableCodel| heads.iter().any(|head| head.same_thread(*codel));
        let behind = own().filter(|codel| !codel.same_thread(long) && !shares(codel));
        let (_, task, period) = self.shortest(behind, time)?;
        let system = &self.out.system;
        Some(Remark::LockQueue {
            codel: system.codels[long.codel].path.to_string(),
            time: self.seconds(time),
            head: system.codels[heads.first()?.codel].path.to_string(),
            task: system.task_path(task),
            period: self.seconds(period),
        })
    }

    fn seconds(&self, time: Ticks) -> dotgen_analysis::model::Seconds {
        self.out.system.seconds(time)
    }
}
