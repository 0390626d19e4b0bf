//! Codes of the lexer and the parser.

use super::{AT_END, Code, Stage, error};

pub(super) const CODES: &[Code] = &[
    error(
        "lex-stray",
        "A character is not part of the language.",
        "The character is skipped. Without it, the text may mean something else.",
        "Remove the character. It may come from another language or from a copied document.",
        "const long a@ = 1;\n",
        "const long a = 1;\n",
    ).at(Stage::Lexer).goes_on(),
    error(
        "lex-comment-open",
        "A block comment has no end.",
        "Everything up to the end of the file becomes a comment. The reference compiler drops it without an \
         error.",
        "Close the comment with `*/`.",
        "/* this never ends\n",
        "/* this ends */\n",
    ).at(Stage::Lexer).goes_on().cut(),
    error(
        "syntax",
        "A token does not fit the grammar.",
        "The declaration cannot be read, so everything that uses it is unknown.",
        "Write the token that the message expects. A `;`, a bracket or a keyword may be missing just before \
         the marked place.",
        "struct s { };\n",
        "struct s { long x; };\n",
    ).at(Stage::Parser),
    error(
        AT_END,
        "The text ends in the middle of a declaration.",
        "A bracket or a `;` is missing, perhaps far above.",
        "Close the declaration with `};`. The message marks the `{` that is not closed.",
        "struct s {\n",
        "struct s {\n  long x;\n};\n",
    ).at(Stage::Parser).cut(),
    error(
        "missing-semicolon",
        "A declaration has no semicolon.",
        "Every declaration ends with `;`, also after a `}`. dotgen reads the next declaration as if the `;` \
         were there.",
        "Add `;` at the end of the declaration.",
        "const long a = 1\nconst long b = 2;\n",
        "const long a = 1;\nconst long b = 2;\n",
    ).at(Stage::Parser).goes_on(),
    error(
        "missing-yield",
        "A codel with states has no `yields` list.",
        "The state machine needs the next states: they decide which states are reachable and how long a job \
         takes.",
        "Add `yields` with all states that the codel can return. Use `ether` to end the machine.",
        "component c { task t { codel<start> f(); }; };\n",
        "component c { task t { codel<start> f() yields ether; }; };\n",
    ).at(Stage::Parser).goes_on().cut(),
];
