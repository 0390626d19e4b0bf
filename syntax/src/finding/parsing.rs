//! Findings of the parser.

use smol_str::SmolStr;

findings! {
    /// A text that does not fit the grammar.
    pub enum Parsing {
        "syntax" Expected { what: SmolStr, found: SmolStr } => "expected {what}, found {found}";
        "syntax" ExpectedBecause { what: SmolStr, found: SmolStr, help: &'static str }
            => "expected {what}, found {found}", "{help}";
        "syntax" Misspelt { word: SmolStr, keyword: SmolStr }
            => "`{word}` is no keyword", "did you mean `{keyword}`?";
        "syntax" NoComma { found: SmolStr }
            => "missing `,` or `;`: found {found}", "names in a list are separated by commas";
        "syntax" SingleColon { found: SmolStr }
            => "expected `::`, found {found}", "the parts of a name are joined by `::`";
        "syntax" NoUnit { word: SmolStr }
            => "`{word}` is no unit", "a time is given in `s`, `ms` or `us`";
        "syntax" Frequency { word: SmolStr }
            => "`{word}` is no unit", "a rate is written as the time between two: `10 ms` for 100 Hz";
        "syntax" ForeignType { word: SmolStr, ty: &'static str }
            => "`{word}` is no type here", "did you mean `{ty}`?";
        "syntax" ForeignSign { found: SmolStr, sign: &'static str }
            => "expected `{sign}`, found {found}", "did you mean `{sign}`?";
        "syntax" Anonymous { word: SmolStr, name: SmolStr }
            => "a type needs its name behind `{word}`", "write `{word} {name} {{ … }};`";
        "syntax" NoNewName
            => "this `typedef` gives its type no other name", "leave `typedef` out";
        "syntax" NoQuotes { found: SmolStr }
            => "expected a string, found {found}", "write the text between double quotes";
        "syntax" LeadingDigit { word: SmolStr }
            => "`{word}` is not a name", "names begin with a letter";
        "syntax" ExtraWord { word: SmolStr }
            => "expected a type and a name, found `{word}` before them", "remove it";
        "syntax" ForeignComment
            => "`--` does not begin a comment here", "write `//`";
        "syntax" ForeignInclude { word: SmolStr }
            => "`{word}` does not include a file here", "write `#include`";
        "missing-semicolon" NoSemicolonAtEnd { after: SmolStr, others: &'static str }
            => "missing `;` after {after}{others}: the file ends here", "add `;`";
        "missing-semicolon" NoSemicolon { after: SmolStr, others: &'static str, found: SmolStr }
            => "missing `;` after {after}{others}: found {found}", "add `;` before it";
        "missing-semicolon" NoSemicolonOrQuote { after: SmolStr, others: &'static str, found: SmolStr }
            => "this text goes over several lines, and {found} follows it",
               "add the `\"` that it lacks, or `;` after {after}{others}";
        "missing-yield" NoYield { found: SmolStr }
            => "this codel has states but no `yield` list (found {found})", "add `yield STATE, …`";
        "wcet-pragma" MoreInPragma { found: SmolStr }
            => "expected the end of the line after the execution time, found {found}", "remove it";

        "syntax" BodyNotClosedAtEnd { owner: SmolStr }
            => "missing `}}` at the end of {owner}: the file ends here", "add `}};`";
        "syntax" BodyNotClosedHere { owner: SmolStr, found: SmolStr }
            => "missing `}}` at the end of {owner}: add `}}` before {found}";
        "syntax" BodyNotClosed { owner: SmolStr, found: SmolStr }
            => "missing `}}` at the end of {owner}: found {found}", "add `}};` before it";
        "syntax" ExtraBrace => "this `}}` closes nothing: remove it, or add the `{{` it belongs to";
        "syntax" EmptyBody { owner: SmolStr }
            => "{owner} cannot be empty", "declare something between the braces";
        "syntax" HeadlessComponent { word: SmolStr, expected: &'static str }
            => "`{word}` cannot stand here, expected {expected}",
               "is the line `component NAME {{` missing before it?";
        "syntax" Outside { word: SmolStr, expected: &'static str }
            => "`{word}` cannot stand here, expected {expected}", "move it into a component";
        "syntax" HeadlessProperties { word: SmolStr }
            => "`{word}` cannot stand in a component",
               "is the line that begins its task or service missing before it, such as `task NAME {{`?";
        "syntax" ExtraSemicolon => "unexpected `;`: remove it";
        "syntax" OpenLiteral => "this literal has no closing quote", "add it where the text ends";

        "syntax" ValidateWithStates => "a `validate` codel has no states: remove them";
        "syntax" YieldWithoutStates
            => "a codel without `<states>` yields nothing: remove this list, or say which states it serves";
        "syntax" StatesWithoutAngles { state: SmolStr, name: SmolStr }
            => "expected `<`, found `{state}`",
               "the states of a codel stand in angle brackets: `codel<{state}> {name}(…)`";
        "syntax" QualifiedState { word: SmolStr }
            => "`{word}::` cannot stand before a state: write `pause::` or remove it";
        "syntax" BareNumber
            => "a number cannot stand here", "an execution time is written `wcet 10 us`";
        "syntax" AttributeSource
            => "parameters of an attribute are members of the ids: remove the source";
        "syntax" CodelDefault => "parameters of codels have no default value: remove it";

        "syntax" UnfitConstant
            => "a constant cannot have this type", "use a number, boolean, character or string type";
        "syntax" UnfitSwitch
            => "a union cannot switch on this type",
               "use an integer type, `char`, `boolean` or an enum";
        "syntax" DeclaredHere
            => "a type cannot be declared here", "declare it before and write its name";
        "syntax" Meaningless { word: SmolStr }
            => "`{word}` is a reserved word without meaning", "use another type";
        "syntax" ClosingShift => "`>>` is the shift operator", "write `> >` to close two templates";
        "syntax" EnumeratorValue => "enumerators have no value of their own: remove it";
        "syntax" LongExpression
            => "this expression is too long", "declare constants for parts of it";
        "syntax" TwoOperators
            => "two unary operators in a row",
               "put the second one and its operand in parentheses";
        "syntax" TooNested { most: u32 }
            => "this is nested more than {most} levels deep", "declare parts of it separately";
        "syntax" TooMany => "too many syntax errors", "those further down are not listed";
    }
}
