//! Traces of other tools over exported models, as runs of the verified system.
//!
//! Data flows in four steps. A reader makes a [`Written`] trace of the text ([`uppaal`], [`dot`]). [`follow`]
//! takes the edges of the trace in the network of [`translate()`], and collects their actions and conditions
//! on times. [`times`] solves these conditions in whole base units. [`replay`] performs the actions with the
//! rules of the verifier. A trace that does not fit is an error with its line; nothing is guessed.

mod dot;
mod follow;
mod replay;
mod times;
mod uppaal;

use dotgen_timing::explore::Run;
use dotgen_timing::verify::Prepared;

use crate::translate::{Refusal, translate};

/// Greatest size of a trace, in bytes.
pub const MAX_BYTES: u64 = 64 << 20;

/// Greatest number of transitions of a trace.
const MAX_STEPS: usize = 20_000;

/// A trace as a run of the verified system.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The form of the trace, as `UPPAAL`.
    pub form: &'static str,
    /// Number of transitions of the trace.
    pub transitions: usize,
    pub run: Run,
    /// Times are those of the trace. Otherwise they are the earliest ones of its transitions.
    pub has_times: bool,
    pub end: Option<Goal>,
    /// Sentences about the trace.
    pub notes: Vec<String>,
}

/// The place in which a trace ends, if it answers a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Goal {
    /// Number of the check among those of the system, from 0.
    pub check: usize,
    /// Kind and subject of the check, after its name if it has one.
    pub name: String,
    /// The check holds in this place: it is a witness. Otherwise it fails.
    pub holds: bool,
}

/// A trace that cannot be imported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// Line of the trace, from 1; `None` if the error is about all of it.
    pub line: Option<usize>,
    pub message: String,
}

impl Error {
    fn new(message: impl Into<String>) -> Error {
        Error { line: None, message: message.into() }
    }

    fn at(line: usize, message: impl Into<String>) -> Error {
        Error { line: Some(line), message: message.into() }
    }
}

impl From<Vec<Refusal>> for Error {
    fn from(refusals: Vec<Refusal>) -> Error {
        let list: Vec<String> = refusals.iter().map(ToString::to_string).collect();
        Error::new(format!("the system has no exported model: {}", list.join("; ")))
    }
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for Error {}

/// A trace as a tool has written it: one state more than transitions.
#[derive(Debug, Default)]
struct Written<'t> {
    states: Vec<State<'t>>,
    transitions: Vec<Transition<'t>>,
    /// The tool gives a time to each transition.
    has_times: bool,
}

/// A state. Its zone is not kept.
#[derive(Debug, Default)]
struct State<'t> {
    line: usize,
    /// `LOCATION` or `PROCESS.LOCATION` of each process, in order of the model.
    locations: Vec<&'t str>,
    /// Names and values of integers and clocks.
    values: Vec<(&'t str, &'t str)>,
}

/// A transition: the edges of one or two processes, or the passage of time without edges.
#[derive(Debug, Default)]
struct Transition<'t> {
    line: usize,
    /// Time since the transition before.
    delay: Time,
    edges: Vec<Moved<'t>>,
}

/// An edge, by what the tool says about it.
#[derive(Debug)]
struct Moved<'t> {
    process: &'t str,
    /// Source and target.
    between: Option<(&'t str, &'t str)>,
    /// Event of TChecker.
    event: Option<&'t str>,
}

/// Time in base units; `None` if it is not a whole number of them.
type Time = Option<i64>;

/// Reads a time: `5`, `5.5` or `11/2` base units.
fn time(text: &str, line: usize) -> Result<Time, Error> {
    let (whole, part) = text.split_once(['.', '/']).unwrap_or((text, ""));
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let number = whole.parse().ok().filter(|_| is_number(whole) && is_number(part));
    let number: i64 = number.ok_or_else(|| Error::at(line, format!("`{text}` is not a time")))?;
    let is_whole = part.is_empty() || (text.contains('.') && part.bytes().all(|byte| byte == b'0'));
    Ok(is_whole.then_some(number))
}

/// Returns a trace of another tool over the exported model of a system as a run of the system. The tool is
/// recognised by the text.
///
/// # Errors
///
/// A text that is not a trace, or a trace of another model, at the first line that does not fit.
pub fn import(prepared: &Prepared, text: &str) -> Result<Imported, Error> {
    if text.len() as u64 > MAX_BYTES {
        return Err(Error::new(format!("the trace is larger than {} MB", MAX_BYTES >> 20)));
    }
    let starts = |word: &str| text.lines().any(|line| line.trim_start().starts_with(word));
    let (form, written) = if starts("digraph") {
        ("TChecker", dot::read(text)?)
    } else if starts("State") {
        ("UPPAAL", uppaal::read(text)?)
    } else {
        return Err(uppaal::not_a_trace(text));
    };
    if written.transitions.len() > MAX_STEPS {
        return Err(Error::new(format!("the trace has more than {MAX_STEPS} transitions")));
    }
    let network = translate(prepared, &|_, _| None)?;
    let followed = follow::follow(&network, &written)?;
    let (times, has_times) = times::of(&followed, &written)?;
    let run = replay::run(prepared, &followed.actions, &times)?;
    let mut notes = Vec::new();
    if written.has_times && !has_times {
        notes.push(
            "some times of the trace are not whole: the run has the earliest whole times"
                .to_owned(),
        );
    }
    let moves = written.transitions.iter().filter(|transition| !transition.edges.is_empty());
    let transitions = moves.count();
    Ok(Imported { form, transitions, run, has_times, end: followed.end, notes })
}
