//! Plain periodic tasks on one core, non-preemptive, earliest deadline first: the same set written for dotgen, for
//! TChecker and for the schedule-abstraction tool.
//!
//! Every task is a component of its own whose only codel takes from `bcet` to `wcet`; start-up takes no time, so the
//! n-th release is at n periods. Where the semantics differ, the translation makes up for it:
//!
//! * Ticks, ends and grants of one moment come in every order (the core may go to a task while a more urgent one is
//!   about to tick). The schedule-abstraction tool grants the most urgent job of the moment. There a moment is
//!   [`SCALE`] units and a release may be one unit late, which allows the same orders.
//! * A job that ends at the next tick is late. There the deadline is one moment earlier.
//! * Equal deadlines are served in order of release. Both translations have it in the priority.
//! * That tool takes a finite list of jobs: all of two hyperperiods. Without a miss every hyperperiod ends with all jobs
//!   done, and all but the first begin with a release of every task, so the second stands for the others.
//!
//! In TChecker the timers are clocks, and deadlines are integers of the hyperperiod: without clock differences, which
//! its abstractions do not allow.

use std::fmt::Write;

/// Units of the schedule-abstraction tool in one of ours.
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

/// Specification and scenario; with the longest responses, or whether deadlines are kept alone.
pub(crate) fn dotgen(tasks: &[Task], responses: bool) -> (String, String) {
    let mut genom = String::new();
    let mut scenario = String::from(
        "scenario periodic {\n  use \"periodic.gen\";\n  unit 1 ms;\n  cores 1;\n  policy edf;\n",
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

/// A network of timed automata: a timer per task, and the core. The label `miss` is reached when a job is late.
pub(crate) fn tchecker(tasks: &[Task]) -> String {
    // Greater than any deadline: the task does not wait.
    let never = (2 * HYPERPERIOD + 1) * 1000;
    let mut out = String::from("system:periodic\nevent:tau\n");
    for i in 0..tasks.len() {
        let _ = writeln!(out, "event:tick{i}");
    }
    let _ = writeln!(out, "clock:1:e\nint:1:0:{}:0:waiting", tasks.len());
    for (i, Task { period, .. }) in tasks.iter().enumerate() {
        let jobs = HYPERPERIOD / period;
        let _ = writeln!(
            out,
            "clock:1:x{i}\nint:1:0:{}:0:n{i}\nint:1:0:1:0:busy{i}\nint:1:0:{never}:{never}:key{i}",
            jobs - 1
        );
        // The key is the deadline, then the release.
        let _ = writeln!(
            out,
            "process:T{i}
location:T{i}:on{{initial: : invariant:x{i}<={period}}}
location:T{i}:late{{labels:miss}}
edge:T{i}:on:on:tick{i}{{provided:x{i}=={period}&&busy{i}==0 : do:x{i}=0;n{i}=(n{i}+1)%{jobs};\
             key{i}=(n{i}+1)*{period}*1000+n{i}*{period};busy{i}=1;waiting=waiting+1}}
edge:T{i}:on:late:tick{i}{{provided:x{i}=={period}&&busy{i}==1}}"
        );
    }
    out.push_str("process:C\nlocation:C:free{initial:}\nlocation:C:choose{urgent:}\n");
    for (i, Task { bcet, wcet, .. }) in tasks.iter().enumerate() {
        let _ = writeln!(out, "location:C:run{i}{{invariant:e<={wcet}}}");
        let mut first = format!("busy{i}==1&&key{i}<{never}");
        for j in (0..tasks.len()).filter(|&j| j != i) {
            let _ = write!(first, "&&key{i}<key{j}");
        }
        let _ = writeln!(
            out,
            "edge:C:choose:run{i}:tau{{provided:{first} : do:e=0;key{i}={never};waiting=waiting-1}}
edge:C:run{i}:choose:tau{{provided:e>={bcet}&&waiting>0 : do:busy{i}=0;e=0}}
edge:C:run{i}:free:tau{{provided:e>={bcet}&&waiting==0 : do:busy{i}=0;e=0}}"
        );
    }
    for i in 0..tasks.len() {
        let _ = writeln!(
            out,
            "edge:C:free:choose:tick{i}\nedge:C:choose:choose:tick{i}"
        );
        for j in 0..tasks.len() {
            let _ = writeln!(out, "edge:C:run{j}:run{j}:tick{i}");
        }
        let _ = writeln!(out, "sync:T{i}@tick{i}:C@tick{i}");
    }
    out
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
