//! Codes about the text of a scenario.

use super::{Code, error};

pub(super) const CODES: &[Code] = &[
    error(
        "scn-syntax",
        "The text does not fit the grammar of scenarios.",
        "The item cannot be read. Nothing is verified until the text is correct.",
        "Write the token that the message expects. Often a `;` is missing just before the marked place.",
        "scenario s {\n  use \"robot.gen\";\n  cores 2\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-lexical",
        "A character is not part of the language, or a string or comment has no end.",
        "The rest of the line, or of the file, cannot be read.",
        "Remove the character, or add the missing `\"` or `*/`.",
        "scenario s {\n  use \"robot.gen\";\n  cores 2; $\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 2;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-nesting",
        "Steps or conditions are nested more than 100 deep.",
        "The limit keeps dotgen from running out of memory.",
        "Nest fewer parentheses and blocks.",
        "// more than 100 parentheses or blocks inside each other\n",
        "",
    ),
    error(
        "scn-number",
        "A number is too large.",
        "Counts, for example of cores or rounds, go up to 255. Other numbers have up to 64 bits.",
        "Write a smaller number.",
        "scenario s {\n  use \"robot.gen\";\n  cores 999;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  cores 4;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-interval",
        "The lower bound of an interval is greater than the upper one.",
        "No time lies in the interval.",
        "Swap the bounds. Write `*` for no upper bound.",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.acquire.read [3,1] ms;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  duration sensor.acquire.read [1,3] ms;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-repeat",
        "A `repeat` has more than 1000 repetitions.",
        "Each repetition becomes a separate part of the model. More than 1000 cannot be explored.",
        "Write `repeat *` if the client never stops, or a smaller number.",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat 5000 { send sensor.reset; await ended; } }\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  client c { repeat * { send sensor.reset; await ended; } }\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-zero-unit",
        "The unit of the scenario is zero.",
        "Results are multiples of the unit.",
        "Write at least 1, or leave out `unit`: the default is 1 ms.",
        "scenario s {\n  use \"robot.gen\";\n  unit 0 ms;\n  check schedulable *;\n}\n",
        "scenario s {\n  use \"robot.gen\";\n  unit 1 ms;\n  check schedulable *;\n}\n",
    ),
    error(
        "scn-no-core",
        "The scenario has no core.",
        "Without a core nothing runs, so a check would mean nothing.",
        "Write at least one core, or `cores free;` for as many cores as there are tasks.",
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
