//! Where the runs of codels of a run go: a log, a trace, who follows the run.

use std::io::{self, Write};

use anyhow::Context;
use camino::Utf8Path;
use dotgen_recording::log::Lines;
use dotgen_recording::trace::Trace;
use dotgen_timing::scn::names::Names;

use crate::files::disk::Stream;

/// Lines of a log come in, files come out when the run is over.
pub(super) struct Recorder<'a> {
    log: Option<(&'a Utf8Path, Stream)>,
    trace: Option<(&'a Utf8Path, Stream, Trace)>,
    lines: Lines,
}

impl<'a> Recorder<'a> {
    /// For the files that are wanted; `None` if there are none.
    pub(super) fn new(
        log: Option<&'a Utf8Path>,
        trace: Option<&'a Utf8Path>,
    ) -> anyhow::Result<Option<Self>> {
        let create = |path: &'a Utf8Path| {
            let stream = Stream::create(path.as_std_path());
            let stream = stream.with_context(|| format!("cannot write `{path}`"))?;
            anyhow::Ok((path, stream))
        };
        if log.is_none() && trace.is_none() {
            return Ok(None);
        }
        let trace = trace.map(create).transpose()?;
        Ok(Some(Recorder {
            log: log.map(create).transpose()?,
            trace: trace.map(|(path, stream)| (path, stream, Trace::default())),
            lines: Lines::default(),
        }))
    }

    /// Writes a line that only the log has.
    pub(super) fn say(&mut self, text: &str) -> io::Result<()> {
        match &mut self.log {
            Some((_, stream)) => stream.write_all(text.as_bytes()),
            None => Ok(()),
        }
    }

    /// Gives the files their names.
    pub(super) fn finish(self, names: &Names<'_>) -> anyhow::Result<()> {
        if let Some((path, stream)) = self.log {
            stream
                .finish()
                .with_context(|| format!("cannot write `{path}`"))?;
        }
        if let Some((path, mut stream, trace)) = self.trace {
            let write = || -> io::Result<()> {
                stream.write_all(&trace.finish(Some(names)))?;
                stream.finish()
            };
            write().with_context(|| format!("cannot write `{path}`"))?;
        }
        Ok(())
    }
}

impl Write for Recorder<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some((path, stream)) = &mut self.log {
            let named =
                |it: io::Error| io::Error::new(it.kind(), format!("cannot write `{path}`: {it}"));
            stream.write_all(bytes).map_err(named)?;
        }
        if let Some((_, _, trace)) = &mut self.trace {
            self.lines.feed(bytes, |_, line| trace.line(line, true));
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.log {
            Some((_, stream)) => stream.flush(),
            None => Ok(()),
        }
    }
}

/// A recorder, if there is one, and who follows the run, if somebody may.
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
        self.recorder.as_mut().map_or(Ok(()), |it| it.flush())
    }
}
