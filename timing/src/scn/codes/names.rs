//! Codes about names in a scenario.

use super::{Code, error, of_specification};

pub(super) const CODES: &[Code] = &[
    error(
        "scn-unknown-name",
        "A name in a path does not exist in the specifications.",
        "The item or check would refer to nothing.",
        "Correct the spelling: the message lists the existing names. A path begins with the name of a \
         component.",
        "scenario s {\n  use \"robot.gen\";\n  check response sensor.aquire;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  check response sensor.acquire;\n}\n",
    ),
    error(
        "scn-path",
        "A path is incomplete.",
        "The path ends before it names the kind of thing that the item needs.",
        "Add the missing names: `component.task.state` or `component.service.state`.",
        "// a path that ends too early\n",
        "",
    ),
    error(
        "scn-wrong-kind",
        "A path names the wrong kind of thing.",
        "Only tasks have periods and deadlines, only activities can be aborted, and only ports can be \
         connected.",
        "Name a thing of the kind in the message.",
        "scenario s {\n  use \"robot.gen\";\n  check schedulable sensor.record;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  check schedulable sensor.acquire;\n}\n",
    ),
    error(
        "scn-wrong-status",
        "A path ends with a status that its target does not have.",
        "The condition would never hold.",
        "Remove the status, or use one that the target has. Completion in the editor lists them.",
        "scenario s {\n  use \"robot.gen\";\n  check within sensor.acquire.read.idle => control.move.step;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  check within sensor.acquire.read => control.move.step;\n}\n",
    ),
    of_specification(
        "component robot {\n  task t { period 5 ms;\n    codel<stop> halt() yields ether;\n  };\n};\n",
        error(
            "scn-not-executed",
            "A check is about a state machine that is never executed.",
            "A machine without `start` never begins, so its states are never entered.",
            "Give the machine a codel for `start`, or check another one.",
            "scenario s {\n  use \"robot.gen\";\n  check reachable robot.t.stop;\n}\n",
            "component robot {\n  task t { period 5 ms;\n    codel<start> run() yields ether;\n    codel<stop> halt() yields ether;\n  };\n};\n",
        ),
    ),
    error(
        "scn-unknown-step",
        "A check names a step that the client does not have.",
        "Steps have names only if they are labelled.",
        "Label the step (`name: send …;`), or correct the name.",
        "scenario s {\n  use \"robot.gen\";\n  client c { first: send sensor.reset; }\n  check within sensor.acquire.read => leave c.second;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  client c { first: send sensor.reset; }\n  check within sensor.acquire.read => leave c.first;\n}\n",
    ),
    error(
        "scn-abort",
        "`abort` names neither an activity nor a labelled request of the client.",
        "The client would have nothing to interrupt.",
        "Write `abort COMPONENT.ACTIVITY;`, or label the request: `first: send …;`.",
        "scenario s {\n  use \"robot.gen\";\n  client c { send sensor.record; abort first; }\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  client c { first: send sensor.record; abort first; }\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-not-a-codel",
        "`duration` names something that is not a codel.",
        "A duration belongs to one codel.",
        "Write `component.task.state`, `component.service.state` or `component.service.codel`.",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.record 3 ms;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.record.start 3 ms;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-port-direction",
        "`connect` names an output where an input is needed, or the reverse.",
        "Data go from an output to the inputs that are connected to it.",
        "Write the input first: `connect INPUT to OUTPUT;`.",
        "scenario s {\n  use \"robot.gen\";\n  connect sensor.scan to control.scan;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  connect control.scan to sensor.scan;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-no-use",
        "A scenario uses no specification.",
        "Without a specification there is nothing to verify.",
        "Add `use \"FILE.gen\";`. The path starts at the directory of the scenario.",
        "scenario s {\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-use-not-found",
        "A specification that the scenario uses cannot be read.",
        "Nothing is verified without the specification.",
        "Correct the path. It starts at the directory of the scenario.",
        "scenario s {\n  use \"robto.gen\";\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  check schedulable *;\n}\n",
    ),
    of_specification(
        "typedef long angle;\n",
        error(
            "scn-no-component",
            "The specifications of the scenario have no component.",
            "Types and interfaces do not run, so there is nothing to verify.",
            "Use the specification that declares the component.",
            "scenario s {\n  use \"robot.gen\";\n  check schedulable *;\n}\n",
            "component robot {\n  task t { period 5 ms;\n    codel<start> run() yields pause::start wcet 1 ms;\n  };\n};\n",
        ),
    ),
];
