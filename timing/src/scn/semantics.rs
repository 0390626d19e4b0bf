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

    /// Returns true if all points are those of the published models, which have their own rules, with either
    /// of the two orders of locks that these rules support.
    pub fn is_published(self) -> bool {
        let locks = self.locks;
        locks != LockRule::Queue && self == Semantics { locks, ..Semantics::PUBLISHED }
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
