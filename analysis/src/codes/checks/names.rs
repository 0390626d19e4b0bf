//! Codes about names, types and unions.

use crate::codes::Cause::UnreadText;

use super::{Code, error, warning};

pub(super) const CODES: &[Code] = &[
    error(
        "name-clash",
        "The same name is declared twice in one scope.",
        "A name must denote one thing. With two declarations, every use of the name is ambiguous.",
        "Rename one of the declarations, remove the duplicate, or move one into a module of its own. \
         If a file is included twice, give it an include guard: `#pragma once` has no effect.",
    ),
    error(
        "name-clash-module",
        "A declaration has the name of a module or component in the same scope.",
        "Modules and components are scopes. In `arm::x`, `arm` could be either the module or the type.",
        "Rename the declaration or the module.",
    ),
    error(
        "name-clash-enclosing",
        "A declaration has the name of the module, component or type that encloses it.",
        "Inside `arm`, the name `arm` already means the enclosing scope.",
        "Rename the inner declaration. Members of structs and unions may keep the name.",
    ),
    error(
        "unknown-type",
        "A name does not resolve to any type or constant that is declared before it.",
        "Names are looked up from the innermost scope outwards, among the declarations above the use. \
         A later declaration does not count.",
        "Correct the spelling, qualify the name (`module::name`), include the file that declares the \
         type, or move the declaration up.",
    ).follows(&[UnreadText]),
    error(
        "comp-kind-conflict",
        "A component is reopened as an interface, or an interface as a component.",
        "A second declaration with the same name adds to the first, so both must have the same kind.",
        "Use the same keyword in both places, or give the interface another name.",
    ),
    error(
        "forward-undefined",
        "A type is declared in advance (`struct s;`) but never defined.",
        "Without the members the mappings cannot generate the type.",
        "Add the definition in the same scope and the same file, or remove the forward declaration.",
    ).follows(&[UnreadText]),
    error(
        "forward-by-value",
        "A type that is only declared in advance is used where its members must be known.",
        "A struct that contains the type, an array of it or an alias has a size only once the type is \
         defined. `sequence<>` and `optional<>` of it are fine.",
        "Move the definition above the use, or use `sequence<T>` or `optional<T>`.",
    ),
    error(
        "forward-other-file",
        "A type that one file declares in advance is defined in another file.",
        "GenoM3 completes a forward declaration only within its file.",
        "Remove the forward declaration if the other file is included before the first use, or move \
         the definition into this file.",
    ),
    error(
        "void-exception-type",
        "An exception without members is used as a data type.",
        "Such an exception has no data, so there is nothing that a member, an alias or a parameter \
         could hold.",
        "Give the exception a member, or use a struct as data type.",
    ),
    error(
        "fixed-unsupported",
        "The type `fixed` or a fixed-point literal (`0.2d`) is used.",
        "The words are part of the grammar that GenoM3 takes from OMG IDL, but no mapping exists for \
         fixed-point numbers.",
        "Use `double`, or an integer in a smaller unit (cents, millimetres). Remove the `d` at the end \
         of the literal.",
    ),
    error(
        "union-switch-type",
        "A union switches on a type whose values cannot be labels.",
        "Each label of a `case` is a constant of the switch type. Only `boolean`, `char`, enums and \
         integers other than `octet` have such constants.",
        "Switch on an enum or an integer type.",
    ),
    error(
        "union-duplicate-label",
        "Two members of a union have the same label.",
        "The label selects the member that the union holds. If two members share a label, the choice is \
         ambiguous.",
        "Give each label to one member. Only one member may be the `default`.",
    ),
    warning(
        "union-repeated-label",
        "The same label is written twice in front of one member.",
        "The second label has no effect. It is probably a mistyped label, and the value that was meant \
         is missing.",
        "Remove the repetition, or write the label that was meant.",
    ),
    error(
        "union-member-switch-clash",
        "A union member has the name of the type that the union switches on.",
        "Inside the union, the name already means the switch type.",
        "Rename the member.",
    ),
];
