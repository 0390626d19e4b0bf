//! Times of the transitions of a trace: those of the trace, or the earliest ones.

use dotgen_timing::explore::Action;

use super::{Error, Goal, Written};

/// Limit on comparisons of times.
const WORK: usize = 200_000_000;

/// An action of the verifier in a trace.
#[derive(Debug, Clone)]
pub(super) struct Taken {
    /// Number of the transition, from 1.
    pub(super) transition: usize,
    pub(super) line: usize,
    pub(super) action: Action,
    /// The edge in words.
    pub(super) words: String,
}

/// A trace in the network.
#[derive(Debug, Default)]
pub(super) struct Followed {
    /// Actions of the verifier, in order.
    pub(super) actions: Vec<Taken>,
    /// Line of each transition.
    pub(super) lines: Vec<usize>,
    /// True for each state in which no time passes.
    pub(super) stops: Vec<bool>,
    pub(super) constraints: Vec<Constraint>,
    pub(super) end: Option<Goal>,
}

/// A time is at least another time plus a number of base units. Times are numbered: the start is 0, then come
/// the transitions and the end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constraint {
    from: usize,
    to: usize,
    least: i64,
}

impl Constraint {
    /// At least a time passes between a reset and a moment.
    pub(super) fn at_least(reset: usize, now: usize, least: i64) -> Constraint {
        Constraint { from: reset, to: now, least }
    }

    /// At most a time passes between a reset and a moment.
    pub(super) fn at_most(reset: usize, now: usize, most: i64) -> Constraint {
        Constraint { from: now, to: reset, least: -most }
    }

    /// Returns the later of its two times.
    fn later(&self) -> usize {
        self.from.max(self.to)
    }
}

/// Returns the time of each transition and of the end, from time 0, and whether all are those of the trace.
pub(super) fn of(followed: &Followed, written: &Written) -> Result<(Vec<i64>, bool), Error> {
    let count = followed.lines.len();
    let line = |number: usize| followed.lines.get(number.clamp(1, count.max(1)) - 1).copied();
    let delays = written.transitions.iter().map(|transition| transition.delay).chain([Some(0)]);
    let times: Option<Vec<i64>> = delays
        .scan(0_i64, |sum, delay| {
            let time = delay.and_then(|delay| sum.checked_add(delay));
            *sum = time.unwrap_or(*sum);
            Some(time)
        })
        .collect();
    if let Some(times) = times.filter(|_| written.has_times) {
        let time = |number: usize| if number == 0 { 0 } else { times[number - 1] };
        let urgent =
            (0..=count).find(|&number| followed.stops[number] && time(number) != time(number + 1));
        let broken = followed.constraints.iter().find(|constraint| {
            time(constraint.to) < time(constraint.from).saturating_add(constraint.least)
        });
        return match urgent.map(|number| number + 1).or(broken.map(Constraint::later)) {
            Some(number) => {
                let message = "the model has other times for this transition".to_owned();
                Err(Error { line: line(number), message })
            }
            None => Ok((times, true)),
        };
    }
    if let Some(times) = earliest(followed, count + 1)? {
        return Ok((times, false));
    }
    // The first transition that has no time.
    let (mut fits, mut fails) = (0, count + 1);
    while fits + 1 < fails {
        let middle = usize::midpoint(fits, fails);
        if earliest(followed, middle)?.is_some() { fits = middle } else { fails = middle }
    }
    let message = "no times in whole base units fit the trace up to this transition".to_owned();
    Err(Error { line: line(fails), message })
}

/// Returns the earliest time of each transition up to one with a number: the least solution of a system of
/// differences (Bellman and Ford). `None`: no times fit.
fn earliest(followed: &Followed, last: usize) -> Result<Option<Vec<i64>>, Error> {
    // Transitions at one moment share a time.
    let mut moments = vec![0];
    for number in 0..last {
        moments.push(moments[number] + usize::from(!followed.stops[number]));
    }
    let count = moments[last] + 1;
    let within = followed.constraints.iter().filter(|constraint| constraint.later() <= last);
    let mut all: Vec<Constraint> = within
        .map(|constraint| Constraint {
            from: moments[constraint.from],
            to: moments[constraint.to],
            least: constraint.least,
        })
        .chain((1..count).map(|now| Constraint::at_least(now - 1, now, 0)))
        .collect();
    all.sort_unstable_by_key(Constraint::later);
    let mut times = vec![0_i64; count];
    let most =
        all.iter().fold(0_i64, |sum, constraint| sum.saturating_add(constraint.least.max(0)));
    let mut work = 0;
    loop {
        let mut changed = false;
        let mut relax = |constraint: &Constraint| {
            let time = times[constraint.from].saturating_add(constraint.least);
            changed |= time > times[constraint.to];
            times[constraint.to] = times[constraint.to].max(time);
        };
        all.iter().for_each(&mut relax);
        all.iter().rev().for_each(&mut relax);
        // The time of the start stays 0. No time needs more than all lower bounds together.
        if times[0] > 0 || times.iter().any(|&time| time > most) {
            return Ok(None);
        }
        if !changed {
            return Ok(Some(moments[1..].iter().map(|&moment| times[moment]).collect()));
        }
        work += 2 * all.len();
        if work > WORK {
            return Err(Error::new("the times of the trace need too long: give a shorter trace"));
        }
    }
}
