//! Codes of the lexer and the parser.

use super::{Code, error};

pub(super) const CODES: &[Code] = &[
    error(
        "lex-stray",
        "A character begins no token.",
        "It is skipped, and the text may mean something else without it.",
        "Remove the character. It may come from another language or from a copied document.",
        "const long a@ = 1;\n",
        "const long a = 1;\n",
    ),
    error(
        "lex-comment-open",
        "A block comment has no end.",
        "Everything to the end of the file is a comment. The reference compiler drops it without an \
         error.",
        "Close the comment with `*/`.",
        "/* this never ends\n",
        "/* this ends */\n",
    ),
    error(
        "syntax",
        "A token does not fit the grammar.",
        "The declaration cannot be read, so everything that uses it is unknown.",
        "The message says what was expected at that place. A `;`, a bracket or a keyword before it may \
         be missing.",
        "struct s { };\n",
        "struct s { long x; };\n",
    ),
    error(
        "syntax-eof",
        "The text ends in the middle of a declaration.",
        "A bracket or a `;` is missing, perhaps far above.",
        "Close the declaration with `};`. Formatting the file shows by its indentation where a bracket \
         is missing.",
        "struct s {\n",
        "struct s {\n  long x;\n};\n",
    ),
    error(
        "missing-semicolon",
        "A declaration has no semicolon.",
        "Declarations end with `;`, also after a `}`. The next one is read as if the `;` were there.",
        "Add the `;`.",
        "const long a = 1\nconst long b = 2;\n",
        "const long a = 1;\nconst long b = 2;\n",
    ),
    error(
        "missing-yield",
        "A codel with states does not say where they lead.",
        "The state machine needs the next states: they decide what is reachable and how long a job \
         takes.",
        "Add `yields` with all states that the codel can return, `ether` for the end.",
        "component c { task t { codel<start> f(); }; };\n",
        "component c { task t { codel<start> f() yields ether; }; };\n",
    ),
];
