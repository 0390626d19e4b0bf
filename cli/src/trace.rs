//! `--trace FILE` of `dotgen verify` and `dotgen run`: a run for the trace viewer.

use std::collections::HashMap;
use std::io::Write;

use anyhow::Context;
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::FileContent;
use dotgen_timing::report::{Event, TimeUnit};
use dotgen_timing::verify::Options;

use dotgen_lsp_server::protocol::convert::{Encoding, Lines, uri};
use dotgen_lsp_server::protocol::types::Location;
use dotgen_platform::files::disk::Stream;
use dotgen_platform::files::vfs;
use dotgen_views::verification::trace::{Trace, TraceInput, of_run};
use dotgen_views::verification::{Problem, blocking, runs::Ending};

/// A finished run, as it was reported.
pub(super) struct RecordedRun<'r> {
    /// The title of the trace.
    pub(super) title: String,
    /// The unit of the times of events.
    pub(super) unit: TimeUnit,
    pub(super) events: &'r [Event],
    /// The end of the run.
    pub(super) ending: Ending<'r>,
    /// The event from which the run repeats itself.
    pub(super) cycle: Option<usize>,
    /// Notes about the run.
    pub(super) notes: Vec<String>,
}

/// Writes a run to a file, complete or not at all. Returns the number of steps.
///
/// # Errors
/// The file cannot be written.
pub(super) fn write(
    path: &Utf8Path,
    recorded: RecordedRun,
    problem: &Problem,
    options: &Options,
) -> anyhow::Result<usize> {
    let mut trace = of_run(&TraceInput {
        title: recorded.title,
        unit: recorded.unit,
        events: recorded.events,
        end: None,
        ending: recorded.ending,
        cycle: recorded.cycle,
        blocking: &blocking::table(problem, options),
    });
    trace.notes.extend(recorded.notes);
    let mut texts: HashMap<Utf8PathBuf, Option<Lines>> = HashMap::new();
    let trace: Trace<Option<Location>> = trace.placed(|(spec, src)| {
        let place = problem.place(spec, src);
        Ok::<_, anyhow::Error>(place.and_then(|(path, range)| {
            let lines = texts.entry(path.clone()).or_insert_with(|| lines(&path));
            Some(Location { uri: uri::from_path(&path)?, range: lines.as_ref()?.range(&range) })
        }))
    })?;
    let wrong = || format!("cannot write `{path}`");
    let mut out = Stream::create(path.as_std_path()).with_context(wrong)?;
    serde_json::to_writer(&mut out, &trace).with_context(wrong)?;
    out.write_all(b"\n").with_context(wrong)?;
    out.finish().with_context(wrong)?;
    Ok(trace.steps.len())
}

fn lines(path: &Utf8Path) -> Option<Lines> {
    match vfs::read(path) {
        FileContent::Text(text) | FileContent::NotUtf8(text) => {
            Some(Lines::new(text.into(), Encoding::Utf16))
        }
        _ => None,
    }
}
