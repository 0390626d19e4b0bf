//! Codes about execution times.

use crate::codes::Cause::UnreadText;

use super::{Code, error, ours, warning};

pub(super) const CODES: &[Code] = &[
    ours(error(
        "wcet-value",
        "A `wcet` is negative, not a number, missing or given twice.",
        "Verification computes response times from this value.",
        "Write one non-negative time with its unit: `wcet 26 us`.",
    )),
    ours(warning(
        "wcet-bare",
        "An execution time stands after the `yields` list without the word `wcet`.",
        "dotgen reads the number as the codel's execution time, but readers of the text cannot see that.",
        "Insert `wcet` before the number. If `genom3` also reads the file, write `#pragma wcet CODEL \
         26 us` instead: `genom3` rejects both forms after the `yields` list and ignores the pragma.",
    )),
    ours(warning(
        "glued-unit",
        "A number directly followed by `us` is read as an unsigned number of seconds.",
        "The `u` is taken as the suffix of an unsigned literal: `500us` is 500 s. The generated \
         component uses that value.",
        "Write a space before the unit: `500 us`. In `wcet 26us` the unit is read as written.",
    )),
    ours(error(
        "wcet-pragma",
        "A `#pragma wcet` cannot be applied.",
        "The pragma names no codel of the specification, repeats or contradicts another execution time, or \
         has no unit. Verification would use a time other than the one written.",
        "Write `#pragma wcet CODEL TIME` once for each codel, with a unit: `#pragma wcet run 3 ms`.",
    )).follows(&[UnreadText]),
];
