//! Findings that the reference compiler does not report: see [`crate::lint`].

use std::fmt;

use dotgen_syntax::findings;

use crate::{
    fixes::{FixSite, TextFix},
    model::{Name, OwnerName, Seconds},
};

/// A codel and its owner.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CodelName {
    /// The name.
    pub name: Name,
    /// The task or service.
    pub owner: OwnerName,
}

impl fmt::Display for CodelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "codel `{}` of {}", self.name, self.owner)
    }
}

/// A time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Time(pub Seconds);

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&crate::quantity::time(self.0))
    }
}

/// A share of a core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Share(pub Seconds);

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&crate::quantity::load(self.0))
    }
}

/// Names, shown as `a`, `b` and `c`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ListedNames(pub Vec<Name>);

impl ListedNames {
    /// The verb form for their number.
    fn verb(&self, one: &'static str, many: &'static str) -> &'static str {
        if self.0.len() == 1 { one } else { many }
    }
}

impl fmt::Display for ListedNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, name) in self.0.iter().enumerate() {
            let before = match i {
                0 => "",
                _ if i + 1 == self.0.len() => " and ",
                _ => ", ",
            };
            write!(f, "{before}`{name}`")?;
        }
        Ok(())
    }
}

/// Names with a verb, for late codels.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LateCodels(pub ListedNames);

impl fmt::Display for LateCodels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0, self.0.verb("comes", "come"))
    }
}

/// States or services in a cycle, shown as `a → b → a`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CyclePath(pub Vec<Name>);

impl fmt::Display for CyclePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for name in &self.0 {
            write!(f, "{name} → ")?;
        }
        f.write_str(self.0.first().map_or("", |text| text.as_str()))
    }
}

/// Consecutive codels with their times, shown as `f 1 ms + g 2 ms`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Chain(pub Vec<(Name, Option<Time>)>);

impl fmt::Display for Chain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (name, time)) in self.0.iter().enumerate() {
            let plus = if i == 0 { "" } else { " + " };
            write!(f, "{plus}{name} ")?;
            match time {
                Some(time) => write!(f, "{time}")?,
                None => f.write_str("?")?,
            }
        }
        Ok(())
    }
}

findings! {
    /// Legal text that is probably a mistake.
    pub enum LintWarning {
        "port/never-read" PortNeverRead { name: Name } => "no codel reads the input port `{name}`";
        "port/never-written" PortNeverWritten { name: Name }
            => "no codel writes the output port `{name}`: its readers will never get data",
               "add `out {name}` to a codel";
        "port/write-race" WriteRace { name: Name, tasks: ListedNames }
            => "port `{name}` is written by codels of different tasks ({tasks}): which value readers see \
                depends on scheduling",
               "let one task write it, or give each its own port";
        "ids/never-read" MemberUnused { name: Name }
            => "no codel or attribute uses the ids member `{name}`";
        "ids/never-read" MemberNeverRead { name: Name }
            => "the ids member `{name}` is written, but nothing ever reads it";
        "ids/never-written" MemberNeverWritten { name: Name }
            => "the ids member `{name}` is read, but nothing ever writes it";
        "ids/read-before-write" ReadBeforeWrite { codel: CodelName, name: Name }
            => "{codel} reads `{name}` from the start, but only requests write it: until the first one \
                the value is undefined",
               "write it in the `start` codel of a task";

        "lock/long-hold" LongHold {
            codel: CodelName, through: Name, time: Time, task: Name, period: Time, other: CodelName,
        }
            => "{codel} can hold {through} for {time}, longer than the period of task `{task}` \
                ({period}), whose {other} waits for it: the task will miss ticks",
               "split the codel, or copy the data first";
        "lock/self-blocking" SelfBlocking {
            codel: CodelName, through: Name, other: CodelName, task: Name,
        }
            => "{codel} runs asynchronously with {through}, which {other} of the same task `{task}` also \
                uses: the task goes on meanwhile and must wait for it, or both touch the data at once",
               "copy what the asynchronous codel needs into a `local` variable";

        "service/concurrent-instances" ConcurrentInstances { name: Name, param: Name }
            => "activity `{name}` does not interrupt itself: two requests run two instances in turn, and \
                both write `{param}`",
               "add `interrupts {name};` if only one should be active";
        "service/blind-validate" BlindValidate { codel: Name, attribute: Name, value: Name }
            => "`{codel}` validates attribute `{attribute}` without seeing the new value: its parameters \
                come from the ids, which still hold the old one",
               "write `local in {value}`";
        "service/long-function" LongFunction { name: Name, time: Time, budget: Time }
            => "`{name}` keeps the control task busy for {time} (more than {budget}), and no other \
                request is served meanwhile",
               "make it an activity";
        "service/order-cycle" OrderCycle { round: CyclePath }
            => "`before` and `after` go round in a circle: {round}", "no order satisfies them";

        "fsm/no-termination" NoTermination { owner: OwnerName, round: CyclePath, closing: Name }
            => "{owner} never ends: no path leads from `start` to `ether`, and it can go round {round} \
                without ever pausing",
               "yield `ether` somewhere, or `pause::{closing}` to let others run";
        "fsm/busy-loop" BusyLoop { owner: OwnerName, round: CyclePath, cost: &'static str, closing: Name }
            => "state cycle without pause in {owner}: {round}",
               "{cost}; yield `pause::{closing}` if each round may wait";
        "fsm/pause-in-aperiodic-task" AperiodicPause { task: Name, state: Name }
            => "task `{task}` has no period, and nothing ends `pause::{state}`: there is no other activity, \
                attribute or function in its component",
               "give the task a `period`, or yield the state without `pause::`";
        "fsm/dead-end" DeadEnd { codel: Name, states: ListedNames }
            => "the machine is stuck after `{codel}`: none of the states it yields ({states}) has a codel";
        "fsm/codel-named-as-event" NamedAsEvent { codel: Name, state: Name, free: Name }
            => "the codel `{codel}` has the name that the mapping gives to the state `{state}`: no C compiler \
                accepts the function",
               "rename it, for example to `{free}`";
        "fsm/missing-stop" MissingStop { name: Name, by: Name, what: &'static str, param: Name }
            => "activity `{name}` can be interrupted (by `{by}`) and writes the {what} `{param}`, but has \
                no `codel<stop>` to leave it in a consistent state";

        "timing/missing-wcet" MissingWcet { codel: Name }
            => "codel `{codel}` has no execution time and counts as taking none",
               "add `wcet` with the measured worst case";
        "timing/wcet-exceeds-period" CodelExceedsPeriod {
            codel: Name, time: Time, task: Name, period: Time,
        }
            => "codel `{codel}` can take {time}, longer than the period of task `{task}` ({period})",
               "split it, make it `async`, or lengthen the period";
        "timing/wcet-exceeds-period" ChainExceedsPeriod {
            state: Name, owner: OwnerName, time: Time, chain: Chain, task: Name, period: Time,
        }
            => "from `{state}` to the next pause, {owner} can take {time} ({chain}), longer than the \
                period of task `{task}` ({period})",
               "pause in between";
        "timing/no-period" NoPeriod { task: Name }
            => "task `{task}` has execution times and a permanent activity that pauses, but no `period`: \
                nothing says how often it runs, so its load and response times cannot be computed";
        "timing/overutilised" Overutilised { component: Name, share: Share, cores: u32 }
            => "the permanent activities of `{component}` need {share} of a core, but the platform has \
                {cores}",
               "lengthen periods or shorten codels";
        "timing/suspicious-unit" LongCodel { codel: Name, time: Time }
            => "codel `{codel}` has a worst case of {time}: a number without unit is in seconds",
               "write `ms` or `us` if that was meant";
        "timing/suspicious-unit" ShortPeriod { task: Name, period: Time }
            => "task `{task}` has a period of {period}, shorter than any real scheduler can keep",
               "check the unit";

        "unused/exception" NeverThrown { name: Name } => "exception `{name}` is never thrown";
        "unused/type" TypeUnused { what: &'static str, name: Name } => "{what} `{name}` is never used";
        "unused/local" LocalUnused { name: Name } => "local variable `{name}` is never used";

        "style/missing-doc" MissingDoc { what: &'static str, name: Name }
            => "{what} `{name}` has no `doc`";
        "style/naming" OddName { name: Name, convention: &'static str }
            => "service `{name}` is not in {convention}, as most services of this component are";
        "style/order" OddOrder { late: LateCodels }
            => "{late} late: attributes first, then functions, then activities";

        "genom3/deviation" CharacterLiteral { text: Name }
            => "genom3 refuses the character {text} (deviation D03): it converts a character literal to no \
                type",
               "write it as a string of one character, which both accept";
        "genom3/deviation" InlineSwitch { name: Name }
            => "genom3 refuses the union `{name}` (deviation D04): its switch is an enum declared in place",
               "declare the enum before the union";
        "genom3/deviation" WideInteger { text: Name, kept: i32 }
            => "genom3 reads `{text}` as {kept} (deviation D07): it keeps 32 bits of an integer, and refuses \
                the value where it no longer fits",
               "keep integers below 2147483648 if genom3 must read the specification";

        "lint/unused-suppression" UnusedAllowance { code: Name }
            => "nothing here is reported as `{code}`: remove it from the comment";
        "lint/unused-suppression" UnknownAllowance { code: Name }
            => "`{code}` is no code of a diagnostic";
        "lint/no-reason" NoReason => "say why this is allowed, after the parenthesis";
    }
}

impl LintWarning {
    /// The fixes, the best first, made from the text around.
    pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
        let fix = match self {
            LintWarning::BusyLoop { .. } => return here.pause_somewhere(),
            LintWarning::NoTermination { .. } => {
                return here.end_somewhere().into_iter().chain(here.pause_somewhere()).collect();
            }
            LintWarning::MissingWcet { .. } => return here.add_wcet(),
            LintWarning::NamedAsEvent { codel, free, .. } => Some(here.rename_codel(codel, free)),
            LintWarning::MissingStop { .. } => here.add_codel("stop").map(TextFix::choice),
            LintWarning::BlindValidate { .. } => here.validate_new_value(),
            LintWarning::ConcurrentInstances { .. } => here.interrupt_itself(),
            LintWarning::NeverThrown { .. }
            | LintWarning::TypeUnused { .. }
            | LintWarning::LocalUnused { .. } => here.remove_declaration(),
            LintWarning::UnusedAllowance { .. } | LintWarning::UnknownAllowance { .. } => {
                here.remove_comment()
            }
            _ => None,
        };
        fix.into_iter().collect()
    }
}
