//! Findings about codels: their parameters, states and concurrency.

use dotgen_syntax::findings;

use crate::{
    fixes::{FixSite, TextFix},
    model::{Name, OwnerName},
};

findings! {
    /// A codel that does not fit its component.
    pub enum CodelProblem {
        "prop-duplicate" CodelTwice { name: Name }
            => "codel `{name}` is already used here",
               "within one task or service a codel can be used once";
        "codel-param-source" NoAccess { codel: Name, what: &'static str, name: Name }
            => "codel `{codel}` cannot use {what} `{name}`: codels without states have access to the \
                ids and to the parameters of their service only";
        "codel-conflict" OtherSignature { name: Name, there: Name, here: Name }
            => "codel `{name}` is used elsewhere as ({there}), here as ({here})",
               "it is one function, so all uses need the same directions and types in the same order";

        "param-unnamed" WholeIds { name: Name, what: &'static str }
            => "`::{name}` alone stands for the whole ids",
               "to use {what}, write its name without `::`";
        "param-member" UnknownMember { name: Name }
            => "there is no member of the ids called `{name}`";
        "param-unknown-local" UnknownLocal { name: Name }
            => "there is no parameter or local variable declared before in this service called `{name}`";
        "param-unknown-port" UnknownPort { name: Name }
            => "there is no port of this component called `{name}`";
        "param-unknown-remote" UnknownRemote { name: Name }
            => "there is no remote service of this component called `{name}`";
        "param-unknown" Unknown { name: Name, places: &'static str }
            => "`{name}` is {places} of this component";
        "param-ambiguous" Ambiguous {
            name: Name, one: &'static str, other: &'static str, source: &'static str, dir: &'static str,
        }
            => "`{name}` is {one} and {other}",
               "say which one you mean, for instance `{source} {dir} {name}`";
        "param-no-ids" NoIds { component: Name }
            => "`{component}` has no ids so far", "declare them before, in `ids {{ … }};`";
        "param-duplicate" ParamTwice { name: Name }
            => "two parameters of this codel are called `{name}`", "rename one of them with `::`";
        "param-member" NoMember { ty: Name, name: Name } => "`{ty}` has no member `{name}`";
        "param-member" NoMembers { ty: Name, name: Name }
            => "`{ty}` has no members, so `.{name}` selects nothing";
        "param-scalar" NoElements { ty: Name, number: u64 }
            => "`{ty}` is neither an array nor a sequence, so it has no element {number}";
        "param-bounds" Beyond { number: u64, length: u64, ty: Name, last: u64 }
            => "index {number} is beyond the {length} elements of `{ty}`", "the last one is {last}";
        "param-bounds" BeyondEmpty { number: u64, ty: Name }
            => "index {number} is beyond the 0 elements of `{ty}`";
        "writes-input" WritesInput { name: Name }
            => "this codel writes `{name}`, an `in` parameter of the service: the client does not get the value";
        "param-port-member" PortMember { name: Name }
            => "port `{name}` is used as a whole", "a codel selects what it needs from it itself";
        "param-read-only-port" WritesInputPort { name: Name }
            => "`{name}` is an input port, it cannot be written", "use `in`";
        "inout-input-port" InoutInputPort { name: Name }
            => "`{name}` is an input port", "`in` says so";
        "param-remote-member" RemoteMember { name: Name }
            => "remote service `{name}` has no members to select";
        "param-remote-direction" RemoteDirection { name: Name }
            => "remote service `{name}` can only be called", "use `in`";

        "fsm/paused-trigger" PausedTrigger { state: Name }
            => "a codel cannot implement the paused state `pause::{state}`", "write `<{state}>`";
        "fsm/paused-ether" PausedEther
            => "`ether` ends the state machine, so it cannot be paused", "write `ether`";
        "fsm/duplicate-yield" StateTwice { state: Name }
            => "`{state}` is already in this list", "remove it";
        "fsm/duplicate-state" StateTaken { state: Name, codel: Name }
            => "state `{state}` is already implemented by codel `{codel}`", "a state has one codel";
        "fsm/stop-without-ether" StopWithoutEther { owner: OwnerName }
            => "in {owner}, no path leads from `stop` to `ether`, so it could never be interrupted",
               "let a codel reached from `stop` yield `ether`";
        "fsm/unreachable-state" Unreachable { state: Name, owner: OwnerName, in_cycle: bool }
            => "state `{state}` of {owner} can be reached neither from `start` nor from `stop`";
        "ether-codel" EtherCodel
            => "`ether` is the end of the state machine",
               "a codel for it keeps the machine from ending there";
        "throw/undeclared-use" UndeclaredThrow {
            codel: Name, state: Name, owner: OwnerName, exception: Name,
        }
            => "codel `{codel}` yields `{state}`, which is an exception that {owner} does not throw",
               "declare `throw {exception}` and leave it out of the states: a codel leaves with an \
                exception from wherever it is";
        "fsm/undefined-state" Undefined { codel: Name, state: Name, owner: OwnerName }
            => "codel `{codel}` leads to state `{state}`, which no codel of {owner} implements";
        "fsm/undefined-state" PauseAlone
            => "`pause` alone is not a state", "name the state that follows the pause";
        "fsm/undefined-state" Misnamed { state: Name, owner: OwnerName }
            => "no codel of {owner} leads to state `{state}`";
        "unused-task" IdleTask { task: Name }
            => "task `{task}` runs nothing: it has no codels, and no activity has `task {task};`";

        "async/shared-resource" SharedWithCodel { codel: Name, shared: Name, with: Name, owner: OwnerName }
            => "async codel `{codel}` shares {shared} with codel `{with}` of {owner}, which may run at \
                the same time",
               "leave out `async`, or let them use different data";
        "async/shared-attribute" SharedWithAttribute { codel: Name, shared: Name, with: Name }
            => "async codel `{codel}` shares {shared} with attribute `{with}`, which may run at the same \
                time",
               "leave out `async`, or let them use different data";
    }
}

impl CodelProblem {
    /// The fixes, the best first, made from the text around.
    pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
        match self {
            CodelProblem::PausedEther => vec![here.replace("ether").plain()],
            CodelProblem::StateTwice { .. } => {
                here.remove_part().map(TextFix::plain).into_iter().collect()
            }
            CodelProblem::UnknownMember { name } => {
                here.declare_ids_member(name).into_iter().collect()
            }
            CodelProblem::UnknownPort { name } => here.declare_port(name).into_iter().collect(),
            CodelProblem::Unknown { name, .. } => {
                let ways = [here.declare_ids_member(name), here.declare_port(name)];
                ways.into_iter().flatten().collect()
            }
            CodelProblem::Undefined { state, .. } => {
                here.declare_state(state).into_iter().collect()
            }
            CodelProblem::UndeclaredThrow { exception, .. } => {
                here.declare_throw(exception).into_iter().collect()
            }
            CodelProblem::Unreachable { in_cycle, .. } => here.connect_or_remove_codel(*in_cycle),
            _ => Vec::new(),
        }
    }
}
