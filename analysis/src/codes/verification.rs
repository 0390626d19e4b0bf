//! What verification reports (`dotgen_timing` computes it, the editor shows it). It stands here so that
//! the manual and the configuration see one table.

use crate::codes::lints::LintCode;
use crate::diagnostic::Severity;

const fn code(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    example: &'static str,
    fix: &'static str,
) -> LintCode {
    LintCode {
        id,
        severity: Severity::Warning,
        on: true,
        absence: false,
        unnecessary: false,
        meaning,
        why,
        example,
        fix,
    }
}

/// All of them.
pub const CODES: &[LintCode] = &[
    code(
        "timing/deadline-miss",
        "a task that can miss its deadline: there is a run in which its next period begins before the job of the last one \
         has ended",
        "It is found by looking at every run of the timed model, with the locks, cores and clients of the scenario \
         (without one: any client, at any time). The related places are the last steps of such a run; *Show the timeline of \
         the run* shows all of it.",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield ether wcet 6 ms;\n  };\n};\n",
        "Make the codels that the task runs or waits for shorter, the period longer, or share less between tasks; more cores \
         help when the task waits for one. The what-if fields of the verification panel tell what would be enough.",
    ),
    code(
        "timing/response-exceeded",
        "a response time, or the time between two events, that can be longer than the bound a scenario asks for, or has \
         none",
        "The value given is exact: some run reaches it. Which run, the timeline shows.",
        "scenario s {\n  use \"c.gen\";\n  check response c.t <= 4 ms;\n}\n",
        "Raise the bound if it was only a guess; otherwise look in the timeline for what the task waits for.",
    ),
    code(
        "timing/check-failed",
        "a check of a scenario that does not hold",
        "There is a run that contradicts it (for `reachable`: no run that shows it).",
        "scenario s {\n  use \"c.gen\";\n  check always not c.t.start;\n}\n",
        "Look at the run in the timeline; change the specification, or the check if it asks for the wrong \
            thing.",
    ),
    LintCode {
        severity: Severity::Information,
        ..code(
            "timing/gave-up",
            "a check that was neither proved nor refuted within the limits",
            "A verification ends at a number of states, an amount of memory or a time, all of which are settings. What was \
             not found may still exist, and a value is then a lower bound.",
            "scenario s {\n  use \"large.gen\";\n  check schedulable *;\n}\n",
            "Raise `verification.max-states` or `verification.time-limit`, verify on the command line, which takes its time, \
             or make the scenario smaller: fewer requests, `loop once`, a coarser `unit`.",
        )
    },
    code(
        "timing-no-wcet",
        "codels that a verification takes to need no time, as they have no `wcet`",
        "What is proved then holds for codels that take no time, and real ones are later. It stands at the `use` of a scenario, \
         and is told by `dotgen verify`; `timing/missing-wcet` says it in the specification.",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield main wcet 10 us;\n    codel<main> g() yield pause::main;\n  };\n};\n",
        "Add `wcet` with the measured or estimated worst case, or a `duration` in the scenario.",
    ),
    code(
        "timing-state-cycle",
        "a cycle of states without `pause::` that a verification follows without limit",
        "Every turn may go round it any number of times, so response times have no bound. It stands in the scenario, and is told by \
         `dotgen verify`; `fsm/busy-loop` says it in the specification.",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield main;\n    codel<main> g() yield main, ether;\n  };\n};\n",
        "Yield `pause::main` where each round may wait for the next period, or limit the rounds with `loop` \
            in the scenario.",
    ),
    code(
        "timing-lock-queue",
        "a codel that keeps a task waiting in the lock queue with which it shares nothing, for longer than its \
         period",
        "The servers have one queue for all codels of a component. While its head waits for a codel that \
         executes, everybody behind it waits as well, whether or not they want the same data. It stands in the \
         scenario, and is told by `dotgen verify`.",
        "component c {\n  ids { long map; };\n  task slow { period 100 ms;\n    codel<start> plan(inout map) yield pause::start wcet 40 ms;\n  };\n  task look { period 100 ms;\n    codel<start> read(in map) yield pause::start wcet 1 ms;\n  };\n  task fast { period 10 ms;\n    codel<start> move() yield pause::start wcet 1 ms;\n  };\n};\n",
        "Let the long codel work on a `local` copy, and take the data it shares in a short one before and \
         after.",
    ),
    code(
        "timing-port-hold",
        "a codel that holds a port for longer than the period of a task of another component that uses it",
        "Where ports are locks, as in the published models (`ports lock;`), a codel has its ports from its \
         beginning to its end; meanwhile the task of the other component waits and misses a tick. It stands in \
         the scenario, and is told by `dotgen verify`.",
        "component c {\n  port out p::map map;\n  task plan { period 500 ms;\n    codel<start> plan(out map) yield pause::start wcet 180 ms;\n  };\n};\ncomponent d {\n  port in p::map map;\n  task move { period 50 ms;\n    codel<start> move(in map) yield pause::start wcet 1 ms;\n  };\n};\n",
        "Let the long codel work on a `local` copy, and write the port in a short one.",
    ),
    code(
        "timing-only-refused",
        "a request of a scenario that is refused every time, as what has to succeed before cannot",
        "A service that comes `after` others is refused until all of them have succeeded. Here no client requests one of them, or it \
         is refused itself, so a verification says nothing about the service. It stands in the scenario, and is \
         told by `dotgen verify`.",
        "component c {\n  task t { period 5 ms; };\n  function init() { };\n  function go() { after init; };\n};\n",
        "Let a client of the scenario request what has to come before, or write `order off;` in it.",
    ),
];
