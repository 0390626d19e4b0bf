//! Every diagnostic code of the lexer, the preprocessor and the parser, in one table.
//!
//! Conditions are those of the language reference, section 19; each has the smallest text that
//! triggers it, for the manual.

use crate::preproc::Severity;

/// What is known about one code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The code, as shown and as used in configuration.
    pub id: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What it means, in one line.
    pub meaning: &'static str,
    /// A text that triggers it.
    pub example: &'static str,
    /// Whether the reference compiler reports it too.
    pub reference: bool,
}

const fn error(id: &'static str, meaning: &'static str, example: &'static str) -> Code {
    Code {
        id,
        severity: Severity::Error,
        meaning,
        example,
        reference: true,
    }
}

const fn warning(id: &'static str, meaning: &'static str, example: &'static str) -> Code {
    Code {
        id,
        severity: Severity::Warning,
        meaning,
        example,
        reference: true,
    }
}

/// All codes, in the order of the reference.
pub const CODES: &[Code] = &[
    error(
        "pp-include-not-found",
        "an included file is in none of the searched places",
        "#include \"nowhere.idl\"\n",
    ),
    error(
        "pp-include-bad",
        "`#include` without a file name, or with something after it",
        "#include nowhere.idl\n",
    ),
    error(
        "pp-include-depth",
        "more than 100 files are open at the same time",
        "// in self.gen\n#include \"self.gen\"\n",
    ),
    error("pp-define-bad", "a malformed `#define`", "#define 3\n"),
    error(
        "pp-define-dup-param",
        "a macro with two parameters of the same name",
        "#define F(x, x) x\n",
    ),
    error(
        "pp-va-args",
        "`__VA_ARGS__` in a macro without `...`",
        "#define F(x) __VA_ARGS__\n",
    ),
    error(
        "pp-stringize",
        "`#` that is not followed by a parameter of the macro",
        "#define F(x) #y\n",
    ),
    warning(
        "pp-redefined",
        "a macro is defined again with another body",
        "#define N 4\n#define N 5\n",
    ),
    error("pp-undef-bad", "`#undef` without a name", "#undef 3\n"),
    error("pp-line-bad", "`#line` without a number", "#line \"x\"\n"),
    error(
        "pp-macro-args",
        "a macro called with the wrong number of arguments",
        "#define F(x, y) x\nconst long a = F(1);\n",
    ),
    error(
        "pp-macro-eof",
        "the file ends inside the arguments of a macro call",
        "#define F(x) x\nconst long a = F(1\n",
    ),
    error(
        "pp-macro-limit",
        "an expansion is too large or too deep",
        "// a macro that doubles itself, many times over\n",
    ),
    error(
        "pp-bad-char",
        "a control character in the text",
        "// a byte with code 1 to 4\n",
    ),
    error(
        "pp-pragma-bad",
        "`#pragma` with nothing after it",
        "#pragma\n",
    ),
    error(
        "pp-pragma-operator",
        "`_Pragma` whose argument is not one string",
        "_Pragma(requires)\n",
    ),
    error(
        "pp-requires-empty",
        "`#pragma requires` without a package",
        "#pragma requires\n",
    ),
    error(
        "pp-requires-many",
        "`#pragma requires` with more than eight arguments",
        "#pragma requires a b c d e f g h i\n",
    ),
    error(
        "pp-requires-unresolved",
        "a package that is not installed, or not in a suitable version",
        "#pragma requires \"missing\"\n",
    ),
    error(
        "pp-cond-unterminated",
        "a conditional that is still open at the end of the file",
        "#if 1\n",
    ),
    error(
        "pp-else-without-if",
        "`#else` outside a conditional",
        "#else\n",
    ),
    error(
        "pp-elif-without-if",
        "`#elif` outside a conditional",
        "#elif 1\n",
    ),
    error(
        "pp-endif-without-if",
        "`#endif` outside a conditional",
        "#endif\n",
    ),
    error(
        "pp-else-twice",
        "a second `#else` in one conditional",
        "#if 1\n#else\n#else\n#endif\n",
    ),
    error(
        "pp-extra-tokens",
        "something after the name of `#ifdef`, `#ifndef` or `#undef`",
        "#ifdef A B\n#endif\n",
    ),
    warning(
        "pp-extra-tokens-tail",
        "something after `#else` or `#endif`",
        "#if 1\n#endif FOO\n",
    ),
    warning(
        "pp-no-newline",
        "the file ends on an `#else` or `#endif` without a line end",
        "#if 1\n#endif",
    ),
    error(
        "pp-ifdef-bad",
        "`#ifdef` or `#ifndef` without a name",
        "#ifdef 3\n#endif\n",
    ),
    error(
        "pp-if-syntax",
        "a condition that is no expression",
        "#if foo(3)\n#endif\n",
    ),
    error(
        "pp-if-div-zero",
        "a condition that depends on a division by zero",
        "#if 1/0\n#endif\n",
    ),
    error(
        "pp-if-operator",
        "`++` or `--` in a condition",
        "#if ++1\n#endif\n",
    ),
    error(
        "pp-if-range",
        "a number in a condition that does not fit in 64 bits",
        "#if 99999999999999999999\n#endif\n",
    ),
    error(
        "pp-error-directive",
        "an `#error` directive",
        "#error \"stop\"\n",
    ),
    warning(
        "pp-warning-directive",
        "a `#warning` directive",
        "#warning careful\n",
    ),
    error(
        "pp-input",
        "a file that cannot be read",
        "// dotgen check nowhere.gen\n",
    ),
    Code {
        id: "pp-include-place",
        severity: Severity::Error,
        meaning: "a file included in the middle of a declaration",
        example: "const long a =\n#include \"value.h\"\n;\n",
        reference: false,
    },
    Code {
        id: "pp-unknown-directive",
        severity: Severity::Hint,
        meaning: "a directive that is ignored",
        example: "#import \"a.idl\"\n",
        reference: false,
    },
    Code {
        id: "inactive-code",
        severity: Severity::Hint,
        meaning: "text left out by a conditional",
        example: "#if 0\nconst long a = 1;\n#endif\n",
        reference: false,
    },
    Code {
        id: "not-utf8",
        severity: Severity::Warning,
        meaning: "a file that is not UTF-8",
        example: "// a Latin-1 accent\n",
        reference: false,
    },
    error(
        "lex-stray",
        "a character that begins no token",
        "const long a@ = 1;\n",
    ),
    error(
        "lex-comment-open",
        "a block comment without end",
        "/* this never ends\n",
    ),
    error(
        "syntax",
        "something that does not fit the grammar",
        "struct s { };\n",
    ),
    error(
        "syntax-eof",
        "the text ends in the middle of a declaration",
        "struct s {\n",
    ),
    error(
        "missing-semicolon",
        "a declaration without its semicolon",
        "const long a = 1\nconst long b = 2;\n",
    ),
    error(
        "missing-yield",
        "a codel with states that says not where they lead",
        "component c { task t { codel<start> f(); }; };\n",
    ),
];

/// The entry of a code.
pub fn find(id: &str) -> Option<&'static Code> {
    CODES.iter().find(|it| it.id == id)
}
