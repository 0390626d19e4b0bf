//! Codes about checks.

use super::{Code, error, of_specification, warning};

pub(super) const CODES: &[Code] = &[
    warning(
        "scn-no-check",
        "A scenario checks nothing.",
        "Verification ends without a verdict.",
        "Add `check schedulable *;` or another check.",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  check schedulable *;\n}\n",
    ),
    of_specification(
        "component robot {\n  task t {\n    codel<start> run() yields pause::start wcet 1 ms;\n  };\n};\n",
        error(
            "scn-aperiodic",
            "A check of deadlines names a task without a period.",
            "The deadline of a job is the beginning of the next period. A task without a period has \
             none.",
            "Give the task a `period`, or bound its response time: `check response c.t <= 5 ms;`.",
            "scenario s {\n  use \"robot.gen\";\n  check schedulable robot.t;\n}\n",
            "component robot {\n  task t { period 5 ms;\n    codel<start> run() yields pause::start wcet 1 ms;\n  };\n};\n",
        ),
    ),
    of_specification(
        "typedef long data;\ncomponent control {\n  port in data scan;\n  port out data speed;\n  task move { period 5 ms;\n    codel<start> step(in scan, out speed) yields pause::start wcet 1 ms;\n  };\n};\n",
        error(
            "scn-chain-end",
            "A chain does not end at one output of the system.",
            "Its end is an input that nothing writes, or an input that is connected to several \
             outputs.",
            "Name the output at which the chain ends.",
            "scenario s {\n  use \"robot.gen\";\n  check age control.speed -> control.scan;\n}\n",
            "scenario s {\n  use \"robot.gen\";\n  check age control.scan -> control.speed;\n}\n",
        ),
    ),
    of_specification(
        "typedef long data;\ncomponent control {\n  port in data scan;\n  port out data speed;\n  task move { period 5 ms;\n    codel<start> step(out speed) yields pause::start wcet 1 ms;\n  };\n};\n",
        error(
            "scn-no-way",
            "Data from the beginning of a chain never reach its end.",
            "No codel that is executed reads data that depend on the one port and writes the other.",
            "Request the activities that pass the data on, `connect` the ports between, or name other \
             ports. With `via`, name all codels on the way.",
            "scenario s {\n  use \"robot.gen\";\n  check reaction control.scan -> control.speed;\n}\n",
            "typedef long data;\ncomponent control {\n  port in data scan;\n  port out data speed;\n  task move { period 5 ms;\n    codel<start> step(in scan, out speed) yields pause::start wcet 1 ms;\n  };\n};\n",
        ),
    ),
];
