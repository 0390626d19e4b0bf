//! The role of a place that is related to a finding, as data.

use std::fmt;

use smol_str::SmolStr;

use super::lints::{CodelName, Share};
use crate::model::{Name, OwnerName};

/// The role of a related place.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Role {
    First,
    FirstHere,
    FirstGiven,
    FirstUsed,
    FirstDeclared,
    Declared,
    NotDefined,
    Earlier,
    Declaration,
    Here,
    Used,
    UsedToo,
    Written,
    InInterface,
    Other,
    OtherUse,
    OtherMember,
    OtherCodel,
    OtherTask,
    Component,
    Service,
    RemoteService,
    Codel,
    ThisCodel,
    ThisState,
    Parameter,
    ThisParameter,
    MissingParameter,
    Port,
    ThisProperty,
    ThisLabel,
    Initializer,
    Requirement,
    ClockRate,
    Period,
    PeriodOfWaiting,
    NoPeriod,
    OldValue,
    Interrupting,
    /// The service that closes a cycle of services.
    InCircle(Name),
    WrittenBy(CodelName),
    SetBy(OwnerName),
    Yields {
        codel: Name,
        state: Name,
    },
    PauseToo(Name),
    /// Data that a codel waits for.
    WaitsFor(SmolStr),
    AlsoUses(SmolStr),
    Too(Name),
    PeriodOf(Name),
    /// The next codel of a chain.
    Then(Name),
    Load {
        task: Name,
        share: Share,
    },
    /// The kind of a name at the place.
    Is(Name),
    /// A possible meaning of a parameter.
    Meaning(&'static str),
    /// A codel that shares data.
    Sharing {
        codel: Name,
        owner: OwnerName,
    },
    Attribute(Name),
    /// The owning task or service, by its kind.
    Owner(&'static str),
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = match self {
            Role::First => "the first one",
            Role::FirstHere => "first here",
            Role::FirstGiven => "first given here",
            Role::FirstUsed => "first used here",
            Role::FirstDeclared => "first declared here",
            Role::Declared => "declared here",
            Role::NotDefined => "declared, but not defined, here",
            Role::Earlier => "the earlier declaration",
            Role::Declaration => "in the declaration",
            Role::Here => "here",
            Role::Used => "used here",
            Role::UsedToo => "and here",
            Role::Written => "written here",
            Role::InInterface => "in the interface",
            Role::Other => "the other one",
            Role::OtherUse => "the other use",
            Role::OtherMember => "the other member",
            Role::OtherCodel => "the other codel",
            Role::OtherTask => "the other task",
            Role::Component => "the component",
            Role::Service => "the service",
            Role::RemoteService => "the remote service",
            Role::Codel => "the codel",
            Role::ThisCodel => "this codel",
            Role::ThisState => "this state",
            Role::Parameter => "the parameter",
            Role::ThisParameter => "this parameter",
            Role::MissingParameter => "the missing parameter",
            Role::Port => "the port",
            Role::ThisProperty => "this property",
            Role::ThisLabel => "this label",
            Role::Initializer => "this initializer",
            Role::Requirement => "the requirement",
            Role::ClockRate => "the clock-rate",
            Role::Period => "the period",
            Role::PeriodOfWaiting => "period of the task that waits",
            Role::NoPeriod => "the task is declared here, without `period`",
            Role::OldValue => "the old value, from the ids",
            Role::Interrupting => "interrupted by this service",
            Role::Meaning(meaning) => meaning,
            Role::InCircle(text) => return write!(f, "`{text}` is part of the circle"),
            Role::WrittenBy(name) => return write!(f, "written by {name}"),
            Role::SetBy(owner_name) => return write!(f, "set by {owner_name}"),
            Role::Yields { codel, state } => {
                return write!(f, "`{codel}` yields `{state}` without pause");
            }
            Role::PauseToo(pause_too) => {
                return write!(f, "`pause::{pause_too}` waits for no tick either");
            }
            Role::WaitsFor(wait) => return write!(f, "waits for {wait}"),
            Role::AlsoUses(usage) => return write!(f, "also uses {usage}"),
            Role::Too(text) => return write!(f, "`{text}` too"),
            Role::PeriodOf(period) => return write!(f, "period of task `{period}`"),
            Role::Then(text) => return write!(f, "then `{text}`"),
            Role::Load { task, share } => return write!(f, "task `{task}` needs {share}"),
            Role::Sharing { codel, owner } => return write!(f, "codel `{codel}` of {owner}"),
            Role::Attribute(attribute) => return write!(f, "attribute `{attribute}`"),
            Role::Owner(owner) => return write!(f, "the {owner}"),
            Role::Is(text) => return write!(f, "this is `{text}`"),
        };
        f.write_str(words)
    }
}
