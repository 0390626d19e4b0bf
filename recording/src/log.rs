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

/// Returns the last line of a log.
pub fn end() -> String {
    format!(
        "{}end of the run\n",
        String::from_utf8_lossy(TIME_SOURCE_PREFIX)
    )
}

/// Reads a line that names the source of times; returns `None` for other lines.
pub fn origin(text: &[u8]) -> Option<Origin<'_>> {
    match std::str::from_utf8(text.strip_prefix(TIME_SOURCE_PREFIX)?)
        .ok()?
        .trim()
    {
        "times are measured" => Some(Origin::Measured),
        "times are simulated" => Some(Origin::Simulated),
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

/// The subject of a line.
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
        return Some(Line {
            asked,
            began,
            ended,
            exact: true,
            tail: rest.trim_ascii(),
        });
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
    Some(Line {
        asked,
        began,
        ended,
        exact,
        tail: rest.trim_ascii(),
    })
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
        let (eight, after) = rest
            .get(length..)?
            .strip_prefix(b".")?
            .split_first_chunk()?;
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
        match ended {
            true => self.last = number,
            false => self.cut = true,
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
    /// Task.
    pub task: String,
    /// Service.
    pub service: String,
    /// Function.
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

    /// Returns the subject of the lines of a kind.
    pub fn about(&self, kind: usize) -> LineSubject {
        self.abouts
            .get(kind)
            .copied()
            .unwrap_or(LineSubject::Garbage)
    }

    fn add_kind(&mut self, line: &Line<'_>) -> u32 {
        let names = line.names();
        let about = names.map_or(LineSubject::Garbage, about);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let [instance, task, service, function, from, to] = names.unwrap_or([b""; NAMES]).map(text);
        let kind = u32::try_from(self.all.len()).unwrap_or(u32::MAX);
        self.abouts.push(about);
        self.all.push(LineKind {
            instance,
            task,
            service,
            function,
            from,
            to,
        });
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
mod tests {
    use super::*;

    const PLAIN: &str = "0.020500000 0.020500001 0.023000000 pump report <permanent> report_start \
                         ::pump::start ::pump::pause::start";

    #[test]
    fn a_line_has_its_nine_columns() {
        let line = line(PLAIN.as_bytes()).expect("a line");
        assert_eq!(
            (line.asked, line.began, line.ended),
            (20_500_000, 20_500_001, 23_000_000)
        );
        let names = line.names().expect("six");
        assert_eq!(names[0], b"pump");
        assert_eq!(names[5], b"::pump::pause::start");
        assert!(line.exact);
        assert_eq!(LineKinds::default().of(&line), (0, LineSubject::Codel));
    }

    #[test]
    fn times_are_read_alike_fast_and_with_care() {
        let tail = " pump report";
        for times in [
            "0.020500000 0.020500001 0.023000000",
            "1700000000.123456789 1700000000.999999999 1700000001.000000000",
            "9999999999.000000000 9999999999.000000000 9999999999.000000000",
            "12345678901.000000000 12345678901.000000000 12345678901.000000001",
            "0.5 0.50 0.500000000",
            "0.02050000a 0.020500001 0.023000000",
            ".020500000 0.020500001 0.023000000",
            "0.020500000 0.020500001 0.0230000001",
            "0.020500000 0.020500001 0.02300000/",
            "0.020500000 0.020500001 0.02300000:",
            "0.020500000 0.020500001 0.0230000\u{b2}",
            "0.020500000 0,020500001 0.023000000",
        ] {
            let fast =
                line(format!("{times}{tail}").as_bytes()).map(|line| (line.ended, line.exact));
            // A recorder never writes a blank in front.
            let careful =
                line(format!(" {times}{tail}").as_bytes()).map(|line| (line.ended, line.exact));
            assert_eq!(fast, careful, "{times}");
        }
        for number in [0u32, 1, 9, 10, 12_345_678, 99_999_999, 90_000_000] {
            let text = format!("{number:08}");
            let text = <[u8; 8]>::try_from(text.as_bytes()).expect("eight");
            assert_eq!(eight_digits(text), Some(number));
        }
    }

    #[test]
    fn what_is_no_run_is_counted() {
        let (mut left, mut kinds) = (SkippedLines::default(), LineKinds::default());
        let cut = &PLAIN[..60];
        let genom =
            "1.000000000 1.000000000 2.000000000 genom profiling writer prof_writer wakeup sleep";
        let overload = PLAIN.replace("report_start", "genom_prof_record");
        let step = PLAIN.replace("0.023", "0.003");
        for text in [
            cut,
            genom,
            &overload,
            &step,
            "hello",
            "",
            "1.5 x 3",
            "-1.0 2.0 3.0 a b c d e f",
        ] {
            assert_eq!(
                left.classify(&mut kinds, text.as_bytes(), true),
                None,
                "{text}"
            );
        }
        assert!(left.classify(&mut kinds, PLAIN.as_bytes(), true).is_some());
        assert!(left.classify(&mut kinds, PLAIN.as_bytes(), false).is_none());
        let expected = SkippedLines {
            recorder: 1,
            overloads: 1,
            clock_steps: 1,
            cut: 2,
            garbage: 3,
        };
        assert_eq!(left, expected);
        // One word too many.
        let more = format!("{PLAIN} more");
        assert_eq!(line(more.as_bytes()).and_then(|line| line.names()), None);
    }

    #[test]
    fn lines_come_whole_however_they_are_read() {
        let text = format!("{PLAIN}\r\nnext\n\n{}", &PLAIN[..9]);
        let read = |size: usize| {
            let (mut lines, mut all) = (Lines::default(), Vec::new());
            for piece in text.as_bytes().chunks(size) {
                lines.feed(piece, |number, line| all.push((number, line.to_vec())));
            }
            all.extend(
                lines
                    .unterminated_line()
                    .map(|line| (line.0, line.1.to_vec())),
            );
            all
        };
        let whole = read(text.len());
        assert_eq!(whole.len(), 4);
        for size in 1..70 {
            assert_eq!(read(size), whole);
        }
        assert!(line(&whole[0].1).is_some_and(|line| line.tail.ends_with(b"::pause::start")));
    }

    #[test]
    fn a_log_is_read_up_to_any_byte() {
        let text = format!(
            "{}{PLAIN}\n{PLAIN}\n{}",
            origins(false, [].into_iter()),
            end()
        );
        for length in 0..=text.len() {
            let (mut lines, mut breaks) = (Lines::default(), TruncationCheck::default());
            let (mut left, mut kinds) = (SkippedLines::default(), LineKinds::default());
            let mut runs = 0;
            let mut read = |number, line: &[u8], ended| {
                breaks.line(number, line, ended);
                runs += usize::from(left.classify(&mut kinds, line, ended).is_some());
            };
            lines.feed(&text.as_bytes()[..length], |number, line| {
                read(number, line, true);
            });
            if let Some((number, line)) = lines.unterminated_line() {
                read(number, line, false);
            }
            let whole = text[..length].matches('\n').count();
            assert_eq!(runs, whole.saturating_sub(1).min(2), "{length}");
            let expected = (length > 0 && length < text.len()).then_some(whole as u64);
            assert_eq!(breaks.after(), expected, "{length}");
        }
    }

    #[test]
    fn a_line_without_end_takes_no_memory() {
        let mut lines = Lines::default();
        for _ in 0..100 {
            lines.feed(&[b'x'; 10_000], |_, _| panic!("it has no end"));
        }
        assert!(lines.rest.len() <= MAX_LINE_BYTES);
        let mut all = Vec::new();
        lines.feed(b"\nnext\n", |_, line| all.push(line.to_vec()));
        assert_eq!(all, [b"".to_vec(), b"next".to_vec()]);
    }
}
