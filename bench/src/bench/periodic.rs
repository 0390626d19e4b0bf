//! Plain periodic tasks on one core, non-preemptive, earliest deadline first: the same set written for
//! dotgen, for TChecker and for the schedule-abstraction tool.
//!
//! Every task is a component of its own whose only codel takes from `bcet` to `wcet`; start-up takes no time,
//! so the n-th release is at n periods. Where the semantics differ, the translation makes up for it:
//!
//! * Ticks, ends and grants of one moment come in every order (the core may go to a task while a more urgent
//!   one is about to tick). The schedule-abstraction tool grants the most urgent job of the moment. There a
//!   moment is [`SCALE`] units and a release may be one unit late, which allows the same orders.
//! * A job that ends at the next tick is late. There the deadline is one moment earlier.
//! * Equal deadlines are served in order of release. Both translations have it in the priority.
//! * That tool takes a finite list of jobs: all of two hyperperiods. Without a miss every hyperperiod ends
//!   with all jobs done, and all but the first begin with a release of every task, so the second stands for
//!   the others.
//!
//! For TChecker the deadlines are integers within the hyperperiod, as its abstractions do not allow
//! differences of clocks; and all timers have one clock together, which makes it three times faster than with
//! a clock each.

use std::fmt::Write;

/// Units of the schedule-abstraction tool per unit here.
pub(crate) const SCALE: u64 = 1000;

/// Times in ms.
#[derive(Clone, Copy)]
pub(crate) struct Task {
    pub(crate) period: u64,
    pub(crate) bcet: u64,
    pub(crate) wcet: u64,
}

/// Periods to choose from; all divide [`HYPERPERIOD`].
pub(crate) const PERIODS: [u64; 12] = [20, 24, 30, 40, 48, 60, 80, 120, 240, 16, 15, 12];
const HYPERPERIOD: u64 = 240;

/// Specification and scenario, with checks of the longest responses or only of the deadlines.
pub(crate) fn dotgen(tasks: &[Task], responses: bool) -> (String, String) {
    let mut genom = String::new();
    let mut scenario = String::from(
        "scenario periodic {\n  use \"periodic.gen\"; semantics published;\n  unit 1 ms;\n  cores 1;\n  policy edf;\n",
    );
    for (i, task) in tasks.iter().enumerate() {
        let Task { period, bcet, wcet } = task;
        let _ = writeln!(
            genom,
            "component c{i} {{
  version \"1.0\";
  lang \"c\";
  task t {{
    period {period} ms;
    codel<start> c{i}_start() yield pause::main wcet 0 ms;
    codel<main> c{i}_main() yield pause::main wcet {wcet} ms;
  }};
}};"
        );
        let _ = writeln!(scenario, "  duration c{i}.t.main [{bcet}, {wcet}] ms;");
    }
    scenario.push_str("  check schedulable *;\n");
    if responses {
        scenario.push_str("  check response *;\n");
    }
    scenario.push_str("}\n");
    (genom, scenario)
}

/// A network of two timed automata, the timers and the core, with a clock each. The label `miss` is reached
/// if a job is late.
pub(crate) fn tchecker(tasks: &[Task]) -> String {
    let mut out = format!(
        "system:periodic\nevent:tau\nclock:1:t\nclock:1:e\nint:1:0:{n}:0:due\nint:1:0:{n}:0:waiting\n",
        n = tasks.len()
    );
    for (i, Task { period, .. }) in tasks.iter().enumerate() {
        // A tick is due; the job is not done; which job it is; its deadline and release, while it waits.
        let _ = writeln!(
            out,
            "int:1:0:1:0:due{i}\nint:1:0:1:0:busy{i}\nint:1:0:{}:0:n{i}\nint:1:0:{NEVER}:{NEVER}:key{i}",
            HYPERPERIOD / period - 1
        );
    }
    timers(&mut out, tasks);
    core(&mut out, tasks);
    out
}

/// Greater than the key of any job: the task does not wait.
const NEVER: u64 = (2 * HYPERPERIOD + 1) * 1000;

/// Advances from one moment with ticks to the next, through one hyperperiod and again.
fn timers(out: &mut String, tasks: &[Task]) {
    let ticks = |at: &u64| tasks.iter().any(|task| at.is_multiple_of(task.period));
    let moments: Vec<u64> = (1..=HYPERPERIOD).filter(ticks).collect();
    out.push_str("process:T\n");
    let mut before = 0;
    for (k, &at) in moments.iter().enumerate() {
        let initial = if k == 0 { "initial: : " } else { "" };
        let gap = at - before;
        before = at;
        let _ = writeln!(
            out,
            "location:T:wait{k}{{{initial}invariant:t<={gap}}}\nlocation:T:tick{k}{{urgent:}}"
        );
    }
    before = 0;
    for (k, &at) in moments.iter().enumerate() {
        let due = (0..tasks.len()).filter(|&i| at.is_multiple_of(tasks[i].period));
        let due: Vec<String> = due.map(|i| format!("due{i}=1;")).collect();
        let _ = writeln!(
            out,
            "edge:T:wait{k}:tick{k}:tau{{provided:t=={} : do:{}due={};t=0}}
edge:T:tick{k}:wait{}:tau{{provided:due==0}}",
            at - before,
            due.concat(),
            due.len(),
            (k + 1) % moments.len()
        );
        before = at;
    }
}

/// Takes ticks, in any order, and runs jobs.
fn core(out: &mut String, tasks: &[Task]) {
    out.push_str(
        "process:C\nlocation:C:free{initial:}\nlocation:C:choose{urgent:}\nlocation:C:late{labels:miss}\n",
    );
    for (i, Task { wcet, .. }) in tasks.iter().enumerate() {
        let _ = writeln!(out, "location:C:run{i}{{invariant:e<={wcet}}}");
    }
    for (i, task) in tasks.iter().enumerate() {
        let Task { period, bcet, .. } = task;
        let mut first = format!("key{i}<{NEVER}");
        for j in (0..tasks.len()).filter(|&j| j != i) {
            let _ = write!(first, "&&key{i}<key{j}");
        }
        let _ = writeln!(
            out,
            "edge:C:choose:run{i}:tau{{provided:{first} : do:e=0;key{i}={NEVER};waiting=waiting-1}}
edge:C:run{i}:choose:tau{{provided:e>={bcet}&&waiting>0 : do:busy{i}=0;e=0}}
edge:C:run{i}:free:tau{{provided:e>={bcet}&&waiting==0 : do:busy{i}=0;e=0}}"
        );
        let jobs = HYPERPERIOD / period;
        let tick = format!(
            "due{i}=0;due=due-1;busy{i}=1;waiting=waiting+1;n{i}=(n{i}+1)%{jobs};\
             key{i}=(n{i}+1)*{period}*1000+n{i}*{period}"
        );
        let mut places = vec![("free".to_owned(), "choose".to_owned())];
        places.push(("choose".to_owned(), "choose".to_owned()));
        places.extend((0..tasks.len()).map(|j| (format!("run{j}"), format!("run{j}"))));
        for (from, to) in places {
            let _ = writeln!(
                out,
                "edge:C:{from}:{to}:tau{{provided:due{i}==1&&busy{i}==0 : do:{tick}}}
edge:C:{from}:late:tau{{provided:due{i}==1&&busy{i}==1}}"
            );
        }
    }
}

/// A list of jobs.
pub(crate) fn jobs(tasks: &[Task]) -> String {
    let mut out = String::from(
        "Task ID, Job ID, Arrival min, Arrival max, Cost min, Cost max, Deadline, Priority\n",
    );
    for (i, Task { period, bcet, wcet }) in tasks.iter().enumerate() {
        for n in 1..2 * HYPERPERIOD / period {
            let release = n * period;
            let deadline = release + period;
            let _ = writeln!(
                out,
                "{}, {n}, {}, {}, {}, {}, {}, {}",
                i + 1,
                release * SCALE,
                release * SCALE + 1,
                bcet * SCALE,
                wcet * SCALE,
                deadline * SCALE - 1,
                deadline * 1000 + release,
            );
        }
    }
    out
}
