//! Runs in which repeated steps are shown once.

use std::collections::HashMap;
use std::ops::Range;

use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::Event;

/// A part of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// These steps, one by one.
    Steps(Range<usize>),
    /// Repetitions of the last `steps` steps.
    Again {
        /// Number of steps that repeat.
        steps: usize,
        /// Number of repetitions.
        times: usize,
        /// The last omitted step.
        last: usize,
    },
}

/// Maximum length of a series of steps that is searched for repetition.
const MAX_PERIOD_STEPS: usize = 32;
/// Minimum number of steps that are omitted; shorter repetitions are shown in full.
const MIN_OMITTED_STEPS: usize = 8;

/// A run in parts. Repetition is decided by the order of steps, not by their times. The part that repeats for
/// ever begins a new part.
pub fn fold_repetitions(events: &[Event], cycle: Option<usize>) -> Vec<Part> {
    let mut ids = HashMap::new();
    let steps: Vec<usize> = events
        .iter()
        .map(|event| {
            let next = ids.len();
            let about = (&event.thread, &event.codel);
            // A codel begins in the same way whatever caused it, but its end is a choice.
            let is_choice = matches!(event.kind, MomentKind::End | MomentKind::Request);
            let choice = event.action.filter(|_| is_choice);
            *ids.entry((about, event.kind, choice)).or_insert(next)
        })
        .collect();
    let cycle = cycle.unwrap_or(0).min(steps.len());
    let mut out = Vec::new();
    for range in [0..cycle, cycle..steps.len()] {
        fold(&steps, range, &mut out);
    }
    out
}

fn fold(steps: &[usize], range: Range<usize>, out: &mut Vec<Part>) {
    let (mut from, mut at) = (range.start, range.start);
    while at < range.end {
        let rest = &steps[at..range.end];
        let repeats =
            (1..=MAX_PERIOD_STEPS.min(rest.len() / 2)).map(|length| (length, again(rest, length)));
        // The repetition that omits most steps, and of equals the shortest series.
        let best = repeats.rev().max_by_key(|(length, times)| length * times);
        match best.filter(|(length, times)| length * times >= MIN_OMITTED_STEPS) {
            Some((length, times)) => {
                out.push(Part::Steps(from..at + length));
                at += length * (times + 1);
                from = at;
                out.push(Part::Again { steps: length, times, last: at - 1 });
            }
            None => at += 1,
        }
    }
    if from < range.end {
        out.push(Part::Steps(from..range.end));
    }
}

/// The number of times that the first `length` steps repeat immediately.
fn again(steps: &[usize], length: usize) -> usize {
    let same = steps.iter().zip(&steps[length..]);
    same.take_while(|(a, b)| a == b).count() / length
}

/// `the last 4 steps 212 times more`
pub fn words(steps: usize, times: usize) -> String {
    let steps = match steps {
        1 => "the last step".to_owned(),
        _ => format!("the last {steps} steps"),
    };
    match times {
        1 => format!("{steps} once more"),
        _ => format!("{steps} {times} times more"),
    }
}

#[cfg(test)]
mod tests {
    use dotgen_timing::system::{CodelName, ThreadName};

    use super::*;

    fn parts(text: &str, cycle: Option<usize>) -> Vec<Part> {
        let event = |(i, what): (usize, char)| {
            let thread = ThreadName::of_component("c");
            let thread = Event::of_thread(i as f64, thread, MomentKind::Begin, String::new());
            let codel = Some(CodelName::of_service("c", &what.to_string()));
            Event { codel, ..thread }
        };
        let events: Vec<Event> = text.chars().enumerate().map(event).collect();
        let parts = fold_repetitions(&events, cycle);
        // Every step is in exactly one part.
        let mut at = 0;
        for part in &parts {
            at = match part {
                Part::Steps(range) => {
                    assert_eq!(range.start, at);
                    range.end
                }
                Part::Again { steps, times, last } => {
                    assert_eq!(at + steps * times, last + 1);
                    last + 1
                }
            };
        }
        assert_eq!(at, text.len());
        parts
    }

    #[test]
    fn what_repeats_itself_is_said_once() {
        let again = |steps, times, last| Part::Again { steps, times, last };
        assert_eq!(parts("", None), []);
        assert_eq!(parts("abababcd", None), [Part::Steps(0..8)]);
        assert_eq!(
            parts("xababababababy", None),
            [Part::Steps(0..3), again(2, 5, 12), Part::Steps(13..14)]
        );
        assert_eq!(parts("aaaaaaaaaaaa", None), [Part::Steps(0..1), again(1, 11, 11)]);
        // The start of the infinite repetition is always shown.
        assert_eq!(
            parts("ababababababababababab", Some(12)),
            [Part::Steps(0..2), again(2, 5, 11), Part::Steps(12..14), again(2, 4, 21)]
        );
    }
}
