//! The log of GenoM3's profiler, line by line.
//!
//! A line has nine columns: when a codel asked for its locks, got them and released them (seconds with nine
//! digits after the point), instance, task, service, function, and the events that it came from and led to.
//! The facts are from the recorder (`templates/common/prof.c`) and from `profundis`, which reads its logs
//! (both of GenoM3 2.99.39). The recorder writes lines about itself: those of the instance `genom`, and those of
//! the function `genom_prof_record`, where a thread had to wait for the recorder.

use memchr::memchr;
use rustc_hash::FxHashMap;

/// Nanoseconds of a second.
const NANOS: i64 = 1_000_000_000;

/// Names after the three times.
const NAMES: usize = 6;

/// Instance under which the recorder writes about itself.
const RECORDER: &[u8] = b"genom";

/// Function under which it writes that a thread had to wait for it.
const OVERLOAD: &[u8] = b"genom_prof_record";

/// A line longer than this is no line of a log: it is given up, so that no memory is taken for it.
const LONGEST: usize = 1 << 16;

/// A line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'l> {
    /// When locks were asked for, in nanoseconds.
    pub asked: i64,
    /// When all of them were held.
    pub began: i64,
    /// When they were released.
    pub ended: i64,
    /// Instance, task, service, function, and the events from which and to which. Missing ones are empty.
    pub names: [&'l [u8]; NAMES],
    /// All columns are there, and the times have nine digits after the point, as the recorder writes them.
    pub whole: bool,
    /// What follows the times, as it stands in the line.
    tail: &'l [u8],
}

/// What a line is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// A run of a codel.
    Codel,
    /// The recorder itself.
    Recorder,
    /// A thread that waited for the recorder: what it measured then is late.
    Overload,
    /// A run whose times go backwards: the clock was set meanwhile.
    ClockStep,
}

/// Reads a line, as `profundis` does: with at most nine columns, of which the first three are times. `None`: it is no
/// line of a log.
pub fn line(text: &[u8]) -> Option<Line<'_>> {
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
    let tail = rest.trim_ascii();
    let mut names: [&[u8]; NAMES] = [b""; NAMES];
    let mut count = 0;
    while let Some((name, after)) = word(rest) {
        *names.get_mut(count)? = name;
        count += 1;
        rest = after;
    }
    let [asked, began, ended] = times;
    Some(Line {
        asked,
        began,
        ended,
        names,
        whole: exact && count == NAMES,
        tail,
    })
}

impl Line<'_> {
    /// What it is about.
    pub fn about(&self) -> About {
        let [instance, _, _, function, ..] = self.names;
        if function == OVERLOAD {
            About::Overload
        } else if instance == RECORDER {
            About::Recorder
        } else if self.began < self.asked || self.ended < self.began {
            About::ClockStep
        } else {
            About::Codel
        }
    }
}

/// The first word, and what follows it.
fn word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let start = text.iter().position(|it| !it.is_ascii_whitespace())?;
    let text = text.get(start..)?;
    let end = memchr(b' ', text).unwrap_or(text.len());
    let word = text.get(..end)?;
    // Blanks are the rule.
    let end = (word.iter().position(u8::is_ascii_whitespace)).unwrap_or(end);
    Some(text.split_at(end))
}

/// Seconds with a fraction, as nanoseconds, and how many digits the fraction has. What stands behind the point is a
/// number of nanoseconds, whatever its length: the recorder writes all nine digits.
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

/// The number at the start of a word, and its length.
fn number(word: &[u8]) -> Option<(i64, usize)> {
    let mut value: i64 = 0;
    let mut used = 0;
    for it in word.iter().take_while(|it| it.is_ascii_digit()) {
        value = value.checked_mul(10)?.checked_add(i64::from(it - b'0'))?;
        used += 1;
    }
    (used > 0).then_some((value, used))
}

/// Cuts lines out of what is read piece by piece.
#[derive(Debug, Default)]
pub struct Lines {
    /// The beginning of a line whose end has not come.
    rest: Vec<u8>,
    /// The line is too long, its end is awaited.
    lost: bool,
    number: u64,
}

impl Lines {
    /// Reads on. The function gets each line that has ended, with its number from 1, without its end.
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
        if self.rest.len() + bytes.len() > LONGEST {
            self.lost = true;
            self.rest.clear();
        } else if !self.lost {
            self.rest.extend_from_slice(bytes);
        }
    }

    /// The last line, if it has no end: its writer may have been stopped within it.
    pub fn unended(&self) -> Option<(u64, &[u8])> {
        (self.lost || !self.rest.is_empty()).then_some((self.number + 1, self.rest.as_slice()))
    }
}

/// Who executed what, and where it led.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Kind {
    /// The instance: the name of the component, unless the server was started under another.
    pub instance: String,
    /// The task.
    pub task: String,
    /// The service.
    pub service: String,
    /// The function.
    pub function: String,
    /// The event from which.
    pub from: String,
    /// The event to which.
    pub to: String,
}

/// One run of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// When it asked for its locks, in nanoseconds.
    pub asked: i64,
    /// When it had them.
    pub began: i64,
    /// When it released them.
    pub ended: i64,
    /// Of what kind: see [`Kinds`].
    pub kind: u32,
}

/// The kinds of lines of a log, each once.
#[derive(Debug, Clone, Default)]
pub struct Kinds {
    known: FxHashMap<Box<[u8]>, u32>,
    /// In order of first appearance.
    pub all: Vec<Kind>,
}

impl Kinds {
    /// The number of the kind of a line.
    pub fn of(&mut self, line: &Line<'_>) -> u32 {
        if let Some(&kind) = self.known.get(line.tail) {
            return kind;
        }
        let text = |it: &[u8]| String::from_utf8_lossy(it).into_owned();
        let [instance, task, service, function, from, to] = line.names.map(text);
        let kind = u32::try_from(self.all.len()).unwrap_or(u32::MAX);
        self.all.push(Kind {
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

/// What lines of a log were not used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Left {
    /// Lines of the recorder about itself.
    pub recorder: u64,
    /// Lines of threads that had to wait for the recorder.
    pub overloads: u64,
    /// Runs whose times go backwards.
    pub clock_steps: u64,
    /// Lines that are cut: columns are missing, or the end of the line.
    pub cut: u64,
    /// Lines that are none of a log.
    pub garbage: u64,
}

impl Left {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.recorder + self.overloads + self.clock_steps + self.cut + self.garbage
    }

    /// Takes a line that stands for a run of a codel, and counts any other. `ended`: the end of the line was seen.
    pub fn sift<'l>(&mut self, text: &'l [u8], ended: bool) -> Option<Line<'l>> {
        let Some(line) = line(text) else {
            match text.trim_ascii().is_empty() && ended {
                true => {}
                // Some of the times may be missing as well.
                false if !ended => self.cut += 1,
                false => self.garbage += 1,
            }
            return None;
        };
        if !line.whole || !ended {
            self.cut += 1;
            return None;
        }
        match line.about() {
            About::Codel => return Some(line),
            About::Recorder => self.recorder += 1,
            About::Overload => self.overloads += 1,
            About::ClockStep => self.clock_steps += 1,
        }
        None
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
        assert_eq!(line.names[0], b"pump");
        assert_eq!(line.names[5], b"::pump::pause::start");
        assert!(line.whole);
        assert_eq!(line.about(), About::Codel);
    }

    #[test]
    fn what_is_no_run_is_counted() {
        let mut left = Left::default();
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
            assert_eq!(left.sift(text.as_bytes(), true), None, "{text}");
        }
        assert!(left.sift(PLAIN.as_bytes(), true).is_some());
        assert!(left.sift(PLAIN.as_bytes(), false).is_none());
        let expected = Left {
            recorder: 1,
            overloads: 1,
            clock_steps: 1,
            cut: 2,
            garbage: 3,
        };
        assert_eq!(left, expected);
        // A word too many.
        assert_eq!(line(format!("{PLAIN} more").as_bytes()), None);
    }

    #[test]
    fn lines_come_whole_however_they_are_read() {
        let text = format!("{PLAIN}\r\nnext\n\n{}", &PLAIN[..9]);
        let read = |size: usize| {
            let (mut lines, mut all) = (Lines::default(), Vec::new());
            for piece in text.as_bytes().chunks(size) {
                lines.feed(piece, |number, line| all.push((number, line.to_vec())));
            }
            all.extend(lines.unended().map(|it| (it.0, it.1.to_vec())));
            all
        };
        let whole = read(text.len());
        assert_eq!(whole.len(), 4);
        for size in 1..70 {
            assert_eq!(read(size), whole);
        }
        assert!(line(&whole[0].1).is_some_and(|it| it.names[5] == b"::pump::pause::start"));
    }

    #[test]
    fn a_line_without_end_takes_no_memory() {
        let mut lines = Lines::default();
        for _ in 0..100 {
            lines.feed(&[b'x'; 10_000], |_, _| panic!("it has no end"));
        }
        assert!(lines.rest.len() <= LONGEST);
        let mut all = Vec::new();
        lines.feed(b"\nnext\n", |_, line| all.push(line.to_vec()));
        assert_eq!(all, [b"".to_vec(), b"next".to_vec()]);
    }
}
