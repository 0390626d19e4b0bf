//! Codels that execute at the same time, and the order of their requests.

use std::collections::VecDeque;

use dotgen_timing::scn::semantics::LockRule;
use dotgen_timing::system::{CodelId, TimedSystem};

use super::CLOCK_TOLERANCE_NANOS;

/// Upper limit on the runs kept for comparison with later runs.
const MAX_KEPT_RUNS: usize = 4_096;

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CodelRun {
    pub(super) asked: i64,
    pub(super) began: i64,
    pub(super) ended: i64,
    /// Line of the log.
    pub(super) line: u64,
    pub(super) codel: CodelId,
    /// Process.
    pub(super) instance: u32,
    /// Thread; `None`: a thread of its own.
    pub(super) thread: Option<usize>,
    /// Core: `None` if it needs none; `Some(None)` if it can be any core.
    pub(super) core: Option<Option<u32>>,
    /// Core that the thread is bound to, and its priority, if threads are preempted; the lower number goes
    /// first.
    pub(super) core_and_priority: Option<(u32, u64)>,
}

/// A violation by the first codel, with the other codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OrderViolation {
    Together(CodelId),
    Overtaken(CodelId),
    SameThread(CodelId),
    SameCore(CodelId, u32),
    Cores(usize, u32),
}

/// Runs, in order of their ends.
#[derive(Debug)]
pub(super) struct RunOrder {
    recent: VecDeque<CodelRun>,
    /// Number of cores, if a codel keeps its core to its end.
    cores: Option<u32>,
    in_order: bool,
    queue: bool,
}

impl CodelRun {
    fn overlaps(&self, other: &CodelRun) -> bool {
        self.began < other.ended && other.began < self.ended
    }

    /// Returns true if a run with priority on the same core had begun, and this run continued to its end
    /// nevertheless.
    fn ignores(&self, other: &CodelRun) -> bool {
        let (Some((core, own)), Some((same, first))) =
            (self.core_and_priority, other.core_and_priority)
        else {
            return false;
        };
        core == same
            && first < own
            && self.began < other.began
            && other.began + CLOCK_TOLERANCE_NANOS < self.ended
            && self.ended + CLOCK_TOLERANCE_NANOS < other.ended
    }

    fn executes_at(&self, moment: i64) -> bool {
        self.began <= moment && moment < self.ended
    }
}

impl RunOrder {
    pub(super) fn new(system: &TimedSystem) -> Self {
        let platform = &system.platform;
        let preempts = super::model::preempts(system);
        RunOrder {
            recent: VecDeque::new(),
            cores: platform.cores.filter(|_| !preempts),
            in_order: platform.semantics.locks != LockRule::Free,
            queue: platform.semantics.locks == LockRule::Queue,
        }
    }

    pub(super) fn add(
        &mut self,
        system: &TimedSystem,
        run: CodelRun,
        out: &mut Vec<(CodelId, OrderViolation)>,
    ) {
        let excludes = |one: CodelId, other: CodelId| {
            let codel = system.codels.get(one);
            codel.is_some_and(|codel| codel.conflicts.contains(other))
        };
        let component = |codel: CodelId| system.codels.get(codel).map(|codel| codel.component);
        let (mut together, mut busy) = (false, 0usize);
        for earlier in self.recent.iter().rev() {
            // Runs are in order of their ends.
            if earlier.ended <= run.asked {
                break;
            }
            let one_process = earlier.instance == run.instance
                || component(earlier.codel) != component(run.codel);
            let overlaps = earlier.overlaps(&run);
            let (first, second) =
                if earlier.began <= run.began { (earlier, &run) } else { (&run, earlier) };
            if overlaps && one_process && excludes(second.codel, first.codel) {
                together = true;
                out.push((second.codel, OrderViolation::Together(first.codel)));
            }
            if self.in_order && one_process && !together {
                // The second codel asked first, and still waited when the first one got its locks.
                let overtaken = second.asked + CLOCK_TOLERANCE_NANOS < first.asked
                    && second.asked < first.began
                    && first.began + CLOCK_TOLERANCE_NANOS < second.began;
                let counts = excludes(second.codel, first.codel)
                    || self.queue && component(first.codel) == component(second.codel);
                if overtaken && counts {
                    out.push((first.codel, OrderViolation::Overtaken(second.codel)));
                }
            }
            let same = earlier.instance == run.instance
                && earlier.thread.is_some()
                && earlier.thread == run.thread;
            if overlaps && same && !together {
                out.push((second.codel, OrderViolation::SameThread(first.codel)));
            }
            if overlaps
                && !same
                && self.cores.is_some()
                && let (Some(Some(core)), Some(Some(other))) = (earlier.core, run.core)
                && core == other
            {
                out.push((second.codel, OrderViolation::SameCore(first.codel, core)));
            }
            if one_process
                && first.ignores(second)
                && let Some((core, _)) = first.core_and_priority
            {
                out.push((first.codel, OrderViolation::SameCore(second.codel, core)));
            }
            busy += usize::from(overlaps && earlier.core.is_some());
        }
        if let (Some(cores), true) = (self.cores, run.core.is_some())
            && busy + 1 > cores as usize
        {
            let max_cores_held = self.max_cores_held(&run);
            if max_cores_held > cores as usize {
                out.push((run.codel, OrderViolation::Cores(max_cores_held, cores)));
            }
        }
        let place = self.recent.iter().rposition(|earlier| earlier.ended <= run.ended);
        self.recent.insert(place.map_or(0, |place| place + 1), run);
        if self.recent.len() > MAX_KEPT_RUNS {
            self.recent.pop_front();
        }
    }

    /// Returns the greatest number of codels that hold a core at the same moment of a run.
    fn max_cores_held(&self, run: &CodelRun) -> usize {
        let recent = self.recent.iter().rev();
        let recent = recent.take_while(|earlier| earlier.ended > run.began);
        let others: Vec<&CodelRun> =
            recent.filter(|earlier| earlier.core.is_some() && earlier.overlaps(run)).collect();
        let starts = others.iter().map(|run| run.began).chain([run.began]);
        let starts = starts.filter(|&start| run.executes_at(start));
        let at = |moment: i64| others.iter().filter(|run| run.executes_at(moment)).count() + 1;
        starts.map(at).max().unwrap_or(0)
    }
}
