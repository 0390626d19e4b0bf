//! The progress of a long command: one line on the terminal, which is cleared at the end.

use std::io::{IsTerminal, Write};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use dotgen_timing::verify::{Cancel, Effort};

/// Time before the line is drawn: short commands show none.
const FIRST_DRAW_DELAY: Duration = Duration::from_secs(1);
const REDRAW_INTERVAL: Duration = Duration::from_millis(250);

/// Maximum length. Longer lines would be wrapped, and could not be cleared.
const WIDTH: usize = 78;

/// The current work.
#[derive(Clone, Default)]
pub(crate) struct Activity {
    /// The work as text, shortened if it is too long.
    pub(crate) what: String,
    /// The finished part of the work, if it is known.
    pub(crate) how_far: String,
}

/// Does some work, which sets its activity, and keeps the line up to date meanwhile. The line has the effort
/// of a verification, if `cancel` counts one.
pub(crate) fn during<R>(
    cancel: Option<&Cancel>,
    doing: &str,
    work: impl FnOnce(&(dyn Fn(Activity) + Sync)) -> R,
) -> R {
    let dumb = std::env::var_os("TERM").is_some_and(|variable| variable == "dumb");
    if dumb || !std::io::stderr().is_terminal() {
        return work(&|_| {});
    }
    let shared = Shared {
        doing: Mutex::new(Activity { what: doing.to_owned(), ..Activity::default() }),
        over: Mutex::new(false),
        ended: Condvar::new(),
    };
    std::thread::scope(|scope| {
        scope.spawn(|| shared.paint(cancel, &mut Line::new(std::io::stderr())));
        let _end = End(&shared);
        work(&|doing| *lock(&shared.doing) = doing)
    })
}

struct Shared {
    doing: Mutex<Activity>,
    over: Mutex<bool>,
    ended: Condvar,
}

/// Ends the drawing, also when the work panics.
struct End<'s>(&'s Shared);

impl Drop for End<'_> {
    fn drop(&mut self) {
        *lock(&self.0.over) = true;
        self.0.ended.notify_all();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn paint(&self, cancel: Option<&Cancel>, line: &mut Line<impl Write>) {
        let start = Instant::now();
        let mut pause = FIRST_DRAW_DELAY;
        let mut over = lock(&self.over);
        while !*over {
            let waited = self.ended.wait_timeout(over, pause);
            over = waited.unwrap_or_else(PoisonError::into_inner).0;
            if !*over {
                let doing = lock(&self.doing).clone();
                line.show(&words(&doing, cancel.map(Cancel::effort), start.elapsed()));
            }
            pause = REDRAW_INTERVAL;
        }
        line.clear();
    }
}

/// `verifying hover: 5 of 7 checks answered, 1203456 states, 12 s, 340 MB`
fn words(
    Activity { what, how_far }: &Activity,
    effort: Option<Effort>,
    elapsed: Duration,
) -> String {
    let how_far = if how_far.is_empty() { String::new() } else { format!("{how_far}, ") };
    let (states, bytes) = effort.map_or((String::new(), String::new()), |effort| {
        (format!("{} states, ", effort.states), format!(", {} MB", effort.bytes >> 20))
    });
    let so_far = format!(": {how_far}{states}{} s{bytes}", elapsed.as_secs());
    let left = WIDTH.saturating_sub(so_far.len());
    if what.char_indices().nth(left).is_none() {
        format!("{what}{so_far}")
    } else {
        let start: String = what.chars().take(left.saturating_sub(2)).collect();
        format!("{start} …{so_far}")
    }
}

/// A line that is overwritten. Errors of the terminal are ignored.
struct Line<W> {
    out: W,
    shown: bool,
}

impl<W: Write> Line<W> {
    fn new(out: W) -> Self {
        Line { out, shown: false }
    }

    fn show(&mut self, text: &str) {
        let _ = write!(self.out, "\r\x1b[2K{text}");
        let _ = self.out.flush();
        self.shown = true;
    }

    fn clear(&mut self) {
        if std::mem::take(&mut self.shown) {
            let _ = write!(self.out, "\r\x1b[2K");
            let _ = self.out.flush();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_how_far_it_is_and_fits() {
        let effort = Effort { states: 1_203_456, bytes: 340 << 20 };
        let after = Duration::from_millis(12_700);
        let words = |what: &str, how_far: &str| {
            let (what, how_far) = (what.to_owned(), how_far.to_owned());
            words(&Activity { what, how_far }, Some(effort), after)
        };
        assert_eq!(words("verifying hover", ""), "verifying hover: 1203456 states, 12 s, 340 MB");
        assert_eq!(
            words("verifying hover", "5 of 7 checks answered"),
            "verifying hover: 5 of 7 checks answered, 1203456 states, 12 s, 340 MB"
        );
        let long = format!("looking for the WCET of {}", "é".repeat(100));
        let line = words(&long, "2 of 9");
        assert!(line.chars().count() <= WIDTH, "{line}");
        assert!(line.ends_with("é …: 2 of 9, 1203456 states, 12 s, 340 MB"), "{line}");
        let compiling = Activity { what: "compiling".into(), how_far: "1 of 3 files".into() };
        assert_eq!(super::words(&compiling, None, after), "compiling: 1 of 3 files, 12 s");
    }

    #[test]
    fn a_line_is_written_over_and_removed() {
        let mut out = Vec::new();
        let mut line = Line::new(&mut out);
        line.show("one");
        line.show("two");
        line.clear();
        line.clear();
        let out = String::from_utf8(out).expect("text");
        assert_eq!(out, "\r\x1b[2Kone\r\x1b[2Ktwo\r\x1b[2K");
    }

    #[test]
    fn what_is_soon_over_is_not_shown() {
        let shared =
            Shared { doing: Mutex::default(), over: Mutex::new(true), ended: Condvar::new() };
        let mut out = Vec::new();
        shared.paint(None, &mut Line::new(&mut out));
        assert_eq!(out, b"");
    }
}
