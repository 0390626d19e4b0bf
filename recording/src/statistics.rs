//! Statistics of a log: those that `profundis -s` prints, number by number.
//!
//! There are three for each line: of its task, of its service in that task, and of the state in that service.
//! Of lines of one group that have the same first time only the last one counts. A codel has a time of
//! execution; a cycle is the time between two beginnings: of a service, from a run that starts a
//! cycle (from `start`, or the first after a pause) to the next such run; where there is no such pair, and for tasks and
//! states, from each run to the next.

use rustc_hash::FxHashMap;

use crate::log::{Kinds, Run, line};

/// Least, greatest and mean time with the deviation from that, in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Times {
    /// How often.
    pub count: u64,
    /// The least.
    pub least: i64,
    /// The greatest.
    pub greatest: i64,
    /// Their mean, towards zero.
    pub mean: i64,
    /// Standard deviation, towards zero.
    pub deviation: i64,
}

/// How often something led from an event to another.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Transition {
    /// The event from which.
    pub from: String,
    /// The event to which.
    pub to: String,
    /// How often.
    pub count: u64,
}

/// A task, a service of a task, or a state of a service.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Group {
    /// Instance and task; service; state (the event from which).
    pub key: Vec<String>,
    /// The function, for a state.
    pub function: Option<String>,
    /// From getting the locks to releasing them.
    pub execution: Times,
    /// From beginning to beginning; `None` where there is one only.
    pub cycle: Option<Times>,
    /// In order of first appearance.
    pub transitions: Vec<Transition>,
}

/// Whether a run starts a cycle of its service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cycle {
    No,
    /// It is the first of an activity: no cycle has ended.
    First,
    /// One has ended, and the next begins.
    Next,
}

#[derive(Debug, Default)]
struct Entries {
    runs: Vec<(Run, CycleMark)>,
    /// There is something new since the last sorting.
    fresh: bool,
}

type CycleMark = Cycle;

/// Collects the lines of one file or of several.
#[derive(Debug, Default)]
pub struct Collector {
    kinds: Kinds,
    /// For each kind, its groups: task, service, state.
    groups_of: Vec<[usize; 3]>,
    known: FxHashMap<Vec<String>, usize>,
    keys: Vec<Vec<String>>,
    entries: Vec<Entries>,
}

impl Collector {
    /// A line of a file. Lines that are none of a log do not count; cut ones do, with empty names, as for `profundis`.
    pub fn line(&mut self, text: &[u8]) {
        let Some(line) = line(text) else { return };
        let kind = self.kinds.of(&line);
        let index = kind as usize;
        if index >= self.groups_of.len() {
            let groups = self.groups(index);
            self.groups_of.push(groups);
        }
        let run = Run {
            asked: line.asked,
            began: line.began,
            ended: line.ended,
            kind,
        };
        for group in self.groups_of.get(index).copied().unwrap_or_default() {
            if let Some(entries) = self.entries.get_mut(group) {
                entries.runs.push((run, Cycle::No));
                entries.fresh = true;
            }
        }
    }

    fn groups(&mut self, kind: usize) -> [usize; 3] {
        let Some(kind) = self.kinds.all.get(kind) else {
            return [0; 3];
        };
        let names = [&kind.instance, &kind.task, &kind.service, &kind.from];
        let names: Vec<String> = names.into_iter().cloned().collect();
        [2, 3, 4].map(|length| {
            let key = names[..length].to_vec();
            let next = self.keys.len();
            *self.known.entry(key.clone()).or_insert_with(|| {
                self.keys.push(key);
                self.entries.push(Entries::default());
                next
            })
        })
    }

    /// A file has ended: its lines are put in order among those of the files before.
    pub fn file_ended(&mut self) {
        for (key, entries) in self.keys.iter().zip(&mut self.entries) {
            if !std::mem::take(&mut entries.fresh) {
                continue;
            }
            entries.runs.sort_by_key(|it| it.0.asked);
            // Of equal ones the last stays.
            entries.runs.reverse();
            entries.runs.dedup_by_key(|it| it.0.asked);
            entries.runs.reverse();
            if key.len() == 3 {
                mark_cycles(&self.kinds, &mut entries.runs);
            }
        }
    }

    /// The groups, in the order in which `profundis` prints them.
    pub fn groups_in_order(&self) -> Vec<Group> {
        let mut groups: Vec<(String, Group)> = (self.keys.iter().zip(&self.entries))
            .map(|(key, entries)| (list(key), self.group(key, &entries.runs)))
            .collect();
        groups.sort_by(|a, b| a.0.cmp(&b.0));
        groups.into_iter().map(|it| it.1).collect()
    }

    fn group(&self, key: &[String], runs: &[(Run, Cycle)]) -> Group {
        let kind = |it: &Run| self.kinds.all.get(it.kind as usize);
        let mut execution = Sum::default();
        let (mut cycles, mut periods) = (Sum::default(), Sum::default());
        let (mut before, mut start) = (None, None);
        let mut counts: Vec<u64> = vec![0; self.kinds.all.len()];
        let mut order: Vec<u32> = Vec::new();
        for (run, cycle) in runs {
            execution.add(run.ended - run.began);
            if let Some(count) = counts.get_mut(run.kind as usize) {
                if *count == 0 {
                    order.push(run.kind);
                }
                *count += 1;
            }
            match (start, before) {
                (Some(start), _) if *cycle == Cycle::Next => cycles.add(run.began - start),
                (_, Some(before)) if cycles.count == 0 => periods.add(run.began - before),
                _ => {}
            }
            before = Some(run.began);
            if *cycle != Cycle::No {
                start = Some(run.began);
            }
        }
        // Several kinds of lines can have the same events. They stand together by the event from which, in order
        // of its first appearance.
        let mut transitions: Vec<Transition> = Vec::new();
        let mut froms: FxHashMap<&str, usize> = FxHashMap::default();
        let mut places: Vec<usize> = Vec::new();
        for number in order {
            let Some(of) = self.kinds.all.get(number as usize) else {
                continue;
            };
            let count = counts.get(number as usize).copied().unwrap_or(0);
            let same = |it: &&mut Transition| it.from == of.from && it.to == of.to;
            if let Some(known) = transitions.iter_mut().find(same) {
                known.count += count;
                continue;
            }
            let next = froms.len();
            places.push(*froms.entry(&of.from).or_insert(next));
            transitions.push(Transition {
                from: of.from.clone(),
                to: of.to.clone(),
                count,
            });
        }
        let mut placed: Vec<_> = places.into_iter().zip(transitions).collect();
        placed.sort_by_key(|it| it.0);
        let first = runs.first().and_then(|it| kind(&it.0));
        Group {
            key: key.to_vec(),
            function: first
                .filter(|_| key.len() == 4)
                .map(|it| it.function.clone()),
            execution: execution.times().unwrap_or(Times {
                count: 0,
                least: 0,
                greatest: 0,
                mean: 0,
                deviation: 0,
            }),
            cycle: cycles.times().or(periods.times()),
            transitions: placed.into_iter().map(|it| it.1).collect(),
        }
    }
}

fn mark_cycles(kinds: &Kinds, runs: &mut [(Run, Cycle)]) {
    let starts: Vec<bool> = kinds
        .all
        .iter()
        .map(|it| it.from.ends_with("::start"))
        .collect();
    let pauses: Vec<bool> = kinds
        .all
        .iter()
        .map(|it| it.to.contains("::pause::"))
        .collect();
    let is = |all: &[bool], run: &Run| all.get(run.kind as usize).copied().unwrap_or(false);
    let mut paused = false;
    for (run, cycle) in runs {
        if is(&starts, run) {
            *cycle = Cycle::First;
        } else if paused {
            *cycle = Cycle::Next;
        }
        // A mark of an earlier file stays, as it does there.
        paused = is(&pauses, run);
    }
}

#[derive(Debug, Default)]
struct Sum {
    count: u64,
    least: i64,
    greatest: i64,
    sum: i128,
    squares: i128,
}

impl Sum {
    fn add(&mut self, time: i64) {
        if self.count == 0 {
            (self.least, self.greatest) = (time, time);
        }
        self.least = self.least.min(time);
        self.greatest = self.greatest.max(time);
        self.count += 1;
        let time = i128::from(time);
        self.sum += time;
        self.squares = self.squares.saturating_add(time * time);
    }

    fn times(&self) -> Option<Times> {
        if self.count == 0 {
            return None;
        }
        let count = self.count as f64;
        let mean = self.sum as f64 / count;
        // The square of a sum over steps of the clock may be beyond what integers hold.
        let square = match self.sum.checked_mul(self.sum) {
            Some(it) => it as f64,
            None => self.sum as f64 * self.sum as f64,
        };
        let variance = (self.squares as f64 - square / count) / count;
        Some(Times {
            count: self.count,
            least: self.least,
            greatest: self.greatest,
            mean: mean as i64,
            deviation: variance.max(0.0).sqrt() as i64,
        })
    }
}

/// The lines of a `.sum` file, which are for programs: `exec`, `cycle` and `trans`.
pub fn lines(groups: &[Group]) -> String {
    let mut out = String::new();
    out.push_str("# exec instance task service state codel count min max avg std\n");
    for it in groups {
        out.push_str(&of_times("exec", it, &it.execution));
    }
    out.push_str("\n# cycle instance task service state codel count min max avg std\n");
    for it in groups {
        if let Some(cycle) = &it.cycle {
            out.push_str(&of_times("cycle", it, cycle));
        }
    }
    out.push_str("\n# trans instance task service state codel from to count/total\n");
    for it in groups {
        for edge in &it.transitions {
            let Transition { from, to, count } = edge;
            let total = it.execution.count;
            let (key, function) = (starred(it), function(it));
            out.push_str(&format!(
                "trans {key} {function} {from} {to} {count}/{total}\n"
            ));
        }
    }
    out
}

fn of_times(word: &str, group: &Group, times: &Times) -> String {
    let [least, greatest, mean, deviation] =
        [times.least, times.greatest, times.mean, times.deviation].map(seconds);
    let (key, function, count) = (starred(group), function(group), times.count);
    format!("{word} {key} {function} {count} {least} {greatest} {mean} {deviation}\n")
}

fn function(group: &Group) -> &str {
    group.function.as_deref().unwrap_or("*")
}

/// A key of four words.
fn starred(group: &Group) -> String {
    let mut key = group.key.clone();
    key.resize(4, "*".to_owned());
    list(&key)
}

/// Words as a list of Tcl: what would not be one word stands in braces.
fn list(words: &[String]) -> String {
    let special = |it: char| it.is_whitespace() || "{}\"[]$;\\".contains(it);
    let words = words
        .iter()
        .map(|it| match it.is_empty() || it.contains(special) {
            true => format!("{{{it}}}"),
            false => it.clone(),
        });
    words.collect::<Vec<_>>().join(" ")
}

/// Seconds with nine digits. The fraction is never negative: -0.1 is -1 + 0.9.
fn seconds(nanos: i64) -> String {
    let second = 1_000_000_000;
    format!(
        "{}.{:09}",
        nanos.div_euclid(second),
        nanos.rem_euclid(second)
    )
}
