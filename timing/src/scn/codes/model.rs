//! Codes about scenarios that do not describe a system.

use super::{Code, error, of_specification};

pub(super) const CODES: &[Code] = &[
    error(
        "scn-affinity",
        "A task is tied to a core that does not exist, or under a policy that does not tie tasks to \
         cores.",
        "Cores are numbered from 1 to `cores`. Only `policy priority;` and `policy fair;` keep a task \
         on its core, and `cores free;` has no fixed cores.",
        "Use an existing core, raise `cores`, or change the policy.",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  affinity control.move 3;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  affinity control.move 2;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-semantics",
        "An item or step is not available with `semantics published;`.",
        "`semantics published;` follows the published formal models. They have no preemption and no order of \
         services, and clients cannot use `await ended ok`, `await ended failed`, `abort`, `connect` or \
         `kill`.",
        "Write `semantics servers;`, or leave out the item.",
        "scenario s {\n  use \"robot.gen\";\n  semantics published;\n  policy priority;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  semantics servers;\n  policy priority;\n  check schedulable *;\n}\n",
    ),
    of_specification(
        "component robot {\n  task t { period 0 ms;\n    codel<start> run() yields pause::start wcet 1 ms;\n  };\n};\n",
        error(
            "scn-zero-period",
            "A periodic task has the period zero.",
            "Such a task would run infinitely often in no time.",
            "Write the period in the specification. For a task that only runs on events, leave out `period`.",
            "scenario s {\n  use \"robot.gen\";\n  check response robot.t;\n}\n",
            "component robot {\n  task t { period 5 ms;\n    codel<start> run() yields pause::start wcet 1 ms;\n  };\n};\n",
        ),
    ),
    error(
        "scn-period-unit",
        "A period is not a multiple of the unit of the scenario.",
        "Execution times are rounded to the unit. A rounded period would describe another system.",
        "Write the unit that the message proposes, or leave out `unit`.",
        "scenario s {\n  use \"robot.gen\";\n  unit 3 ms;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  unit 1 ms;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-time-range",
        "A time is too long for the unit of the scenario.",
        "Times are counted in units, and this count is too large.",
        "Choose a coarser `unit`, or correct the time.",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.acquire.read 9999999999999999 s;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.acquire.read 3 ms;\n  check schedulable *;\n}\n",
    ),
    of_specification(
        "component robot {\n  task t { period 5 ms;\n    codel<start> run() yields main wcet 1 ms;\n    codel<main> go() yields main wcet 1 ms;\n  };\n};\n",
        error(
            "scn-contradictory-loop",
            "A `loop` limit leaves a state without a successor.",
            "The limit removes the yields that enter a state once more. If none remains, the turn can \
             neither go on nor end, so every check would hold for the wrong reason.",
            "Let the codel yield `pause::` or `ether` as well, or write `loop free` for this machine.",
            "scenario s {\n  use \"robot.gen\";\n  loop once;\n  check schedulable *;\n}\n",
            "component robot {\n  task t { period 5 ms;\n    codel<start> run() yields main wcet 1 ms;\n    codel<main> go() yields main, pause::main wcet 1 ms;\n  };\n};\n",
        ),
    ),
    error(
        "scn-client-size",
        "A client has more than 20000 steps.",
        "Nested repetitions multiply, and each repetition becomes a separate part of the model.",
        "Repeat less often, or write `repeat *`.",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat 200 { repeat 200 { send sensor.reset; } } }\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat * { send sensor.reset; await ended; } }\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-empty-repeat",
        "A `repeat *` can go on for ever without a step.",
        "Time would stop: the client repeats without a step that takes time or waits.",
        "Add a step, such as `send` or `delay`.",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat * { } }\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat * { delay 1 ms; } }\n  check schedulable *;\n}\n",
    ),
];
