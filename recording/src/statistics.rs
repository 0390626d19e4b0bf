//! Statistics of a log, number by number as `profundis -s` prints them.
//!
//! Each line counts three times: for its task, for its service in that task, and for the state in that
//! service. Of the lines of a group with equal first times only the last one counts. A codel has an execution
//! time. A cycle is the time between two beginnings. For a service, it lasts from a run that starts a cycle
//! (from `start`, or the first run after a pause) to the next such run. For tasks, for states, and for
//! services without such a pair, it lasts from each run to the next.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::log::{LineKinds, LineSubject, SkippedLines, line, origin};
use crate::matching::event;

/// Number, least, greatest and mean time with the standard deviation, in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Times {
    /// Number of times.
    pub count: u64,
    /// Least time.
    pub least: i64,
    /// Greatest time.
    pub greatest: i64,
    /// Mean, rounded towards zero.
    pub mean: i64,
    /// Standard deviation, rounded towards zero.
    pub deviation: i64,
}

/// A transition between two events, with its count.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Transition {
    /// Event before the run.
    pub from: String,
    /// Event after the run.
    pub to: String,
    /// Number of runs.
    pub count: u64,
}

/// A task, a service of a task, or a state of a service.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Group {
    /// Instance and task; service; state (the event before the run).
    pub key: Vec<String>,
    /// The function, for a state.
    pub function: Option<String>,
    /// Times from the grant of locks to their release.
    pub execution: Times,
    /// Times from beginning to beginning; `None` if there is only one run.
    pub cycle: Option<Times>,
    /// Transitions, in order of first appearance.
    pub transitions: Vec<Transition>,
}

/// The effect of a run on the cycles of its service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cycle {
    No,
    /// The run is the first one of an activity: no cycle has ended.
    First,
    /// One cycle has ended, and the next one begins.
    Next,
}

/// A line, in little memory: a log has millions of them.
#[derive(Debug, Clone, Copy)]
struct Entry {
    asked: i64,
    began: i64,
    ended: i64,
    kind: u32,
    cycle: Cycle,
}

#[derive(Debug, Default)]
struct TaskLines {
    entries: Vec<Entry>,
    /// Lines were added since the last sorting.
    fresh: bool,
}

/// The groups of the lines of a kind.
#[derive(Debug, Clone, Copy)]
struct KindGroups {
    task: usize,
    /// For task, service and state: the group, and the index of the kind in the group.
    groups: [(usize, usize); 3],
    /// The lines start an activity.
    starts: bool,
    /// The lines pause an activity.
    pauses: bool,
}

/// Collects the lines of one file or of several.
#[derive(Debug, Default)]
pub struct Collector {
    /// Lines that other readers of logs skip. Here they count.
    pub left: SkippedLines,
    kinds: LineKinds,
    /// Groups, by kind; `None` for lines that do not belong to a log.
    belongs: Vec<Option<KindGroups>>,
    known: FxHashMap<Vec<String>, usize>,
    keys: Vec<Vec<String>>,
    /// Kinds, by group.
    kinds_of: Vec<Vec<u32>>,
    tasks: Vec<TaskLines>,
    /// Tasks, by group of a task.
    task_of: FxHashMap<usize, usize>,
}

impl Collector {
    /// Reads a line of a file. `ended`: the line has its line break. Lines that do not belong to a log are
    /// skipped. Cut lines count, with empty names, as in `profundis`.
    pub fn line(&mut self, text: &[u8], ended: bool) {
        let Some(line) = line(text) else {
            if origin(text).is_some() {
                return;
            }
            self.left.garbage += u64::from(!text.trim_ascii().is_empty());
            return;
        };
        let (kind, about) = self.kinds.of(&line);
        self.left.count(&line, about, ended);
        while self.belongs.len() <= kind as usize {
            let of = self.belongs(self.belongs.len());
            self.belongs.push(of);
        }
        let Some(Some(belongs)) = self.belongs.get(kind as usize) else {
            return;
        };
        if let Some(task) = self.tasks.get_mut(belongs.task) {
            task.fresh = true;
            task.entries.push(Entry {
                asked: line.asked,
                began: line.began,
                ended: line.ended,
                cycle: Cycle::No,
                kind,
            });
        }
    }

    fn belongs(&mut self, kind: usize) -> Option<KindGroups> {
        let entry = self.kinds.all.get(kind)?;
        if self.kinds.about(kind) == LineSubject::Garbage {
            return None;
        }
        let (starts, pauses) = (entry.from.ends_with("::start"), entry.to.contains("::pause::"));
        let names = [&entry.instance, &entry.task, &entry.service, &entry.from];
        let names: Vec<String> = names.into_iter().cloned().collect();
        // A Tcl list that begins with an empty name is shorter by this name.
        let start = usize::from(entry.instance.is_empty());
        let groups = [2, 3, 4].map(|length| {
            let key = names.get(start..length).unwrap_or_default().to_vec();
            let next = self.keys.len();
            let group = *self.known.entry(key.clone()).or_insert_with(|| {
                self.keys.push(key);
                self.kinds_of.push(Vec::new());
                next
            });
            let kinds = self.kinds_of.get_mut(group);
            let place = kinds.map_or(0, |count| {
                count.push(kind as u32);
                count.len() - 1
            });
            (group, place)
        });
        let [(group, _), ..] = groups;
        let next = self.tasks.len();
        let task = *self.task_of.entry(group).or_insert(next);
        if task == next {
            self.tasks.push(TaskLines::default());
        }
        Some(KindGroups { task, groups, starts, pauses })
    }

    /// Ends a file: its lines are sorted among those of earlier files.
    pub fn file_ended(&mut self) {
        let (belongs, keys) = (&self.belongs, &self.keys);
        let of = |entry: &Entry| belongs.get(entry.kind as usize).copied().flatten();
        // By group: the last line, and whether the line before it paused.
        let mut last: Vec<Option<(usize, bool)>> = vec![None; keys.len()];
        for task in self.tasks.iter_mut().filter(|task| task.fresh) {
            task.fresh = false;
            task.entries.sort_by_key(|entry| entry.asked);
            for place in 0..task.entries.len() {
                let Some(now) = task.entries.get(place).copied() else {
                    continue;
                };
                let Some(belongs) = of(&now) else { continue };
                // Cycles belong to keys with three words.
                for (group, _) in belongs.groups {
                    if keys.get(group).is_none_or(|key| key.len() != 3) {
                        continue;
                    }
                    let Some(last) = last.get_mut(group) else {
                        continue;
                    };
                    let before = last.and_then(|(entry, at)| Some((task.entries.get(entry)?, at)));
                    let paused = match before {
                        None => false,
                        // Of equal lines the last one counts: it replaces the previous one.
                        Some((before, paused)) if before.asked == now.asked => paused,
                        Some((before, _)) => of(before).is_some_and(|groups| groups.pauses),
                    };
                    *last = Some((place, paused));
                    let mark = match (belongs.starts, paused) {
                        (true, _) => Cycle::First,
                        (false, true) => Cycle::Next,
                        // A mark of an earlier file is kept, as in `profundis`.
                        (false, false) => continue,
                    };
                    if let Some(entry) = task.entries.get_mut(place) {
                        entry.cycle = mark;
                    }
                }
            }
        }
    }

    /// Returns the groups, in the order in which `profundis` prints them.
    pub fn groups_in_order(&self) -> Vec<Group> {
        let mut sums: Vec<GroupSums> = (self.kinds_of.iter().zip(&self.keys))
            .map(|(kinds, key)| GroupSums {
                counts: vec![0; kinds.len()],
                has_cycles: key.len() == 3,
                ..GroupSums::default()
            })
            .collect();
        for task in &self.tasks {
            for entry in &task.entries {
                let belongs = self.belongs.get(entry.kind as usize).copied().flatten();
                let Some(belongs) = belongs else { continue };
                for (group, place) in belongs.groups {
                    if let Some(sum) = sums.get_mut(group) {
                        sum.next(*entry, place);
                    }
                }
            }
        }
        let mut groups = Vec::new();
        for ((key, kinds), mut sum) in self.keys.iter().zip(&self.kinds_of).zip(sums) {
            sum.flush();
            groups.push((list(key), self.group(key, kinds, &sum)));
        }
        groups.sort_by(|a, b| a.0.cmp(&b.0));
        groups.into_iter().map(|group| group.1).collect()
    }

    fn group(&self, key: &[String], kinds: &[u32], sum: &GroupSums) -> Group {
        let kind = |place: usize| {
            let number = kinds.get(place).copied()?;
            self.kinds.all.get(number as usize)
        };
        // Several kinds of lines can have the same events. They are grouped by the event before the run, in
        // order of its first appearance.
        let mut transitions: Vec<Transition> = Vec::new();
        let mut froms: FxHashMap<&str, usize> = FxHashMap::default();
        let mut places: Vec<usize> = Vec::new();
        for &place in &sum.order {
            let Some(of) = kind(place) else { continue };
            let count = sum.counts.get(place).copied().unwrap_or(0);
            let same =
                |transition: &&mut Transition| transition.from == of.from && transition.to == of.to;
            if let Some(known) = transitions.iter_mut().find(same) {
                known.count += count;
                continue;
            }
            let next = froms.len();
            places.push(*froms.entry(&of.from).or_insert(next));
            transitions.push(Transition { from: of.from.clone(), to: of.to.clone(), count });
        }
        let mut placed: Vec<_> = places.into_iter().zip(transitions).collect();
        placed.sort_by_key(|(place, _)| *place);
        let first = sum.order.first().and_then(|&order| kind(order));
        let first = first.filter(|_| key.len() == 4);
        Group {
            key: key.to_vec(),
            function: first.map(|kind| kind.function.clone()),
            execution: sum.execution.times().unwrap_or(Times {
                count: 0,
                least: 0,
                greatest: 0,
                mean: 0,
                deviation: 0,
            }),
            cycle: sum.cycles.times().or(sum.periods.times()),
            transitions: placed.into_iter().map(|(_, transition)| transition).collect(),
        }
    }
}

#[derive(Debug, Default)]
struct GroupSums {
    /// Last line, and the index of its kind. A later line with the same time may replace it.
    pending: Option<(Entry, usize)>,
    has_cycles: bool,
    execution: Sum,
    cycles: Sum,
    periods: Sum,
    before: Option<i64>,
    start: Option<i64>,
    /// Counts, by index of the kind.
    counts: Vec<u64>,
    /// Indices of kinds, in order of first appearance.
    order: Vec<usize>,
}

impl GroupSums {
    fn next(&mut self, entry: Entry, place: usize) {
        if self.pending.is_some_and(|(last, _)| last.asked != entry.asked) {
            self.flush();
        }
        self.pending = Some((entry, place));
    }

    fn flush(&mut self) {
        let Some((run, place)) = self.pending.take() else {
            return;
        };
        let cycle = if self.has_cycles { run.cycle } else { Cycle::No };
        self.execution.add(run.ended - run.began);
        if let Some(count) = self.counts.get_mut(place) {
            if *count == 0 {
                self.order.push(place);
            }
            *count += 1;
        }
        match (self.start, self.before) {
            (Some(start), _) if cycle == Cycle::Next => self.cycles.add(run.began - start),
            (_, Some(before)) if self.cycles.count == 0 => self.periods.add(run.began - before),
            _ => {}
        }
        self.before = Some(run.began);
        if cycle != Cycle::No {
            self.start = Some(run.began);
        }
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
        // After steps of the clock, the square of a sum may overflow.
        let square = match self.sum.checked_mul(self.sum) {
            Some(number) => number as f64,
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

/// Returns the lines of a machine-readable `.sum` file: `exec`, `cycle` and `trans`.
pub fn lines(groups: &[Group]) -> String {
    let mut out = String::new();
    out.push_str("# exec instance task service state codel count min max avg std\n");
    for group in groups {
        out.push_str(&of_times("exec", group, &group.execution));
    }
    out.push_str("\n# cycle instance task service state codel count min max avg std\n");
    for group in groups {
        if let Some(cycle) = &group.cycle {
            out.push_str(&of_times("cycle", group, cycle));
        }
    }
    out.push_str("\n# trans instance task service state codel from to count/total\n");
    for group in groups {
        for edge in &group.transitions {
            let Transition { from, to, count } = edge;
            let total = group.execution.count;
            let (key, function) = (group_key(group), function(group));
            out.push_str(&format!("trans {key} {function} {from} {to} {count}/{total}\n"));
        }
    }
    out
}

fn of_times(word: &str, group: &Group, times: &Times) -> String {
    let [least, greatest, mean, deviation] =
        [times.least, times.greatest, times.mean, times.deviation].map(seconds);
    let (key, function, count) = (group_key(group), function(group), times.count);
    format!("{word} {key} {function} {count} {least} {greatest} {mean} {deviation}\n")
}

fn function(group: &Group) -> &str {
    group.function.as_deref().unwrap_or("*")
}

/// Returns a key with two stars behind it, of four words at most.
fn group_key(group: &Group) -> String {
    let mut key = group.key.clone();
    key.extend(["*".to_owned(), "*".to_owned()]);
    key.truncate(4);
    list(&key)
}

/// Returns words as a Tcl list: a text that would not be one word gets braces.
fn list(words: &[String]) -> String {
    let special = |character: char| character.is_whitespace() || "{}\"[]$;\\".contains(character);
    let words = words.iter().map(|word| {
        if word.is_empty() || word.contains(special) { format!("{{{word}}}") } else { word.clone() }
    });
    words.collect::<Vec<_>>().join(" ")
}

/// Returns seconds with nine digits. The fraction is never negative: -0.1 is -1 + 0.9.
fn seconds(nanos: i64) -> String {
    let second = 1_000_000_000;
    format!("{}.{:09}", nanos.div_euclid(second), nanos.rem_euclid(second))
}

#[cfg(test)]
mod tests;

/// Returns the longest execution time of each function, in seconds: the file of worst cases that templates of
/// formal models read (`NAME.wcet`).
pub fn worst_cases(groups: &[Group]) -> String {
    let mut longest: BTreeMap<&str, i64> = BTreeMap::new();
    for group in groups {
        if let Some(function) = group.function.as_deref().filter(|name| !name.is_empty()) {
            let known = longest.entry(function).or_default();
            *known = group.execution.greatest.max(*known);
        }
    }
    let mut out = String::new();
    for (function, nanos) in longest {
        let (seconds, rest) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
        let fraction = format!("{rest:09}");
        let fraction = fraction.trim_end_matches('0');
        let fraction = if fraction.is_empty() { "0" } else { fraction };
        out += &format!("{function} {seconds}.{fraction}\n");
    }
    out
}

/// Returns how often each codel took each of its yields, one transition a line, as the template of UPPAAL-SMC
/// reads it (`all.proba`): `OWNER::COMPONENT_STATE::COMPONENT_[pause_]STATE COUNT`. Codels of control tasks
/// are left out, since they take no transition.
pub fn transition_counts(groups: &[Group]) -> String {
    let name = |text: &str| {
        let event = event(text);
        let pause = if event.paused { "pause_" } else { "" };
        event.component.map(|component| format!("{component}_{pause}{}", event.name))
    };
    let mut out = String::new();
    for group in groups {
        let [_, task, service, _] = &group.key[..] else { continue };
        // No service has a name like that of a permanent activity.
        let is_service = service.starts_with(|first: char| first.is_alphabetic() || first == '_');
        let owner = if is_service { service } else { task };
        for transition in &group.transitions {
            if let (Some(from), Some(to)) = (name(&transition.from), name(&transition.to)) {
                out += &format!("{owner}::{from}::{to} {}\n", transition.count);
            }
        }
    }
    out
}
