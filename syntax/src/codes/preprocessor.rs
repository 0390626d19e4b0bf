//! Codes of the preprocessor and of reading files.

use super::{Code, error, hint, ours, warning};

pub(super) const CODES: &[Code] = &[
    error(
        "pp-include-not-found",
        "An included file is in none of the searched places.",
        "The types and interfaces of the file are unknown, so everything that uses them is unknown \
         too.",
        "Correct the name, add the directory with `-I` or `include-paths` in `dotgen.toml`, or require \
         the package that contains the file: `#pragma requires`. A name in `<…>` is not searched next \
         to the including file.",
        "#include \"nowhere.idl\"\n",
        "",
    ),
    error(
        "pp-include-bad",
        "`#include` has no file name, or something follows the name.",
        "Only one name in `\"…\"` or `<…>`, or a macro that yields one, can be included.",
        "Put the name in quotes, and nothing after it.",
        "#include nowhere.idl\n",
        "#include \"node.idl\"\n",
    ),
    error(
        "pp-include-depth",
        "More than 100 files are open at the same time.",
        "A file includes itself, directly or through others, without an end.",
        "Put an include guard around the file: `#ifndef`, `#define`, `#endif`. `#pragma once` has no \
         effect.",
        "// in self.gen\n#include \"self.gen\"\n",
        "// in self.gen\n#ifndef SELF_GEN\n#define SELF_GEN\n#include \"self.gen\"\n#endif\n",
    ),
    error(
        "pp-define-bad",
        "A `#define` is malformed.",
        "Without a name and a complete parameter list, nothing can be replaced.",
        "Write `#define NAME text` or `#define NAME(a, b) text`, with the `(` directly after the name. \
         `##` cannot be first or last in the text.",
        "#define 3\n",
        "#define THREE 3\n",
    ),
    error(
        "pp-define-dup-param",
        "A macro has two parameters with the same name.",
        "A use of the name could mean either argument.",
        "Rename one of the parameters.",
        "#define F(x, x) x\n",
        "#define F(x, y) x\n",
    ),
    error(
        "pp-va-args",
        "`__VA_ARGS__` is used in a macro without `...`.",
        "The name stands for the arguments that `...` takes.",
        "Add `...` at the end of the parameters, or use a named parameter.",
        "#define F(x) __VA_ARGS__\n",
        "#define F(x, ...) __VA_ARGS__\n",
    ),
    error(
        "pp-stringize",
        "`#` in a macro is not followed by one of its parameters.",
        "`#` makes a string of an argument, so an argument has to follow.",
        "Write a parameter after `#`, or remove the `#`.",
        "#define F(x) #y\n",
        "#define F(x) #x\n",
    ),
    warning(
        "pp-redefined",
        "A macro is defined again with another body.",
        "From here on the second definition counts. Files that were written for the first one silently \
         get the other value.",
        "Rename one of the macros, or write `#undef` before the second definition.",
        "#define N 4\n#define N 5\n",
        "#define N 4\n#undef N\n#define N 5\n",
    ),
    error(
        "pp-undef-bad",
        "`#undef` has no name.",
        "Nothing says which macro to forget.",
        "Write the name of the macro.",
        "#undef 3\n",
        "#undef THREE\n",
    ),
    error(
        "pp-line-bad",
        "`#line` is not followed by a number.",
        "The directive gives a line number and, if wanted, a file name in quotes.",
        "Write `#line 10 \"file.gen\"`, or remove the directive: dotgen always reports the real \
         positions.",
        "#line \"x\"\n",
        "#line 10 \"x\"\n",
    ),
    error(
        "pp-macro-args",
        "A macro is called with the wrong number of arguments.",
        "A parameter would have no text, or an argument no parameter. A comma outside parentheses \
         separates arguments.",
        "Give as many arguments as the macro has parameters. Put an argument that contains a comma in \
         parentheses.",
        "#define F(x, y) x\nconst long a = F(1);\n",
        "#define F(x, y) x\nconst long a = F(1, 2);\n",
    ),
    error(
        "pp-macro-eof",
        "The file ends inside the arguments of a macro call.",
        "The `)` is missing, so the rest of the file was read as an argument.",
        "Close the call with `)`.",
        "#define F(x) x\nconst long a = F(1\n",
        "#define F(x) x\nconst long a = F(1);\n",
    ),
    error(
        "pp-macro-limit",
        "The expansion of a macro is too large or too deep.",
        "Macros that use each other several times grow exponentially. The limit keeps the reader from \
         running out of memory.",
        "Write the text with fewer nested macros.",
        "// a macro that doubles itself, many times over\n",
        "",
    ),
    error(
        "pp-bad-char",
        "The text contains a control character with a code from 1 to 4.",
        "The preprocessor uses these characters for itself. They usually come from a damaged or binary \
         file.",
        "Delete the character.",
        "// a byte with code 1 to 4\n",
        "",
    ),
    error(
        "pp-pragma-bad",
        "`#pragma` has nothing after it.",
        "A pragma is known by its first word.",
        "Write the pragma, such as `#pragma requires \"package\"`, or remove the line.",
        "#pragma\n",
        "#pragma requires \"demo-idl\"\n",
    ),
    error(
        "pp-pragma-operator",
        "The argument of `_Pragma` is not one string.",
        "The content of the string becomes a `#pragma` line.",
        "Put the pragma in quotes, with `\\\"` for the quotes in it.",
        "_Pragma(requires)\n",
        "_Pragma(\"requires \\\"demo-idl\\\"\")\n",
    ),
    error(
        "pp-requires-empty",
        "`#pragma requires` names no package.",
        "The pragma makes the files of a package available. Without a name there is nothing to look \
         for.",
        "Write the name of the package, or remove the line.",
        "#pragma requires\n",
        "#pragma requires \"demo-idl\"\n",
    ),
    error(
        "pp-requires-many",
        "`#pragma requires` has more than eight arguments.",
        "The reference compiler reads at most eight.",
        "Put the other packages in a second `#pragma requires`.",
        "#pragma requires a b c d e f g h i\n",
        "#pragma requires a b c d e f g h\n#pragma requires i\n",
    ),
    error(
        "pp-requires-unresolved",
        "A package is not installed, or not in a suitable version.",
        "The files of the package cannot be included, so their types and interfaces are unknown.",
        "Install the package, or add the directory with its `.pc` file to `package-paths` in \
         `dotgen.toml`. `dotgen deps` lists what is missing and how to install it.",
        "#pragma requires \"missing\"\n",
        "",
    ),
    hint(
        "pp-requires-own",
        "A package is not installed, and its interfaces come with dotgen.",
        "The specification is checked with dotgen's own definitions of these interfaces. GenoM3 itself \
         needs the package.",
        "Install the package to work with its files. For a file that is not found in dotgen's definitions, \
         `dotgen deps` says what to install.",
        "#pragma requires \"openrobots2-idl\"\n",
        "",
    ),
    error(
        "pp-cond-unterminated",
        "A conditional is still open at the end of the file.",
        "Until the group is closed, nothing says which lines belong to it. A conditional has to end in \
         the file in which it begins.",
        "Add the missing `#endif`.",
        "#if 1\n",
        "#if 1\n#endif\n",
    ),
    error(
        "pp-else-without-if",
        "`#else` stands outside a conditional.",
        "No `#if` is open that it could be the other part of. Its `#endif` may stand too early.",
        "Add the missing `#if`, or remove the `#else`.",
        "#else\n",
        "#if 1\n#else\n#endif\n",
    ),
    error(
        "pp-elif-without-if",
        "`#elif` stands outside a conditional.",
        "No `#if` is open that it could continue. Its `#endif` may stand too early.",
        "Write `#if`, or remove the line.",
        "#elif 1\n",
        "#if 1\n#endif\n",
    ),
    error(
        "pp-endif-without-if",
        "`#endif` stands outside a conditional.",
        "No `#if` is open that it could close. There may be one `#endif` too many above.",
        "Add the missing `#if`, or remove the `#endif`.",
        "#endif\n",
        "#if 1\n#endif\n",
    ),
    error(
        "pp-else-twice",
        "A conditional has a second `#else`.",
        "Nothing says when the lines after it count.",
        "Use `#elif` for the first of the two, or remove one.",
        "#if 1\n#else\n#else\n#endif\n",
        "#if 1\n#elif 0\n#else\n#endif\n",
    ),
    error(
        "pp-extra-tokens",
        "Something follows the name of `#ifdef`, `#ifndef` or `#undef`.",
        "These directives test or remove one name; the rest would have no effect.",
        "Remove the rest, or write the condition with `#if defined(A) && defined(B)`.",
        "#ifdef A B\n#endif\n",
        "#if defined(A) && defined(B)\n#endif\n",
    ),
    warning(
        "pp-extra-tokens-tail",
        "Something follows `#else` or `#endif`.",
        "The rest of the line is ignored. It may be a condition that was meant for `#elif`.",
        "Put the name in a comment (`#endif // FOO`), or use `#elif`.",
        "#if 1\n#endif FOO\n",
        "#if 1\n#endif // FOO\n",
    ),
    warning(
        "pp-no-newline",
        "The file ends on an `#else` or `#endif` without a line end.",
        "`genom3` warns about `#else` and `#endif` at the very end, and misreads other directives \
         there.",
        "Add a line end.",
        "#if 1\n#endif",
        "#if 1\n#endif\n",
    ),
    error(
        "pp-ifdef-bad",
        "`#ifdef` or `#ifndef` has no name.",
        "The directive asks whether a macro is defined, so it needs the name of one.",
        "Write the name of a macro, or use `#if` for an expression.",
        "#ifdef 3\n#endif\n",
        "#if 3\n#endif\n",
    ),
    error(
        "pp-if-syntax",
        "The condition of an `#if` or `#elif` is not an expression.",
        "The condition has to give a number. A name that is not a macro counts as 0 and cannot be \
         called.",
        "Correct the expression. Test whether a macro exists with `defined(NAME)`.",
        "#if foo(3)\n#endif\n",
        "#if defined(foo)\n#endif\n",
    ),
    error(
        "pp-if-div-zero",
        "A condition depends on a division by zero.",
        "The condition has no value, so neither branch can be chosen.",
        "Correct the divisor, or test it first: `N && 8 / N`.",
        "#if 1/0\n#endif\n",
        "#if 1/1\n#endif\n",
    ),
    error(
        "pp-if-operator",
        "`++` or `--` stands in a condition.",
        "A condition has no variables that could be counted up.",
        "Write `+ 1` or `- 1`.",
        "#if ++1\n#endif\n",
        "#if 1 + 1\n#endif\n",
    ),
    error(
        "pp-if-range",
        "A number in a condition does not fit in 64 bits.",
        "Conditions are computed with 64-bit integers.",
        "Use a smaller number.",
        "#if 99999999999999999999\n#endif\n",
        "#if 999999999999\n#endif\n",
    ),
    error(
        "pp-error-directive",
        "An `#error` directive is reached.",
        "The author of the file wants it to fail in this configuration. The text after `#error` gives \
         the reason.",
        "Define the macros that the surrounding conditional expects (`-D NAME`, or `defines` in \
         `dotgen.toml`), or remove the directive.",
        "#error \"stop\"\n",
        "",
    ),
    warning(
        "pp-warning-directive",
        "A `#warning` directive is reached.",
        "The author of the file wants to be heard in this configuration. The text after `#warning` \
         gives the reason.",
        "Follow the text. Remove the directive when it no longer applies.",
        "#warning careful\n",
        "",
    ),
    error(
        "pp-input",
        "A file cannot be read.",
        "It does not exist, is a directory, or may not be read. Nothing in it is checked.",
        "Correct the path or the permissions.",
        "// dotgen check nowhere.gen\n",
        "",
    ),
    ours(error(
        "pp-include-place",
        "A file is included in the middle of a declaration.",
        "`genom3` accepts this. dotgen reads each file on its own and cannot put the two halves of a \
         declaration together.",
        "Write the declaration in one file, and include files between declarations.",
        "const long a =\n#include \"value.h\"\n;\n",
        "#include \"value.h\"\nconst long a = VALUE;\n",
    )),
    ours(error(
        "pp-misspelt-directive",
        "The word of a directive or pragma is misspelt.",
        "GenoM3 ignores a directive or pragma that it does not know, without a message: a file is not included, a \
         package not required, a macro not defined.",
        "Correct the word. The directive is read as the one that was meant.",
        "#defnie AXES 2\nconst long axes = AXES;\n",
        "#define AXES 2\nconst long axes = AXES;\n",
    )),
    ours(hint(
        "pp-unknown-directive",
        "A directive is ignored because its name is unknown.",
        "The preprocessor drops the whole line without an error, even if only the name is mistyped.",
        "Correct the name (`#include`), or remove the line.",
        "#import \"a.idl\"\n",
        "#include \"a.idl\"\n",
    )),
    ours(hint(
        "inactive-code",
        "A conditional leaves out this text.",
        "Nothing in it is checked, and no component gets it. Editors fade it.",
        "Nothing, if it is intended. Otherwise define the macro that the condition tests (`-D NAME`, \
         or `defines` in `dotgen.toml`).",
        "#if 0\nconst long a = 1;\n#endif\n",
        "#if 1\nconst long a = 1;\n#endif\n",
    )),
    ours(warning(
        "not-utf8",
        "A file is not UTF-8.",
        "Accents in its comments and strings come out wrong in editors, generated code and \
         documentation.",
        "Save the file as UTF-8.",
        "// a Latin-1 accent\n",
        "",
    )),
];
