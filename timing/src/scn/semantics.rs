//! The semantics of the model: the servers that run on robots, or the published formal models, as a whole or
//! point by point (section 21 of the timed semantics).

/// Declares the rules of one point, or of another choice of a scenario, each with its word.
macro_rules! point {
    ($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $rule:ident = $word:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$of])* $rule,)* }

        impl $name {
            /// All rules, with their words.
            pub const ALL: &[(&str, $name)] = &[$(($word, $name::$rule),)*];

            /// Returns the rule as scenarios write it.
            pub fn name(self) -> &'static str {
                match self { $($name::$rule => $word,)* }
            }
        }
    };
}

point! {
    /// `semantics`
    #[derive(Default)]
    Preset {
        /// The servers that run on robots.
        #[default]
        Servers = "servers",
        /// The published formal models.
        Published = "published",
    }
}

point! {
    /// `ticks`
    TickRule {
        /// One clock per component, from its start.
        Component = "component",
        /// One timer per task, from the start of the task.
        Task = "task",
    }
}

point! {
    /// `turns`
    TurnRule {
        /// Passes: one codel of each automaton, then one of each again.
        Codel = "codel",
        /// An automaton executes until it pauses or ends, then the next.
        Pause = "pause",
    }
}

point! {
    /// `locks`
    LockRule {
        /// Any waiting codel may win, also repeatedly.
        Free = "free",
        /// In order of arrival, among codels that exclude each other.
        Fifo = "fifo",
        /// One queue per component: a codel behind the head waits, even without a conflict.
        Queue = "queue",
    }
}

point! {
    /// `ports`
    PortRule {
        /// Copied: no lock between components.
        Copy = "copy",
        /// An exclusive lock for the whole codel, across components.
        Lock = "lock",
    }
}

point! {
    /// `pause`: the event that resumes a paused automaton of an aperiodic task.
    PauseRule {
        /// An internal event.
        Events = "events",
        /// The next cycle.
        Turns = "turns",
    }
}

point! {
    /// `durations`: the interpretation of execution times.
    #[derive(Default)]
    Durations {
        /// From 0 to the worst case, both included.
        #[default]
        Interval = "interval",
        /// Always the worst case.
        Fixed = "fixed",
        /// More than 0, up to the worst case.
        Open = "open",
    }
}

point! {
    /// `policy`: the order in which cores are granted (section 9).
    #[derive(Default, serde::Serialize)]
    #[serde(rename_all = "lowercase")]
    Policy {
        /// In order of release.
        #[default]
        Fifo = "fifo",
        /// Earliest absolute deadline first, ties in order of release; never preempting.
        Edf = "edf",
        /// Any waiting task.
        Any = "any",
        /// The ready tasks of highest priority, preempting others.
        Priority = "priority",
        /// Any ready tasks, preempting others, as long as no core idles.
        Fair = "fair",
    }
}

/// The semantics of a model, with all points set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Semantics {
    /// Rule for every point that is not set separately.
    pub preset: Preset,
    /// Source of ticks, and start of tasks.
    pub ticks: TickRule,
    /// Order of turns of the automata of a task.
    pub turns: TurnRule,
    /// Order of locks.
    pub locks: LockRule,
    /// Locks of ports.
    pub ports: PortRule,
    /// Event that resumes paused automata of aperiodic tasks.
    pub pause: PauseRule,
}

impl Semantics {
    /// The servers that run on robots.
    pub const SERVERS: Semantics = Semantics {
        preset: Preset::Servers,
        ticks: TickRule::Component,
        turns: TurnRule::Codel,
        locks: LockRule::Queue,
        ports: PortRule::Copy,
        pause: PauseRule::Events,
    };

    /// The published formal models.
    pub const PUBLISHED: Semantics = Semantics {
        preset: Preset::Published,
        ticks: TickRule::Task,
        turns: TurnRule::Pause,
        locks: LockRule::Free,
        ports: PortRule::Lock,
        pause: PauseRule::Turns,
    };

    /// Returns all points of a preset.
    pub fn of(preset: Preset) -> Semantics {
        match preset {
            Preset::Servers => Semantics::SERVERS,
            Preset::Published => Semantics::PUBLISHED,
        }
    }

    /// Returns the points that a scenario does not choose: those of the published models if all others are
    /// theirs, with either of the two orders of locks that these models support.
    pub fn fixed(self) -> FixedPoints {
        let locks = self.locks;
        if locks != LockRule::Queue && self == (Semantics { locks, ..Semantics::PUBLISHED }) {
            FixedPoints::PUBLISHED
        } else {
            FixedPoints::SERVERS
        }
    }

    /// Returns the preset, then the points that differ from it, as scenarios write them.
    pub fn text(self) -> String {
        let preset = Semantics::of(self.preset);
        let points = [
            ("ticks", self.ticks.name(), preset.ticks.name()),
            ("turns", self.turns.name(), preset.turns.name()),
            ("locks", self.locks.name(), preset.locks.name()),
            ("ports", self.ports.name(), preset.ports.name()),
            ("pause", self.pause.name(), preset.pause.name()),
        ];
        let others = points.iter().filter(|(_, this, usual)| this != usual);
        let others: Vec<String> =
            others.map(|(point, this, _)| format!("{point} {this}")).collect();
        if others.is_empty() {
            self.preset.name().to_owned()
        } else {
            format!("{} with {}", self.preset.name(), others.join(", "))
        }
    }
}

/// The cycle of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cycle {
    /// Passes: in each pass, every automaton that runs and is not paused executes one codel (section 21). A
    /// task is one executor.
    Passes,
    /// Jobs: each automaton has one turn, up to its pause or end (section 4). An automaton is an executor:
    /// its first turn and its asynchronous codels are executed while its task does other work.
    Jobs,
}

/// The start of the tasks of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartUp {
    /// A task begins with its first tick. The next task is started after its first pass (section 21).
    FirstPass,
    /// A task executes its first codel at once, without a core. The next task is started after that codel
    /// (section 3).
    FirstCodel,
}

/// The handling of a message by a control task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handling {
    /// Several steps: a request is taken, validated and answered, then all activities are examined
    /// (section 21). Other actions can happen between the steps.
    InSteps,
    /// One step, except for codels (section 7).
    AtOnce,
}

/// The places of activities that have been accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slots {
    /// Those of their task (section 21).
    OfTask,
    /// Those of their service (section 7).
    OfService,
}

/// The values of the ids that a request reads or writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Copies {
    /// Copied for every kind of service, before its codels (section 21).
    BeforeCodels,
    /// Copied by attributes (section 7).
    OfAttributes,
}

/// The reason for which codels exclude each other, besides ports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exclusion {
    /// The lists of `mutex`, as codels with tickets test them (section 21).
    Tickets,
    /// Their data (section 6).
    Data,
}

/// The points that a scenario does not choose one by one, each with the reading that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedPoints {
    /// Cycle of a task.
    pub cycle: Cycle,
    /// Start of the tasks of a component.
    pub start_up: StartUp,
    /// Handling of a message by a control task.
    pub handling: Handling,
    /// Places of activities.
    pub slots: Slots,
    /// Values that requests read or write.
    pub copies: Copies,
    /// Exclusion of codels.
    pub exclusion: Exclusion,
    /// Codels throw the exceptions that they declare, unless the scenario says otherwise. Where they do not,
    /// an exception is an ordinary end.
    pub throws: bool,
    /// A tick of an idle task can be kept.
    pub keeps_idle_ticks: bool,
    /// Periods and delays are whole numbers of ticks of the component's clock.
    pub counts_clock_ticks: bool,
    /// Services have an order (`after`, `before`).
    pub has_order: bool,
    /// Clients can send `abort`, `kill` and `connect`, and await the success or failure of a request.
    pub has_builtin_services: bool,
    /// Codels that are `async` can have threads of their own.
    pub may_run_apart: bool,
    /// Threads can lose their cores.
    pub may_preempt: bool,
    /// Order in which cores are granted, if the scenario names none.
    pub policy: Policy,
}

impl FixedPoints {
    const SERVERS: FixedPoints = FixedPoints {
        cycle: Cycle::Passes,
        start_up: StartUp::FirstPass,
        handling: Handling::InSteps,
        slots: Slots::OfTask,
        copies: Copies::BeforeCodels,
        exclusion: Exclusion::Tickets,
        throws: true,
        keeps_idle_ticks: false,
        counts_clock_ticks: true,
        has_order: true,
        has_builtin_services: true,
        may_run_apart: false,
        may_preempt: true,
        policy: Policy::Priority,
    };

    const PUBLISHED: FixedPoints = FixedPoints {
        cycle: Cycle::Jobs,
        start_up: StartUp::FirstCodel,
        handling: Handling::AtOnce,
        slots: Slots::OfService,
        copies: Copies::OfAttributes,
        exclusion: Exclusion::Data,
        throws: false,
        keeps_idle_ticks: true,
        counts_clock_ticks: false,
        has_order: false,
        has_builtin_services: false,
        may_run_apart: true,
        may_preempt: false,
        policy: Policy::Fifo,
    };
}

/// Single points that a scenario sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Points {
    /// `ticks`
    pub ticks: Option<TickRule>,
    /// `turns`
    pub turns: Option<TurnRule>,
    /// `locks`
    pub locks: Option<LockRule>,
    /// `ports`
    pub ports: Option<PortRule>,
    /// `pause`
    pub pause: Option<PauseRule>,
}

impl Points {
    /// Returns the semantics of a preset, with these points instead of its own.
    pub fn over(&self, preset: Preset) -> Semantics {
        let of = Semantics::of(preset);
        Semantics {
            preset,
            ticks: self.ticks.unwrap_or(of.ticks),
            turns: self.turns.unwrap_or(of.turns),
            locks: self.locks.unwrap_or(of.locks),
            ports: self.ports.unwrap_or(of.ports),
            pause: self.pause.unwrap_or(of.pause),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_names_what_differs_from_the_preset() {
        assert_eq!(Semantics::SERVERS.text(), "servers");
        let points = Points {
            locks: Some(LockRule::Fifo),
            ports: Some(PortRule::Copy),
            ..Points::default()
        };
        assert_eq!(points.over(Preset::Servers).text(), "servers with locks fifo");
        assert_eq!(points.over(Preset::Published).text(), "published with locks fifo, ports copy");
    }
}
