//! The findings of verification. `dotgen_timing` computes them and the editor shows them; they are listed
//! here so that the manual and the configuration have one table.

use crate::codes::lints::LintCode;
use crate::diagnostic::Severity;

const fn code(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    example: &'static str,
    corrected: &'static str,
    fix: &'static str,
) -> LintCode {
    LintCode {
        id,
        severity: Severity::Warning,
        on: true,
        absence: false,
        unnecessary: false,
        follows: &[],
        meaning,
        why,
        example,
        corrected,
        fix,
    }
}

/// All verification codes.
pub const CODES: &[LintCode] = &[
    code(
        "timing/deadline-miss",
        "A task can miss its deadline: in some run, its next period begins before the job of the last one has ended.",
        "Verification explores all runs of the timed model, with the locks, cores and clients of the \
         scenario. Without a scenario, any client requests anything at any time. The related places are the \
         last steps of a run that misses the deadline. *Step through the run that shows it* shows the whole run.",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield ether wcet 6 ms;\n  };\n};\n",
        "component c {\n  task t { period 8 ms;\n    codel<start> f() yield ether wcet 6 ms;\n  };\n};\n",
        "Shorten the codels that the task runs or waits for, lengthen the period, or share less data between tasks. \
         More cores help if the task waits for one. The what-if fields of the verification panel show what would be \
         enough.",
    ),
    code(
        "timing/response-exceeded",
        "A response time, or the time between two events, can be longer than the bound of the scenario, or has no \
         bound.",
        "The reported value is exact: some run reaches it. Its trace shows that run.",
        "scenario s {\n  use \"c.gen\";\n  check response c.t <= 4 ms;\n}\n",
        "scenario s {\n  use \"c.gen\";\n  check response c.t <= 8 ms;\n}\n",
        "If the bound was a guess, raise it. Otherwise look in the trace for the codels that the task \
         waits for.",
    ),
    code(
        "timing/check-failed",
        "A check of a scenario does not hold.",
        "Some run contradicts the check. For `reachable`, no run shows the state.",
        "scenario s {\n  use \"c.gen\";\n  check always not c.t.start;\n}\n",
        "",
        "Step through the run. Change the specification, or the check if it asks for the wrong thing.",
    ),
    code(
        "timing/vacuous-proof",
        "A check holds only because what it is about never happens.",
        "A task that is never released misses no deadline, and a predicate that never becomes true needs no answer. \
         Such a proof says nothing about the robot.",
        "scenario s {\n  use \"c.gen\";\n  cores 1;\n  policy fifo;\n  check schedulable *;\n}\n",
        "",
        "Read the reason. A start-up that never completes waits for a core, a lock or a codel that goes round \
         without `pause::`.",
    ),
    LintCode {
        severity: Severity::Information,
        ..code(
            "timing/gave-up",
            "A check was neither proved nor refuted within the limits.",
            "Verification stops at a limit of states, memory or time. Runs that were not explored can still \
             violate the check, and a reported value is only a lower bound.",
            "scenario s {\n  use \"large.gen\";\n  check schedulable *;\n}\n",
            "scenario s {\n  use \"large.gen\";\n  loop once;\n  check schedulable *;\n}\n",
            "Raise `verification.max-states` or `verification.time-limit`, or verify on the command line. Or make \
             the scenario smaller: fewer requests, `loop once`, a coarser `unit`.",
        )
    },
    code(
        "timing-no-wcet",
        "Verification counts codels without `wcet` as taking no time.",
        "A proof then holds only for codels that take no time. Real codels end later. The warning is shown \
         at the `use` of a scenario and in the output of `dotgen verify`. In the specification, \
         `timing/missing-wcet` reports it.",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield main wcet 10 us;\n    codel<main> g() yield pause::main;\n  };\n};\n",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield main wcet 10 us;\n    codel<main> g() yield pause::main wcet 20 us;\n  };\n};\n",
        "Add `wcet` with the measured or estimated worst case, or a `duration` in the scenario.",
    ),
    code(
        "timing-state-cycle",
        "A cycle of states has no `pause::`, and verification follows it without a limit.",
        "In each turn, the machine can repeat the cycle any number of times, so response times have no \
         bound. The warning is shown in the scenario and in the output of `dotgen verify`. In the \
         specification, `fsm/busy-loop` reports it.",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield main;\n    codel<main> g() yield main, ether;\n  };\n};\n",
        "component c {\n  task t { period 5 ms;\n    codel<start> f() yield main;\n    codel<main> g() yield pause::main, ether;\n  };\n};\n",
        "Yield `pause::main` if each round may wait for the next period, or limit the rounds with `loop` in the \
         scenario.",
    ),
    code(
        "timing-lock-queue",
        "A codel keeps a task waiting in the lock queue for longer than the task's period, although the two share no \
         data.",
        "The servers have one lock queue for all codels of a component. While its head waits for a codel \
         that executes, all codels behind it wait as well, even for other data. The warning is shown in the \
         scenario and in the output of `dotgen verify`.",
        "component c {\n  ids { long map; };\n  task slow { period 100 ms;\n    codel<start> plan(inout map) yield pause::start wcet 40 ms;\n  };\n  task look { period 100 ms;\n    codel<start> read(in map) yield pause::start wcet 1 ms;\n  };\n  task fast { period 10 ms;\n    codel<start> move() yield pause::start wcet 1 ms;\n  };\n};\n",
        "component c {\n  ids { long map; long draft; };\n  task slow { period 100 ms;\n    codel<start> plan(inout draft) yield copy wcet 40 ms;\n    codel<copy> copy(in draft, out map) yield pause::start wcet 1 ms;\n  };\n  task look { period 100 ms;\n    codel<start> read(in map) yield pause::start wcet 1 ms;\n  };\n  task fast { period 10 ms;\n    codel<start> move() yield pause::start wcet 1 ms;\n  };\n};\n",
        "Let the long codel work on a `local` copy or on data of its own, and exchange the shared data in short \
         codels before and after.",
    ),
    code(
        "timing-port-hold",
        "A codel holds a port for longer than the period of a task of another component that uses the port.",
        "With `ports lock;`, as in the published models, a codel holds its ports from its beginning to its \
         end. Meanwhile the task of the other component waits and misses a tick. The warning is shown in the \
         scenario and in the output of `dotgen verify`.",
        "component c {\n  port out p::map map;\n  task plan { period 500 ms;\n    codel<start> plan(out map) yield pause::start wcet 180 ms;\n  };\n};\ncomponent d {\n  port in p::map map;\n  task move { period 50 ms;\n    codel<start> move(in map) yield pause::start wcet 1 ms;\n  };\n};\n",
        "component c {\n  ids { p::map draft; };\n  port out p::map map;\n  task plan { period 500 ms;\n    codel<start> plan(out draft) yield publish wcet 180 ms;\n    codel<publish> publish(in draft, out map) yield pause::start wcet 1 ms;\n  };\n};\ncomponent d {\n  port in p::map map;\n  task move { period 50 ms;\n    codel<start> move(in map) yield pause::start wcet 1 ms;\n  };\n};\n",
        "Let the long codel work on a `local` copy or on the ids, and write the port in a short codel.",
    ),
    code(
        "timing-only-refused",
        "A request of a scenario is always refused, because a service that must succeed first never does.",
        "A service with `after` is refused until all services in that list have succeeded. Here no client \
         requests one of them, or one of them is always refused itself. Verification then proves nothing \
         about the refused service. The warning is shown in the scenario and in the output of `dotgen \
         verify`.",
        "component c {\n  task t { period 5 ms; };\n  function init() { };\n  function go() { after init; };\n};\n",
        "scenario s {\n  use \"c.gen\";\n  client a {\n    send c.init;\n    await ended;\n    send c.go;\n  }\n}\n",
        "Let a client of the scenario request the earlier service first, or write `order off;` in the scenario.",
    ),
];
