//! What goes on for ever in a run, so that a time has no bound.

use dotgen_analysis::phrase::Phrase;
use dotgen_analysis::source_map::Locations as _;
use dotgen_timing::report::{Endless, EndlessKind, LoopExit, StretchKind};
use dotgen_timing::system::{CodelName, ThreadName};
use serde::Serialize;

use super::Problem;
use super::blocking::{Row, function};

/// What goes on for ever.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct EndlessCause {
    #[serde(rename = "task", skip_serializing_if = "Option::is_none")]
    pub(crate) thread: Option<ThreadName>,
    #[serde(flatten)]
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "for-ever", rename_all = "kebab-case")]
enum Kind {
    /// The codels are executed in turn.
    Loop {
        codels: Vec<CodelName>,
        /// Their functions.
        #[serde(skip)]
        functions: Vec<String>,
        /// The yields that would leave the loop.
        exits: Vec<Exit>,
    },
    /// A codel waits for its locks.
    Locks { codel: CodelName },
    /// A codel or a job waits for a core.
    Core,
    /// A task has no further job.
    NoJob,
    /// No client requests the service.
    NoRequest { service: String },
    /// A client does not go on.
    Client,
}

/// A yield that leaves a loop.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Exit {
    codel: CodelName,
    #[serde(skip)]
    function: String,
    /// As the specification writes it.
    yields: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<At>,
}

/// The place of a codel in a specification.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct At {
    file: String,
    /// Line, counted from 1.
    line: u32,
}

impl EndlessCause {
    /// Returns the cause; `None` if the run names none.
    pub(super) fn new(endless: &Endless, problem: &Problem, table: &[Row]) -> Option<EndlessCause> {
        let exit = |exit: &LoopExit| Exit {
            codel: exit.codel.clone(),
            function: function(table, &exit.codel),
            yields: exit.yields.clone(),
            at: exit.src.and_then(|(spec, src)| {
                let place = problem.units.get(spec)?.locations.locate(src)?;
                let file = place.path.file_name().unwrap_or_default().to_owned();
                Some(At { file, line: place.start.line + 1 })
            }),
        };
        let kind = match &endless.kind {
            EndlessKind::Loop { codels, exits } => Kind::Loop {
                codels: codels.clone(),
                functions: codels.iter().map(|codel| function(table, codel)).collect(),
                exits: exits.iter().map(exit).collect(),
            },
            EndlessKind::Waits(waits) => match waits {
                StretchKind::Locks { codel, .. } => Kind::Locks { codel: codel.clone() },
                StretchKind::Core | StretchKind::Preempted(_) => Kind::Core,
                StretchKind::Between => Kind::NoJob,
                StretchKind::Unrequested(service) => Kind::NoRequest { service: service.clone() },
                StretchKind::Client => Kind::Client,
                StretchKind::Executes(_) | StretchKind::Nothing => return None,
            },
        };
        Some(EndlessCause { thread: endless.thread.clone(), kind })
    }

    /// `` `exec` can execute `arm_main` for ever: `arm_main` need never yield `stop` (arm.gen:12) ``
    pub(crate) fn in_words(&self) -> Phrase {
        let thread = self.thread.as_ref().map_or("", |thread| thread.own());
        let of_thread = Phrase::name(thread);
        let (functions, exits) = match &self.kind {
            Kind::Loop { functions, exits, .. } => (functions, exits),
            Kind::Locks { codel } => {
                return of_thread
                    .and(" can wait for the locks of ")
                    .and_name(&**codel)
                    .and(" for ever");
            }
            Kind::Core => return of_thread.and(" can wait for a core for ever"),
            Kind::NoJob => return of_thread.and(" can go on for ever without it"),
            Kind::NoRequest { service } => {
                return Phrase::words("from then on no client need request ")
                    .and_name(service.as_str());
            }
            Kind::Client => return of_thread.and(" need not go on"),
        };
        let names: Vec<Phrase> = functions.iter().map(|name| Phrase::name(name.as_str())).collect();
        let said = of_thread.and(" can execute ").and_phrase(&Phrase::joined(&names, ", "));
        let said = said.and(" for ever: ");
        if exits.is_empty() {
            return said.and("no yield leaves this loop");
        }
        let exits = exits.iter().map(|exit| {
            let words = Phrase::name(exit.function.as_str()).and(" need never yield ");
            let words = words.and_name(exit.yields.as_str());
            match &exit.at {
                Some(At { file, line }) => words.and(format!(" ({file}:{line})")),
                None => words,
            }
        });
        said.and_phrase(&Phrase::joined(&exits.collect::<Vec<_>>(), ", and "))
    }
}
