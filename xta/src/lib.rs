//! Networks of timed automata in UPPAAL's textual format (`.xta`), and queries about them (`.q`).
//!
//! [`read`] parses and instantiates a model, [`queries`] parses queries, and [`Network::answer`] answers one
//! by symbolic reachability with zones. Times are in the unit of the model's clocks.
//!
//! Supported: bounded integers, booleans, arrays, records, functions, clocks and arrays of clocks, channels
//! (urgent, broadcast, in arrays), `select`, committed and urgent locations, priorities of channels and
//! processes; `A[]`, `E<>`, `sup`, `inf` and `deadlock`.
//!
//! Not supported, and refused by name: differences of clocks, rates, probabilities and branch points, guards
//! with clocks on urgent channels, lower bounds in invariants, `meta`, `scalar`, partial instantiation,
//! liveness (`A<>`, `E[]`, `-->`) and statistical queries.

mod ast;
mod code;
mod error;
mod eval;
mod explore;
mod lexer;
mod network;
mod parse;
mod query;
mod types;
mod zone;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use error::Error;

/// A model that is ready for queries.
#[derive(Debug, Clone)]
pub struct Network {
    program: network::scope::Program,
    processes: Vec<network::edges::Process>,
}

/// A query of a text of queries.
#[derive(Debug, Clone)]
pub struct Query {
    form: ast::Form,
    /// The query as it is written.
    pub text: String,
    /// The text up to the end of the query, for places of errors.
    source: String,
}

/// Bounds of a search.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Number of symbolic states.
    pub states: usize,
    /// The search gives up soon after the flag is set.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl Default for Limits {
    /// A million states.
    fn default() -> Limits {
        Limits { states: 1_000_000, cancel: None }
    }
}

/// Answer to a query. `states` counts symbolic states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The query is true. `E<>` has a trace.
    Holds { trace: Option<Trace>, states: usize },
    /// The query is false. `A[]` has a trace.
    Fails { trace: Option<Trace>, states: usize },
    /// Values of `sup` or `inf`, in the order of the query.
    Values { values: Vec<Extreme>, states: usize },
    /// The search ended before an answer.
    GaveUp { reason: Reason, states: usize },
    /// The form of the query is not supported, with the reason.
    Refused(String),
    /// The model has an error, such as a value out of range, after the trace.
    Invalid { message: String, trace: Option<Trace> },
}

/// Cause of a search without an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// The limit of [`Limits::states`].
    States(usize),
    /// The flag of [`Limits::cancel`] was set.
    Cancelled,
    /// A clock may be larger than this value, up to which values are searched for.
    Clock(i32),
}

/// A value of `sup` or `inf`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extreme {
    /// `None` if no state has the predicate of the query.
    pub value: Option<Value>,
}

/// The supremum or the infimum of a clock or an integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// The value, and whether a state has the value itself.
    Finite { value: i64, attained: bool },
    /// The clock grows without bound.
    Infinite,
}

/// A run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trace {
    /// Transitions from the initial state.
    pub steps: Vec<Step>,
    /// `Process.location` of each process at the end.
    pub locations: Vec<String>,
    /// Earliest time of the end.
    pub time: i64,
}

/// A transition of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Earliest time since the start, such that the rest of the run is still possible. If a bound is strict,
    /// the step is only possible after this time.
    pub time: i64,
    /// `Process.source -> target` of each edge. The sender is first.
    pub transition: String,
    /// Channel of the synchronisation.
    pub channel: Option<String>,
    /// Variables that changed.
    pub changes: Vec<Change>,
}

/// A change of an integer or boolean.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// Name with indices and fields, as in `P.list[2].state`.
    pub variable: String,
    pub before: i32,
    pub after: i32,
}

/// Reads a model.
///
/// # Errors
///
/// The first error of the text, or the first construct that is not supported.
pub fn read(text: &str) -> Result<Network, Error> {
    let model = parse::model(text).map_err(|fault| fault.locate(text))?;
    let (program, processes) = network::system(&model).map_err(|fault| fault.locate(text))?;
    Ok(Network { program, processes })
}

/// Reads queries, each of which starts on a line of its own. Names are resolved by [`Network::check`].
///
/// # Errors
///
/// The first error of the text.
pub fn queries(text: &str) -> Result<Vec<Query>, Error> {
    let parsed = parse::queries(text).map_err(|fault| fault.locate(text))?;
    let query = |(start, end, form): (u32, u32, ast::Form)| {
        let part = |range: std::ops::Range<usize>| text.get(range).unwrap_or_default().to_owned();
        let (start, end) = (start as usize, end as usize);
        Query { form, text: part(start..end), source: part(0..end) }
    };
    Ok(parsed.into_iter().map(query).collect())
}

impl Network {
    /// Reports an unknown name or a wrong type in a query, with its place in the text of the queries.
    pub fn check(&self, query: &Query) -> Result<(), Error> {
        let resolved = query::resolve(&self.program, &query.form);
        resolved.map(|_| ()).map_err(|fault| fault.locate(&query.source))
    }

    /// Answers a query. A query that [`Network::check`] rejects is refused.
    pub fn answer(&self, query: &Query, limits: &Limits) -> Answer {
        match query::resolve(&self.program, &query.form) {
            Ok(resolved) => {
                let (program, processes) = (&self.program, self.processes.as_slice());
                query::Question { program, processes, limits }.answer(&resolved)
            }
            Err(fault) => Answer::Refused(fault.locate(&query.source).to_string()),
        }
    }

    /// Number of processes.
    pub fn processes(&self) -> usize {
        self.processes.len()
    }

    /// Greatest size of a symbolic state in memory, in bytes: a bound of each pair of clocks, and the
    /// integers.
    pub fn state_bytes(&self) -> usize {
        const OVERHEAD: usize = 128;
        let rows = self.program.clocks.len() + 1;
        let numbers = rows * rows + self.program.initial.len();
        numbers * size_of::<i32>() + OVERHEAD
    }

    /// Number of clocks.
    pub fn clocks(&self) -> usize {
        self.program.clocks.len()
    }
}
