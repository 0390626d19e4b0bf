//! Codes about the text of a scenario.

use super::{Code, error};

pub(super) const CODES: &[Code] = &[
    error(
        "scn-syntax",
        "A text does not fit the grammar of scenarios.",
        "The item cannot be read, and nothing is verified until the text is complete.",
        "The message says what is expected at that place. Often a `;` is missing before it.",
        "scenario s {\n  use \"robot.gen\";\n  cores 2\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-lexical",
        "A character means nothing, or a string or comment has no end.",
        "The rest of the line, or of the file, cannot be read.",
        "Remove the character, or add the missing `\"` or `*/`.",
        "scenario s {\n  use \"robot.gen\";\n  cores 2; $\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-nesting",
        "Steps or conditions are nested more than 100 deep.",
        "The limit keeps the reader from running out of memory.",
        "Write the scenario with fewer parentheses and blocks inside each other.",
        "// more than 100 parentheses or blocks inside each other\n",
        "",
    ),
    error(
        "scn-number",
        "A number is too large.",
        "Counts of cores, rounds and the like go up to 255, other numbers up to 64 bits.",
        "Write a smaller number.",
        "scenario s {\n  use \"robot.gen\";\n  cores 999;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 4;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-interval",
        "The lower bound of an interval is greater than the upper one.",
        "No time is in the interval.",
        "Swap the bounds. Write `*` for no upper bound.",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.acquire.read [3,1] ms;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.acquire.read [1,3] ms;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-repeat",
        "A `repeat` has more than 1000 repetitions.",
        "Each repetition is a part of the model of its own. So many cannot be explored.",
        "Write `repeat *` if the client goes on for ever, or a smaller number.",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat 5000 { send sensor.reset; await ended; } }\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat * { send sensor.reset; await ended; } }\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-zero-unit",
        "The unit of the scenario is zero.",
        "Results are multiples of the unit.",
        "Give at least 1, or leave `unit` out: it is then 1 ms.",
        "scenario s {\n  use \"robot.gen\";\n  unit 0 ms;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  unit 1 ms;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-no-core",
        "The scenario has no core.",
        "Without a core nothing runs, so every check would say nothing.",
        "Give at least one core, or write `cores free;` for as many as there are tasks.",
        "scenario s {\n  use \"robot.gen\";\n  cores 0;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 1;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-loop-zero",
        "A `loop` limit is zero.",
        "A turn enters each state at least once.",
        "Write `loop once;` or a greater number, or `loop free;` for no limit.",
        "scenario s {\n  use \"robot.gen\";\n  loop 0;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  loop once;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-slots",
        "The number of slots is not between 1 and 32.",
        "Without a slot, a task or activity never runs. Each further slot multiplies the states to \
         explore.",
        "Write a number from 1 to 32.",
        "scenario s {\n  use \"robot.gen\";\n  slots sensor.acquire 0;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  slots sensor.acquire 4;\n  check schedulable *;\n}\n",
    ),
];
