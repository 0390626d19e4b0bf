//! Codes about text that the reference compiler accepts although it causes errors later.

use crate::codes::Cause::UnreadText;

use super::{Code, hint, ours, warning};

pub(super) const CODES: &[Code] = &[
    ours(warning(
        "zero-size",
        "An array has no elements, or a string or sequence has the bound zero.",
        "Nothing can be stored in it, and C does not allow arrays without elements.",
        "Write the intended size. Leave the bound out for a sequence or string of any length.",
    )),
    ours(warning(
        "size-too-large",
        "The size of an array, or the bound of a string or sequence, is above 2147483647.",
        "`genom3` reads sizes as signed 32-bit integers and refuses larger ones.",
        "Write a smaller size. Leave the bound out for a sequence or string of any length.",
    )),
    ours(warning(
        "not-a-type",
        "A constant, enumerator, state, port or remote service is used as a type.",
        "`genom3` accepts this without an error, because all of these names share one scope. But no code can \
         be generated for such a type.",
        "Use a type. For an array of a constant size write `typedef long numbers[size];`.",
    )),
    ours(warning(
        "priority-range",
        "A priority is above 255.",
        "255 is the highest priority that GenoM3 documents. What a larger value does depends on the \
         template.",
        "Choose a priority from 0 to 255.",
    )),
    ours(warning(
        "period-zero",
        "The period of a task is zero.",
        "Such a task is not periodic, although the text suggests it. Its load and response times cannot be \
         computed.",
        "Write the intended period. For a task that only runs on events, leave out `period`.",
    )),
    ours(warning(
        "string-too-long",
        "A string constant is longer than the bound of its type.",
        "A variable of the type has no room for the whole string. `genom3` does not check this.",
        "Shorten the string, or raise the bound.",
    )),
    ours(warning(
        "octal-digit",
        "An octal literal contains an 8 or a 9.",
        "A number that begins with 0 is octal. Octal digits end at 7, so the value is not the one that \
         is written: `09` is 0.",
        "Remove the leading 0, or write the number with octal digits.",
    )),
    ours(warning(
        "codels-requires-again",
        "A component has a second `codels-requires`.",
        "Releases of GenoM3 before 2.99.41 reject it.",
        "Put all packages into one list: `codels-requires \"a\", \"b\";`. If older releases do not \
         matter, write `requires \"genom3 >= 2.99.41\";`.",
    )),
    ours(warning(
        "attribute-codel",
        "An attribute has a `codel`.",
        "Releases of GenoM3 before 2.99.41 reject it.",
        "Write `validate` if the codel checks the new value, or make the service a function. If older \
         releases do not matter, write `requires \"genom3 >= 2.99.41\";`.",
    )),
    ours(hint(
        "newer-release",
        "Only newer releases of GenoM3 accept this, but the specification allows older ones.",
        "An older release that the requirements allow rejects the component.",
        "Require the release: `requires \"genom3 >= 2.99.41\";`. Or use a form that older releases accept: \
         `docs/releases.md` lists the differences.",
    )),
    ours(warning(
        "inout-input-port",
        "An input port is passed as `inout`.",
        "`genom3` accepts this, but data that the codel writes to an input port reach no other component.",
        "Write `in`, or declare the port as `port out`.",
    )),
    ours(warning(
        "writes-input",
        "A codel writes an `in` parameter of its service.",
        "The client does not get the value back: an `in` parameter travels only to the component.",
        "Declare the parameter `inout` or `out`, pass it to the codel as `in`, or use a `local` \
         variable.",
    )),
    ours(warning(
        "ether-codel",
        "A codel implements the state `ether`.",
        "`ether` ends the machine. The codel is accepted, but nothing runs after the end.",
        "Rename the state and let its codel yield `ether`, or remove the codel.",
    )),
    ours(warning(
        "lists-itself",
        "A service names itself in `before` or `after`.",
        "The order cannot be kept: the service would have to have run before its first run.",
        "Remove the name, or write the intended service. `interrupts` may name the service itself.",
    )),
    ours(warning(
        "unused-task",
        "A task runs nothing: it has no codels, and no activity names it.",
        "The component creates a thread that never does anything.",
        "Remove the task, give it codels, or name it in an activity.",
    ))
    .follows(&[UnreadText]),
];
