//! The log of GenoM3's profiler, line by line.
//!
//! A line has nine columns: the times at which a codel asked for its locks, got them and released them (in
//! seconds, with nine digits after the point), instance, task, service, function, and the events before and
//! after the run. The facts are from the recorder (`templates/common/prof.c`) and from `profundis`, which
//! reads its logs (both of GenoM3 2.99.39). The recorder writes lines about itself: those of the instance
//! `genom`, and those of the function `genom_prof_record`, when a thread had to wait for the recorder.

use memchr::memchr;
use rustc_hash::FxHashMap;

/// Nanoseconds per second.
const NANOS: i64 = 1_000_000_000;

/// Number of names after the three times.
const NAMES: usize = 6;

/// Instance of the lines of the recorder about itself.
const RECORDER: &[u8] = b"genom";

/// Function of the lines about threads that had to wait for the recorder.
const OVERLOAD: &[u8] = b"genom_prof_record";

/// Upper limit on the bytes of a line. A longer line is skipped, so that it takes no memory.
const MAX_LINE_BYTES: usize = 1 << 16;

/// The beginning of a line in which `dotgen run` names the source of the times of a log. Other readers skip
/// such lines, because they do not begin with a time.
const TIME_SOURCE_PREFIX: &[u8] = b"# dotgen: ";

/// The source of the times of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin<'l> {
    /// The real clock: from this line on, times are measured, except those of codels that are named.
    Measured,
    /// The virtual clock: from this line on, no time is measured.
    Simulated,
    /// A simulated codel in a run on the real clock, by its path.
    Codel(&'l str),
    /// The run begins to end: its components are shut down.
    Ending,
    /// The end of the run: the log is whole.
    End,
}

/// Returns the lines of a log that name the source of its times.
pub fn origins<'c>(measured: bool, simulated: impl Iterator<Item = &'c str>) -> String {
    let says = String::from_utf8_lossy(TIME_SOURCE_PREFIX);
    if !measured {
        return format!("{says}times are simulated\n");
    }
    let mut out = format!("{says}times are measured\n");
    for path in simulated {
        out.push_str(&format!("{says}simulated {path}\n"));
    }
    out
}

/// Returns the line after which the components of a run are shut down.
pub fn ending() -> String {
    format!("{}the run begins to end\n", String::from_utf8_lossy(TIME_SOURCE_PREFIX))
}

/// Returns the last line of a log.
pub fn end() -> String {
    format!("{}end of the run\n", String::from_utf8_lossy(TIME_SOURCE_PREFIX))
}

/// Reads a line that names the source of times; returns `None` for other lines.
pub fn origin(text: &[u8]) -> Option<Origin<'_>> {
    match std::str::from_utf8(text.strip_prefix(TIME_SOURCE_PREFIX)?).ok()?.trim() {
        "times are measured" => Some(Origin::Measured),
        "times are simulated" => Some(Origin::Simulated),
        "the run begins to end" => Some(Origin::Ending),
        "end of the run" => Some(Origin::End),
        other => other.strip_prefix("simulated ").map(Origin::Codel),
    }
}

/// A line, with the names unparsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'l> {
    /// Time of the request for locks, in nanoseconds.
    pub asked: i64,
    /// Time when all locks were held, in nanoseconds.
    pub began: i64,
    /// Time of their release, in nanoseconds.
    pub ended: i64,
    /// The times have nine digits after the point, as the recorder writes them.
    pub exact: bool,
    /// Names after the times.
    pub tail: &'l [u8],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineSubject {
    /// A run of a codel.
    Codel,
    /// The recorder itself.
    Recorder,
    /// A thread that waited for the recorder: its next time is measured too late.
    Overload,
    /// A line with missing names.
    Cut,
    /// A line with too many names.
    Garbage,
}

/// Reads a line like `profundis`: the first three words are times. Returns `None` if they are not.
pub fn line(text: &[u8]) -> Option<Line<'_>> {
    if let Some(([asked, began, ended], rest)) = recorded(text) {
        return Some(Line { asked, began, ended, exact: true, tail: rest.trim_ascii() });
    }
    let mut rest = text;
    let mut exact = true;
    let mut times = [0; 3];
    for time in &mut times {
        let (word, after) = word(rest)?;
        let (value, digits) = stamp(word)?;
        exact &= digits == 9;
        *time = value;
        rest = after;
    }
    let [asked, began, ended] = times;
    Some(Line { asked, began, ended, exact, tail: rest.trim_ascii() })
}

impl<'l> Line<'l> {
    /// Returns instance, task, service, function, and the events before and after the run. Missing names are
    /// empty. Returns `None` if there are too many.
    pub fn names(&self) -> Option<[&'l [u8]; NAMES]> {
        let mut names: [&[u8]; NAMES] = [b""; NAMES];
        let mut rest = self.tail;
        let mut count = 0;
        while let Some((name, after)) = word(rest) {
            *names.get_mut(count)? = name;
            count += 1;
            rest = after;
        }
        Some(names)
    }

    /// Returns true if the times go backwards, because the clock was set.
    pub fn is_step(&self) -> bool {
        self.began < self.asked || self.ended < self.began
    }
}

/// Reads times in the form that the recorder writes: seconds, a point, nine digits and a blank. This fast
/// path covers most lines. `None` does not mean that the line is invalid.
fn recorded(text: &[u8]) -> Option<([i64; 3], &[u8])> {
    let mut rest = text;
    let mut times = [0; 3];
    for time in &mut times {
        let mut seconds: i64 = 0;
        let mut length = 0;
        while let Some(digit) = rest.get(length).map(|byte| byte.wrapping_sub(b'0'))
            && digit <= 9
        {
            seconds = seconds * 10 + i64::from(digit);
            length += 1;
            if length > SECONDS {
                return None;
            }
        }
        let (eight, after) = rest.get(length..)?.strip_prefix(b".")?.split_first_chunk()?;
        let ([last, b' '], after) = after.split_first_chunk()? else {
            return None;
        };
        let last = last.wrapping_sub(b'0');
        if length == 0 || last > 9 {
            return None;
        }
        let nanos = i64::from(eight_digits(*eight)?) * 10 + i64::from(last);
        *time = seconds.checked_mul(NANOS)?.checked_add(nanos)?;
        rest = after;
    }
    Some((times, rest))
}

/// Number of digits of the seconds since 1970.
const SECONDS: usize = 10;

/// Reads a number of eight digits in parallel: pairs of neighbours are combined, then pairs of pairs.
fn eight_digits(text: [u8; 8]) -> Option<u32> {
    let digits = u64::from_le_bytes(text) ^ 0x3030_3030_3030_3030;
    let beyond = digits.wrapping_add(0x7676_7676_7676_7676) | digits;
    if beyond & 0x8080_8080_8080_8080 != 0 {
        return None;
    }
    let pairs = (digits * 10 + (digits >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    let eight = (fours * 10_000 + (fours >> 32)) & 0xffff_ffff;
    u32::try_from(eight).ok()
}

/// Returns the first word, and the rest.
fn word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let start = text.iter().position(|byte| !byte.is_ascii_whitespace())?;
    let text = text.get(start..)?;
    let end = memchr(b' ', text).unwrap_or(text.len());
    let word = text.get(..end)?;
    // Blanks are the usual separator.
    let end = (word.iter().position(u8::is_ascii_whitespace)).unwrap_or(end);
    Some(text.split_at(end))
}

/// Reads seconds with a fraction. Returns nanoseconds and the number of digits of the fraction. The fraction
/// is a number of nanoseconds, whatever its length: the recorder writes all nine digits.
fn stamp(word: &[u8]) -> Option<(i64, usize)> {
    let point = memchr(b'.', word)?;
    let (seconds, fraction) = word.split_at(point);
    let (seconds, used) = number(seconds)?;
    let (nanos, digits) = number(fraction.get(1..)?)?;
    if used != point {
        return None;
    }
    Some((seconds.checked_mul(NANOS)?.checked_add(nanos)?, digits))
}

/// Number of digits that never overflow.
const DIGITS: usize = 18;

/// Returns the number at the start of a word, and its length.
fn number(word: &[u8]) -> Option<(i64, usize)> {
    let mut value: i64 = 0;
    let mut used = 0;
    for byte in word {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        if used == DIGITS {
            return None;
        }
        value = value * 10 + i64::from(digit);
        used += 1;
    }
    (used > 0).then_some((value, used))
}

/// Splits a stream of bytes into lines.
#[derive(Debug, Default)]
pub struct Lines {
    /// Incomplete line at the end.
    rest: Vec<u8>,
    /// The present line is too long, and is skipped to its end.
    lost: bool,
    number: u64,
}

impl Lines {
    /// Reads more bytes. `each` gets every complete line, with its number from 1, without its line break.
    pub fn feed(&mut self, mut bytes: &[u8], mut each: impl FnMut(u64, &[u8])) {
        while let Some(end) = memchr(b'\n', bytes) {
            let (line, after) = bytes.split_at(end);
            self.number += 1;
            if self.lost {
                each(self.number, b"");
            } else if self.rest.is_empty() {
                each(self.number, line);
            } else {
                self.rest.extend_from_slice(line);
                each(self.number, &self.rest);
            }
            self.rest.clear();
            self.lost = false;
            bytes = after.get(1..).unwrap_or_default();
        }
        if self.rest.len() + bytes.len() > MAX_LINE_BYTES {
            self.lost = true;
            self.rest.clear();
        } else if !self.lost {
            self.rest.extend_from_slice(bytes);
        }
    }

    /// Returns the last line if its line break is missing: the writer may have been stopped within the line.
    pub fn unterminated_line(&self) -> Option<(u64, &[u8])> {
        (self.lost || !self.rest.is_empty()).then_some((self.number + 1, self.rest.as_slice()))
    }
}

/// Finds out if a log breaks off: within a line, or without the line that ends a log of `dotgen run`.
#[derive(Debug, Default)]
pub struct TruncationCheck {
    /// A run has begun, and has not ended.
    open: bool,
    cut: bool,
    last: u64,
}

impl TruncationCheck {
    /// Reads a line of a log. `ended`: the line has its line break.
    pub fn line(&mut self, number: u64, text: &[u8], ended: bool) {
        if ended {
            self.last = number;
        } else {
            self.cut = true;
        }
        match origin(text).filter(|_| ended) {
            Some(Origin::Measured | Origin::Simulated) => self.open = true,
            Some(Origin::End) => self.open = false,
            _ => {}
        }
    }

    /// Returns the number of the last whole line, if the log breaks off after it.
    pub fn after(&self) -> Option<u64> {
        (self.open || self.cut).then_some(self.last)
    }
}

/// A combination of names: all lines of a log with the same names have the same kind.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LineKind {
    /// Instance: the name of the component, unless the server was started under another name.
    pub instance: String,
    pub task: String,
    pub service: String,
    pub function: String,
    /// Event before the run.
    pub from: String,
    /// Event after the run.
    pub to: String,
}

/// One run of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoggedRun {
    /// Time of the request for its locks, in nanoseconds.
    pub asked: i64,
    /// Time of their grant, in nanoseconds.
    pub began: i64,
    /// Time of their release, in nanoseconds.
    pub ended: i64,
    /// Number of its kind: see [`LineKinds`].
    pub kind: u32,
}

/// The kinds of the lines of a log, without repetition.
#[derive(Debug, Clone, Default)]
pub struct LineKinds {
    /// Numbers of kinds, by the text after the times.
    known: FxHashMap<Box<[u8]>, u32>,
    /// Kinds, in order of first appearance.
    pub all: Vec<LineKind>,
    abouts: Vec<LineSubject>,
}

impl LineKinds {
    /// Returns the number of the kind of a line, and the subject of such lines.
    pub fn of(&mut self, line: &Line<'_>) -> (u32, LineSubject) {
        let known = self.known.get(line.tail).copied();
        let kind = known.unwrap_or_else(|| self.add_kind(line));
        (kind, self.about(kind as usize))
    }

    pub fn about(&self, kind: usize) -> LineSubject {
        self.abouts.get(kind).copied().unwrap_or(LineSubject::Garbage)
    }

    fn add_kind(&mut self, line: &Line<'_>) -> u32 {
        let names = line.names();
        let about = names.map_or(LineSubject::Garbage, about);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let [instance, task, service, function, from, to] = names.unwrap_or([b""; NAMES]).map(text);
        let kind = u32::try_from(self.all.len()).unwrap_or(u32::MAX);
        self.abouts.push(about);
        self.all.push(LineKind { instance, task, service, function, from, to });
        self.known.insert(line.tail.into(), kind);
        kind
    }
}

fn about([instance, _, _, function, _, last]: [&[u8]; NAMES]) -> LineSubject {
    if last.is_empty() {
        LineSubject::Cut
    } else if function == OVERLOAD {
        LineSubject::Overload
    } else if instance == RECORDER {
        LineSubject::Recorder
    } else {
        LineSubject::Codel
    }
}

/// The lines of a log that were not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct SkippedLines {
    /// Lines of the recorder about itself.
    pub recorder: u64,
    /// Lines of threads that had to wait for the recorder.
    pub overloads: u64,
    /// Runs whose times go backwards.
    pub clock_steps: u64,
    /// Lines that are cut: columns are missing, or the end of the line.
    pub cut: u64,
    /// Lines that do not belong to a log.
    pub garbage: u64,
}

impl SkippedLines {
    /// Returns the number of all of these lines.
    pub fn total(&self) -> u64 {
        self.recorder + self.overloads + self.clock_steps + self.cut + self.garbage
    }

    /// Returns the run of a codel that a line stands for, with its kind; counts any other line. `ended`: the
    /// line has its line break.
    pub fn classify<'l>(
        &mut self,
        kinds: &mut LineKinds,
        text: &'l [u8],
        ended: bool,
    ) -> Option<(Line<'l>, u32)> {
        if !ended {
            // The last name may be incomplete.
            self.cut += 1;
            return None;
        }
        let Some(line) = line(text) else {
            if origin(text).is_some() {
                return None;
            }
            self.garbage += u64::from(!text.trim_ascii().is_empty());
            return None;
        };
        let (kind, about) = kinds.of(&line);
        self.count(&line, about, ended).then_some((line, kind))
    }

    /// Returns true if a line stands for a run of a codel; counts any other line.
    pub fn count(&mut self, line: &Line<'_>, about: LineSubject, ended: bool) -> bool {
        let count = match about {
            _ if !ended => &mut self.cut,
            LineSubject::Garbage => &mut self.garbage,
            LineSubject::Cut => &mut self.cut,
            _ if !line.exact => &mut self.garbage,
            LineSubject::Recorder => &mut self.recorder,
            LineSubject::Overload => &mut self.overloads,
            LineSubject::Codel if line.is_step() => &mut self.clock_steps,
            LineSubject::Codel => return true,
        };
        *count += 1;
        false
    }
}

#[cfg(test)]
mod tests;
