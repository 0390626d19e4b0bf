//! The files that a run writes while it goes on: a log, a trace, a recording.

use std::io::{self, Write};

use camino::Utf8Path;
use dotgen_recording::log::{self, Lines};
use dotgen_recording::trace::Trace;
use dotgen_timing::scn::names::Names;

use crate::failure;
use dotgen_platform::files::disk::AppendedFile;

/// All files that grow during a run.
pub(super) struct Files<'a> {
    /// The files with the executions of codels, if requested.
    pub(super) runs: Option<Recorder<'a>>,
    /// The recording, until the run begins.
    pub(super) recording: Option<AppendedFile>,
}

/// Reads lines of a log, and writes a log and a trace.
pub(super) struct Recorder<'a> {
    log: Option<AppendedFile>,
    trace: Option<(AppendedFile, Trace<'a>)>,
    lines: Lines,
}

/// Opens a file. The run goes on if a later write fails.
fn open(path: &Utf8Path) -> anyhow::Result<AppendedFile> {
    let told = path.to_owned();
    let tell = move |error: &io::Error| {
        failure(&anyhow::anyhow!(
            "cannot write `{told}`: {error}; the file ends here, the run goes on"
        ));
    };
    let opened = AppendedFile::create(path.as_std_path(), tell);
    opened.map_err(|error| anyhow::anyhow!("cannot write `{path}`: {error}"))
}

impl<'a> Files<'a> {
    /// Opens the requested files.
    ///
    /// # Errors
    /// A file cannot be opened or created.
    pub(super) fn open(
        log: Option<&Utf8Path>,
        trace: Option<&Utf8Path>,
        recording: Option<&Utf8Path>,
        names: &'a Names<'a>,
    ) -> anyhow::Result<Self> {
        let (log, trace) = (log.map(open).transpose()?, trace.map(open).transpose()?);
        let wanted = log.is_some() || trace.is_some();
        let runs = Recorder {
            log,
            trace: trace.map(|trace| (trace, Trace::new(Some(names)))),
            lines: Lines::default(),
        };
        Ok(Files { runs: wanted.then_some(runs), recording: recording.map(open).transpose()? })
    }
}

/// Marks the files that are complete. For the others, the reason was reported.
#[derive(Debug, Clone, Copy)]
pub(super) struct CompleteFiles {
    pub(super) log: bool,
    pub(super) trace: bool,
}

impl Recorder<'_> {
    /// Writes a line to the log only.
    pub(super) fn say(&mut self, text: &str) -> io::Result<()> {
        match &mut self.log {
            Some(log) => log.write_all(text.as_bytes()),
            None => Ok(()),
        }
    }

    /// Ends the files.
    pub(super) fn finish(mut self) -> io::Result<CompleteFiles> {
        self.say(&log::end())?;
        let mut whole =
            CompleteFiles { log: self.log.is_none_or(AppendedFile::finish), trace: true };
        if let Some((mut file, trace)) = self.trace {
            file.write_all(&trace.finish())?;
            whole.trace = file.finish();
        }
        Ok(whole)
    }
}

impl Write for Recorder<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(log) = &mut self.log {
            log.write_all(bytes)?;
        }
        if let Some((file, trace)) = &mut self.trace {
            self.lines.feed(bytes, |_, line| trace.line(line, true));
            file.write_all(&trace.packets())?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The recorder and the subscribers of a run, if there are any.
pub(super) struct Runs<'r, 'a> {
    pub(super) recorder: Option<&'r mut Recorder<'a>>,
    pub(super) followers: Option<Box<dyn Write>>,
}

impl Write for Runs<'_, '_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(followers) = &mut self.followers {
            followers.write_all(bytes)?;
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.write_all(bytes)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
