//! Codes about execution times.

use super::{Code, error, ours, warning};

pub(super) const CODES: &[Code] = &[
    ours(error(
        "wcet-value",
        "A `wcet` is negative, not a number, missing or given twice.",
        "Verification computes response times and deadlines from it.",
        "Write one non-negative time with its unit: `wcet 26 us`.",
    )),
    ours(warning(
        "wcet-bare",
        "An execution time stands after the `yields` list without the word `wcet`.",
        "dotgen reads it as the codel's execution time, but the text does not say so to its readers.",
        "Insert `wcet` before the number. If `genom3` also reads the file, write `#pragma wcet CODEL \
         26 us` instead: `genom3` rejects both forms after the `yields` list and ignores the pragma.",
    )),
    ours(warning(
        "glued-unit",
        "A number glued to `us` is read as an unsigned number of seconds.",
        "The `u` is taken as the suffix of an unsigned literal: `500us` is 500 s. The generated \
         component uses that value.",
        "Write a blank before the unit: `500 us`. In `wcet 26us` the unit is read as written.",
    )),
    ours(error(
        "wcet-pragma",
        "A `#pragma wcet` cannot be applied.",
        "It names no codel of the specification, repeats or contradicts another execution time, or has \
         no unit. Verification would use another time than the one written.",
        "Write `#pragma wcet CODEL TIME` once for each codel, with a unit: `#pragma wcet run 3 ms`.",
    )),
];
