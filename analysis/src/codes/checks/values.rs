//! Codes about constants and default values.

use crate::codes::Cause::UnreadText;

use super::{Code, error, ours};

pub(super) const CODES: &[Code] = &[
    error(
        "const-positive",
        "A size, bound, index, priority or stack is not a non-negative whole number.",
        "These values count something: elements, bytes or levels.",
        "Write a non-negative integer. An expression is allowed if its value is whole, such as `4.0 / 2`.",
    ),
    error(
        "const-binary",
        "A binary operator is applied to operands that it does not accept.",
        "`+ - * /` take numbers; `% & | ^ << >>` take whole numbers. Booleans, characters, strings and \
         enumerators have no operators.",
        "Write the result of the expression instead, or use operands of the right kind.",
    ),
    error(
        "const-unary",
        "A unary operator is applied to an operand that it does not accept.",
        "`-` and `+` need a number; `~` needs an integer or a boolean.",
        "Remove the operator, or use a value of the right kind.",
    ),
    error(
        "const-operand",
        "A name in an expression has no value: it is neither a constant nor an enumerator.",
        "The value of an expression must be known when the specification is read.",
        "Use a `const` or an enumerator, or write the value itself.",
    )
    .follows(&[UnreadText]),
    error(
        "const-convert",
        "A value cannot be converted to the declared type.",
        "Values are not converted silently: a fraction is not an integer, a negative number is not \
         unsigned, and a number is neither a string nor a boolean.",
        "Change the value or the type. Write `TRUE` and `FALSE` for booleans, quotes for strings.",
    ),
    error(
        "const-type",
        "A constant or default value is declared with a type that cannot hold one.",
        "Constants are numbers, booleans, characters, strings or enumerators. Structs, unions, \
         sequences, arrays, exceptions and native types are none of these.",
        "Declare a constant for each part, or give the default value where the type is used: `in pose \
         p = { 1, 2 }`.",
    ),
    error(
        "const-numeric",
        "A time or size is not a number.",
        "The values of `period`, `delay`, `clock-rate` and similar properties are multiplied by a unit, so \
         they must be numbers.",
        "Write a number, without quotes: `period 5 ms;`.",
    ),
    error(
        "const-div-zero",
        "An integer is divided by zero, or the remainder of a division by zero is taken.",
        "The expression has no value. The reference compiler crashes here.",
        "Correct the divisor. It can be a constant that is zero only in this configuration.",
    ),
    ours(error(
        "const-range",
        "An integer does not fit the declared type.",
        "The generated code would hold a different number: `256` as an `octet` becomes 0. `genom3` \
         does not check this.",
        "Choose a wider type, or correct the value.",
    )),
    error(
        "init-compound-scalar",
        "A list in braces is the default value of a type without members or elements.",
        "`{ … }` gives values to the elements of an array or sequence or to the members of a struct or \
         union. A number or a string has neither.",
        "Write the value without braces.",
    ),
    error(
        "init-scalar-compound",
        "A single value is the default value of a type with members or elements.",
        "An array, sequence, struct or union takes one value for each element or member.",
        "Put the value in braces: `= { 1 }`.",
    ),
    error(
        "init-member",
        "A default value names a member that the type does not have.",
        "No member can receive the value.",
        "Correct the name after the dot, or remove the entry.",
    )
    .follows(&[UnreadText]),
    error(
        "init-array-member",
        "A default value names a member of an array or sequence.",
        "Elements have indexes, not names.",
        "Write `[n] = value`, or list the values in order.",
    ),
    error(
        "init-bounds",
        "A default value is for an element beyond the length of the array or sequence.",
        "Indexes begin at 0. A value without an index is for the next element: after `[1] = 1` comes element \
         2.",
        "Remove the value, correct the index, or make the array longer.",
    ),
    error(
        "init-struct-index",
        "A default value has an index in a struct or union.",
        "Members have names, not indexes.",
        "Write `.member = value`, or list the values in the order of the members.",
    ),
    error(
        "init-too-many",
        "More default values are given than the type has members.",
        "A value without a name is for the next member. After the last member there is none.",
        "Remove the extra values, or name the member that each value is for.",
    ),
];
