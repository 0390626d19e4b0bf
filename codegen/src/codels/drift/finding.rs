//! The details of each difference, and its message.

use std::fmt;

use dotgen_analysis::model::Name;
use dotgen_syntax::findings;

/// Names of states, each in back quotes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct States(pub Vec<String>);

impl fmt::Display for States {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, state) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}`{state}`")?;
        }
        Ok(())
    }
}

/// Several errors, each a clause.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Clauses(pub Vec<String>);

impl fmt::Display for Clauses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("; "))
    }
}

findings! {
    /// A difference between a specification and its sources.
    pub enum Difference {
        "codel/missing-definition" Missing { folder: Name, codel: Name }
            => "no source in `{folder}/` defines the function of codel `{codel}`";
        "codel/missing-definition" Unwritten { component: Name, count: u64 }
            => "{count} codels of `{component}` have no function yet", "run `dotgen codels stub`";
        "codel/signature-mismatch" Signature { function: Name, differences: Clauses }
            => "`{function}` does not have the prototype of its codel: {differences}";
        "codel/undeclared-yield" ReturnsOk { function: Name, event: Name, yields: States }
            => "`{function}` returns `{event}`, but its codel has states and yields {yields}";
        "codel/undeclared-yield" HasNoStates { function: Name, event: Name, ok: Name }
            => "`{function}` returns `{event}`, but its codel has no states: it may return `{ok}` or an \
                exception";
        "codel/undeclared-yield" NotYielded { function: Name, event: Name, yields: States }
            => "`{function}` returns `{event}`, which its codel does not yield (it yields {yields})";
        "codel/never-yielded" NeverReturned { codel: Name, state: Name, event: Name }
            => "codel `{codel}` may yield `{state}`, but its function never returns `{event}`";
        "codel/undeclared-throw" NotThrown { function: Name, exception: Name, owners: Name }
            => "`{function}` raises `{exception}`, which neither its {owners} nor the component throws";
        "codel/undeclared-throw" NoException { function: Name, exception: Name }
            => "`{function}` raises `{exception}`, and the specification has no exception of that name";
        "codel/orphan" Orphan { function: Name }
            => "function `{function}` looks like a codel and no specification names it: declare it as a \
                codel, make it `static`, or remove it";
        "codel/orphan" Renamed { function: Name, codel: Name }
            => "function `{function}` looks like a codel and no specification names it, while codel \
                `{codel}` has no function: was one of them renamed?";
        "codel/undeclared-name" NoName { function: Name, name: Name }
            => "`{function}` uses `{name}`, which is no parameter of it", "add it to the codel, or declare it";
        "codel/constant-write" ConstantWrite { function: Name, parameter: Name }
            => "`{function}` writes to `{parameter}`, which is read only", "make it `out` or `inout` in the codel, \
                or write to a copy";
        "codel/unwritten-port" UnwrittenPort { function: Name, port: Name, component: Name }
            => "`{function}` never writes the output port `{port}`, and no other codel of `{component}` does: \
                readers get no data",
               "call `write` on the port, or remove the parameter";
        "codel/stale-comment" StaleComment { codel: Name, wrong: Clauses }
            => "comment of codel `{codel}`: {wrong}";
    }
}
