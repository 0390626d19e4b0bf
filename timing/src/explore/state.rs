//! States of a timed system as two flat arrays of small numbers, whatever the rules.
//!
//! The *discrete* part holds statuses, positions and queues. The *times* hold the times of the rules (such as
//! timers), the window of remaining time of every executor, and observation clocks. The discrete part and the
//! times of the rules are the *key* of a state; windows and clocks are its *box*. States with the same key
//! are merged and compared by box (see [`super::store`]). Only the rules know the meaning of the numbers of
//! the key (see [`super::rules`]); a [`Frame`] contains the places of the common parts.
//!
//! An *executor* is anything that can spend time executing: an automaton, a control task, a client (its
//! delays). The window `[a, b]` of an executor means that it ends after any number of units in the window,
//! counted from now.

use std::ops::Range;

use crate::system::Ticks;

#[derive(Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct State {
    /// Discrete part.
    pub(crate) d: Vec<u16>,
    /// Times, in base units.
    pub(crate) t: Vec<Ticks>,
}

// Implemented by hand: states are copied all the time, and `clone_from` of a derived `Clone` keeps no memory.
impl Clone for State {
    fn clone(&self) -> Self {
        State { d: self.d.clone(), t: self.t.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        self.d.clone_from(&source.d);
        self.t.clone_from(&source.t);
    }
}

/// The status of a task and of its job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TaskStatus {
    /// No job.
    Idle,
    /// The job waits for a core.
    Waiting,
    /// The job has a core, or needs none.
    Running,
}

/// The phase of an executor.
pub(crate) mod phase {
    pub(crate) const REST: u16 = 0;
    pub(crate) const LOCKING: u16 = 1;
    pub(crate) const EXECUTING: u16 = 2;
    /// Flag: a separate thread executes the asynchronous codel.
    pub(crate) const ASYNC: u16 = 4;
}

/// The clocks of a state. Each clock distinguishes more states, so there are no others.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clocks {
    /// Tasks whose response times are measured.
    pub(crate) response: Vec<bool>,
    /// Stages, by observer.
    pub(crate) within: Vec<Stages>,
    /// Monitors: true for those that watch for some time.
    pub(crate) monitors: Vec<bool>,
    /// Number of comparisons of data.
    pub(crate) facts: usize,
    /// Numbers in the discrete part for the token of a chain.
    pub(crate) token: usize,
    /// Every component can be shut down from outside, and not only those that a client may kill.
    pub(crate) ends: bool,
}

/// The stages of an observer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stages {
    /// Number of stages: one for each response. An obligation can be open at each stage.
    pub(crate) count: usize,
    /// The age of obligations is measured.
    pub(crate) measured: bool,
}

impl Clocks {
    /// Returns the absence of clocks and observers.
    pub(crate) fn none(tasks: usize) -> Self {
        Clocks { response: vec![false; tasks], ..Clocks::default() }
    }
}

/// The places of the common parts of a [`State`].
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// Number of executors.
    executors: usize,
    /// First place of the phases in the discrete part: one number per executor, see [`phase`].
    phase_base: usize,
    /// First place of the flags of stages in the discrete part: an obligation is open at the stage.
    observer_base: usize,
    /// Stages of each observer, numbered consecutively.
    stages: Vec<Range<usize>>,
    /// First place of the locations of monitors in the discrete part.
    monitor_base: usize,
    /// First place of the comparisons of data in the discrete part: 0 if unknown, 1 if false, 2 if true.
    fact_base: usize,
    token_base: usize,
    d_len: usize,
    window_base: usize,
    clock_base: usize,
    t_len: usize,
    /// Clock of the response time of each task, if it is measured.
    pub(crate) response: Vec<Option<usize>>,
    /// Clock of each stage, if it has one.
    stage_clock: Vec<Option<usize>>,
    /// The time that each monitor still watches, if it watches for some time. It counts down, so that, like
    /// the other clocks, a greater one allows whatever a smaller one allows.
    monitor_clock: Vec<Option<usize>>,
}

/// An allocator of places in a [`State`], which results in a [`Frame`].
#[derive(Debug, Default)]
pub(crate) struct Places {
    d: usize,
    t: usize,
    /// Number of executors, and the place of their phases.
    executors: (usize, usize),
}

impl Places {
    /// Allocates `n` places in the discrete part. Returns the first.
    pub(crate) fn discrete(&mut self, n: usize) -> usize {
        self.d += n;
        self.d - n
    }

    /// Allocates `n` places for times that belong to the key. Returns the first.
    pub(crate) fn times(&mut self, n: usize) -> usize {
        self.t += n;
        self.t - n
    }

    /// Allocates places for the phases of `n` executors.
    pub(crate) fn executors(&mut self, n: usize) {
        self.executors = (n, self.discrete(n));
    }

    /// Allocates places for windows, observers and clocks, with `own` further clocks of the rules, and ends
    /// the allocation. Also returns the place of the first further clock.
    pub(crate) fn frame(mut self, clocks: &Clocks, own: usize) -> (Frame, usize) {
        let mut count = 0;
        let stages: Vec<Range<usize>> = (clocks.within.iter())
            .map(|stages| {
                count += stages.count;
                count - stages.count..count
            })
            .collect();
        let observer_base = self.discrete(count);
        let monitor_base = self.discrete(clocks.monitors.len());
        let fact_base = self.discrete(clocks.facts);
        let token_base = self.discrete(clocks.token);
        let (executors, phase_base) = self.executors;
        let window_base = self.times(2 * executors);
        let clock_base = self.t;
        let mut clock = |wanted: &bool| wanted.then(|| self.times(1));
        let response = clocks.response.iter().map(&mut clock).collect();
        let each = (clocks.within.iter())
            .flat_map(|stages| std::iter::repeat_n(&stages.measured, stages.count));
        let stage_clock = each.map(&mut clock).collect();
        let monitor_clock = clocks.monitors.iter().map(&mut clock).collect();
        let first_own = self.times(own);
        let frame = Frame {
            executors,
            phase_base,
            observer_base,
            stages,
            monitor_base,
            fact_base,
            token_base,
            d_len: self.d,
            window_base,
            clock_base,
            t_len: self.t,
            response,
            stage_clock,
            monitor_clock,
        };
        (frame, first_own)
    }
}

impl Frame {
    /// Returns a state of zeros.
    pub(crate) fn blank(&self) -> State {
        let mut s = State::default();
        self.clear(&mut s);
        s
    }

    /// Sets all numbers of a state to zero.
    pub(crate) fn clear(&self, s: &mut State) {
        s.d.clear();
        s.d.resize(self.d_len, 0);
        s.t.clear();
        s.t.resize(self.t_len, 0);
    }

    pub(crate) fn state_bytes(&self) -> usize {
        size_of::<State>() + self.d_len * size_of::<u16>() + self.t_len * size_of::<Ticks>()
    }

    /// Returns the number of observation clocks.
    pub(crate) fn clocks(&self) -> usize {
        self.t_len - self.clock_base
    }

    /// Returns the number of executors.
    #[inline]
    pub(crate) fn executors(&self) -> usize {
        self.executors
    }

    /// Returns the phase of an executor, see [`phase`].
    #[inline]
    pub(crate) fn phase(&self, s: &State, executor: usize) -> u16 {
        s.d[self.phase_base + executor]
    }

    #[inline]
    pub(crate) fn set_phase(&self, s: &mut State, executor: usize, value: u16) {
        s.d[self.phase_base + executor] = value;
    }

    /// Returns the phases of all executors.
    #[inline]
    pub(crate) fn phases<'s>(&self, s: &'s State) -> &'s [u16] {
        &s.d[self.phase_base..self.phase_base + self.executors]
    }

    #[inline]
    pub(crate) fn is_executing(&self, s: &State, executor: usize) -> bool {
        self.phase(s, executor) & phase::EXECUTING != 0
    }

    /// Returns the executors that are executing.
    #[inline]
    pub(crate) fn executing<'s>(&self, s: &'s State) -> impl Iterator<Item = usize> + 's {
        let phases = self.phases(s).iter().enumerate();
        phases.filter(|&(_, &number)| number & phase::EXECUTING != 0).map(|(e, _)| e)
    }

    #[inline]
    pub(crate) fn window(&self, s: &State, executor: usize) -> (Ticks, Ticks) {
        let at = self.window_base + 2 * executor;
        (s.t[at], s.t[at + 1])
    }

    #[inline]
    pub(crate) fn set_window(&self, s: &mut State, executor: usize, (a, b): (Ticks, Ticks)) {
        let at = self.window_base + 2 * executor;
        s.t[at] = a;
        s.t[at + 1] = b;
    }

    /// Returns the first place of the token of a chain.
    pub(crate) fn token_place(&self) -> usize {
        self.token_base
    }

    /// Returns the location of a monitor.
    #[inline]
    pub(crate) fn monitor(&self, s: &State, monitor: usize) -> u16 {
        s.d[self.monitor_base + monitor]
    }

    pub(crate) fn set_monitor(&self, s: &mut State, monitor: usize, location: u16) {
        s.d[self.monitor_base + monitor] = location;
    }

    /// Returns the value of a comparison of data; `None` if it is unknown.
    pub(crate) fn fact(&self, s: &State, fact: usize) -> Option<bool> {
        s.d[self.fact_base + fact].checked_sub(1).map(|value| value > 0)
    }

    pub(crate) fn set_fact(&self, s: &mut State, fact: usize, holds: bool) {
        s.d[self.fact_base + fact] = 1 + u16::from(holds);
    }

    /// Returns the place of the time that a monitor still watches, if it watches for some time.
    #[inline]
    pub(crate) fn monitor_clock(&self, monitor: usize) -> Option<usize> {
        self.monitor_clock[monitor]
    }

    /// Returns the stages of an observer, from first to last.
    #[inline]
    pub(crate) fn stages(&self, observer: usize) -> Range<usize> {
        self.stages[observer].clone()
    }

    /// Returns the clock of a stage, if it has one.
    #[inline]
    pub(crate) fn stage_clock(&self, stage: usize) -> Option<usize> {
        self.stage_clock[stage]
    }

    /// Returns true if an obligation is open at a stage.
    #[inline]
    pub(crate) fn is_open_at(&self, s: &State, stage: usize) -> bool {
        s.d[self.observer_base + stage] != 0
    }

    pub(crate) fn set_open_at(&self, s: &mut State, stage: usize, open: bool) {
        s.d[self.observer_base + stage] = u16::from(open);
    }

    /// Returns true if an obligation of an observer is open.
    #[inline]
    pub(crate) fn is_open(&self, s: &State, observer: usize) -> bool {
        (self.stages(observer)).any(|stage| self.is_open_at(s, stage))
    }

    /// Returns the clock of the oldest open obligation of an observer, if the observer has clocks. An
    /// obligation at a later stage is older.
    #[inline]
    pub(crate) fn observer_clock(&self, s: &State, observer: usize) -> Option<usize> {
        let stages = self.stages(observer);
        let oldest = (stages.clone().rev()).find(|&stage| self.is_open_at(s, stage));
        self.stage_clock[oldest.unwrap_or(stages.start)]
    }

    /// Returns the times that belong to the key.
    #[inline]
    pub(crate) fn key_times<'s>(&self, s: &'s State) -> &'s [Ticks] {
        &s.t[..self.window_base]
    }

    /// Returns the times that belong to the key, for changes.
    #[inline]
    pub(crate) fn key_times_mut<'s>(&self, s: &'s mut State) -> &'s mut [Ticks] {
        &mut s.t[..self.window_base]
    }

    /// Returns the observation clocks.
    #[inline]
    pub(crate) fn clock_values<'s>(&self, s: &'s State) -> &'s [Ticks] {
        &s.t[self.clock_base..]
    }

    /// Returns the observation clocks, for changes.
    #[inline]
    pub(crate) fn clock_values_mut<'s>(&self, s: &'s mut State) -> &'s mut [Ticks] {
        &mut s.t[self.clock_base..]
    }

    /// Lets time pass in windows, and in the clocks of open obligations and of monitors. The rules advance
    /// response times.
    #[inline]
    pub(crate) fn elapse(&self, s: &mut State, time: Ticks) {
        for executor in 0..self.executors {
            if self.is_executing(s, executor) {
                let (a, b) = self.window(s, executor);
                let b = if b == crate::system::FOREVER { b } else { b - time };
                self.set_window(s, executor, (a.saturating_sub(time), b));
            }
        }
        for (stage, clock) in self.stage_clock.iter().enumerate() {
            if let Some(clock) = *clock
                && self.is_open_at(s, stage)
            {
                s.t[clock] += time;
            }
        }
        for clock in self.monitor_clock.iter().flatten() {
            s.t[*clock] = s.t[*clock].saturating_sub(time);
        }
    }
}
