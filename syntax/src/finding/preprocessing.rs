//! Findings of the lexer and the preprocessor.

use std::fmt;

use smol_str::SmolStr;

use crate::packages;

/// The directories in which an included file was searched.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SearchedDirectories(pub Vec<String>);

impl fmt::Display for SearchedDirectories {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join(", "))
    }
}

/// A number of arguments of a macro.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Arguments {
    /// The count.
    pub count: usize,
    /// True if more arguments are allowed.
    pub open: bool,
}

impl fmt::Display for Arguments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at_least = if self.open { "at least " } else { "" };
        let plural = if self.count == 1 { "" } else { "s" };
        write!(f, "{at_least}{} argument{plural}", self.count)
    }
}

/// The packages to install.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PackagesToInstall(pub Vec<SmolStr>);

impl fmt::Display for PackagesToInstall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("install ")?;
        let mut first = true;
        for argument in &self.0 {
            for name in packages::names(argument) {
                let or = if first { "" } else { "; " };
                write!(f, "{or}{}", packages::advice(name))?;
                first = false;
            }
        }
        f.write_str("; until then, what comes from there is unknown")
    }
}

findings! {
    /// Something wrong with the characters or directives of a file.
    pub enum Preprocessing {
        "pp-include-not-found" NotFound { path: SmolStr } => "cannot find the file `{path}`";
        "pp-include-not-found" NotFoundIn { path: SmolStr, searched: SearchedDirectories }
            => "cannot find the file `{path}`, searched in {searched}",
               "add its directory to the include path";
        "pp-include-not-found" NotIncluded { path: SmolStr, why: SmolStr }
            => "cannot include the file `{path}`: {why}";
        "pp-include-depth" TooDeep { path: SmolStr }
            => "including the file `{path}` would open more than 100 files at once: does it include \
                itself?";
        "pp-include-bad" IncludeWithoutFile
            => "`#include` must be followed by `\"file\"`, `<file>`, or a macro that stands for one of \
                them";
        "pp-include-bad" IncludeWithMore => "nothing may follow the name of the file in an `#include`";

        "pp-define-bad" DefineWithoutName => "`#define` must be followed by the name of a macro";
        "pp-define-bad" Hyphen { name: SmolStr }
            => "the name of a macro cannot have a hyphen: `{name}`";
        "pp-define-bad" NoBlank { name: SmolStr }
            => "a blank is missing between the macro `{name}` and its body";
        "pp-define-bad" BrokenParameters { name: SmolStr }
            => "the parameter list of the macro `{name}` is broken: expected names separated by commas, \
                then `)`";
        "pp-define-bad" TooManyParameters { name: SmolStr, most: usize }
            => "the macro `{name}` has more than {most} parameters";
        "pp-define-bad" PasteAtEdge { name: SmolStr }
            => "`##` is first or last in the body of the macro `{name}`";
        "pp-define-dup-param" ParameterTwice { name: SmolStr, param: SmolStr }
            => "the macro `{name}` has two parameters `{param}`";
        "pp-va-args" NotVariadic { name: SmolStr }
            => "`__VA_ARGS__` in the macro `{name}`, whose parameters do not end in `...`";
        "pp-stringize" Stringize { name: SmolStr }
            => "`#` in the macro `{name}` must precede a parameter";
        "pp-redefined" Redefined { name: SmolStr }
            => "the macro `{name}` is defined again with another body", "this one is used from here on";
        "pp-undef-bad" UndefWithoutName => "`#undef` must be followed by the name of a macro";

        "pp-macro-args" WrongArguments { name: SmolStr, takes: Arguments, given: usize }
            => "the macro `{name}` takes {takes}, {given} given";
        "pp-macro-eof" OpenCall { name: SmolStr }
            => "the call of the macro `{name}` has no closing parenthesis";
        "pp-macro-eof" DirectiveInCall { name: SmolStr }
            => "a directive inside the arguments of the macro `{name}`: close the call before it";
        "pp-macro-limit" TooManyTokens { name: SmolStr }
            => "the macros of this file expand to too many tokens", "the last one was `{name}`";
        "pp-macro-limit" TooManyCalls { most: usize }
            => "more than {most} macro calls inside one another";

        "pp-ifdef-bad" IfdefWithoutName { keyword: SmolStr }
            => "`#{keyword}` must be followed by the name of a macro";
        "pp-extra-tokens" MoreThanAName { keyword: SmolStr }
            => "`#{keyword}` takes exactly one name: remove what follows it";
        "pp-extra-tokens-tail" Tail { keyword: SmolStr }
            => "`#{keyword}` takes nothing: make what follows it a comment";
        "pp-no-newline" NoLineEnd { keyword: SmolStr }
            => "the file ends on `#{keyword}` without a line end";
        "pp-cond-unterminated" OpenConditional
            => "the file ends inside a conditional: an `#endif` is missing";
        "pp-else-without-if" ElseWithoutIf => "`#else` without `#if` before it";
        "pp-elif-without-if" ElifWithoutIf => "`#elif` without `#if` before it";
        "pp-endif-without-if" EndifWithoutIf => "`#endif` without `#if` before it";
        "pp-else-twice" ElseTwice => "a second `#else` in the same conditional";
        "pp-if-div-zero" DivisionByZero => "division by zero in the condition";
        "pp-if-operator" BadOperator { operator: SmolStr }
            => "`{operator}` cannot be used in a condition";
        "pp-if-range" TooLarge { number: SmolStr } => "the integer `{number}` does not fit in 64 bits";
        "pp-if-syntax" Unexpected { found: SmolStr } => "unexpected {found} in the condition";
        "pp-if-syntax" DefinedWithoutName => "`defined` must be followed by a name";
        "pp-if-syntax" BadToken { token: SmolStr } => "`{token}` cannot stand in a condition";
        "pp-if-syntax" NoInteger { text: SmolStr } => "`{text}` is not an integer";
        "pp-if-syntax" NoCharacter { text: SmolStr } => "{text} is not a character constant";
        "pp-if-syntax" TooNested => "the condition is nested too deeply";
        "pp-if-syntax" NoColon => "`?` without `:` in the condition";
        "pp-if-syntax" NoChain { operator: SmolStr } => "`{operator}` does not chain: use parentheses";
        "pp-if-syntax" NoParenthesis => "a `)` is missing in the condition";
        "pp-if-syntax" NoValue { found: SmolStr }
            => "expected a value in the condition, found {found}";
        "pp-if-syntax" EmptyCondition => "the condition is missing";
        "pp-if-syntax" ShortCondition => "the condition ends where a value is expected";

        "pp-error-directive" ErrorDirective { text: SmolStr } => "{text}";
        "pp-warning-directive" WarningDirective { text: SmolStr } => "{text}";
        "pp-line-bad" BadLine
            => "`#line` must be followed by a line number and, optionally, a file name in quotes";
        "pp-pragma-bad" EmptyPragma => "`#pragma` must be followed by a word";
        "pp-pragma-operator" PragmaOperator
            => "`_Pragma` takes exactly one string in parentheses: `_Pragma(\"…\")`";
        "pp-requires-empty" EmptyRequires { word: SmolStr }
            => "`#pragma {word}` must be followed by a package";
        "pp-requires-many" ManyRequired { word: SmolStr, most: usize, given: usize }
            => "`#pragma {word}` takes at most {most} arguments, {given} given: use several pragmas, and \
                quotes around a package with its version";
        "pp-requires-unresolved" Unresolved { why: SmolStr, install: PackagesToInstall } => "{why}", "{install}";
        "pp-requires-own" OwnInterfaces { package: SmolStr }
            => "package `{package}` is not installed: the definitions that come with dotgen are used, whatever \
                version is required";
        "pp-misspelt-directive" Misspelt { word: SmolStr, meant: &'static str }
            => "no directive is called `{word}`", "did you mean `{meant}`?";
        "pp-unknown-directive" UnknownDirective { word: SmolStr }
            => "unknown directive `#{word}`: the line is ignored";

        "lex-stray" ByteOrderMark => "a byte order mark: save the file without it";
        "lex-stray" StrayHash { shown: SmolStr }
            => "`{shown}` is not at the beginning of a line: directives are lines of their own";
        "lex-stray" Stray { shown: SmolStr } => "`{shown}` cannot stand here: remove it";
        "lex-stray" NotAscii { shown: SmolStr }
            => "`{shown}` is only allowed in comments and strings: names are ASCII";
        "pp-bad-char" Control { shown: SmolStr } => "`{shown}` cannot stand here: remove it";
        "lex-stray" TooMany => "too many errors in this file: the others are not shown";
        "lex-comment-open" OpenComment => "this comment has no end: `*/` is missing";
    }
}

impl Preprocessing {
    /// The message of the reference compiler, if it has its own words for this finding.
    pub fn reference(&self) -> String {
        match self {
            Self::NotFoundIn { path, searched } => {
                format!(
                    "cannot find '{path}'\n  searched in {searched}; add its directory to the include path"
                )
            }
            Self::Unresolved { .. } => self.wording().plain(),
            _ => self.wording().plain_with_advice(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Preprocessing;

    #[test]
    fn the_lines_of_the_compiler_keep_the_advice_without_marks() {
        let redefined = Preprocessing::Redefined { name: "A".into() };
        assert_eq!(
            redefined.reference(),
            "the macro A is defined again with another body; this one is used from here on"
        );
        let misspelt = Preprocessing::Misspelt { word: "includ".into(), meant: "include" };
        assert_eq!(misspelt.reference(), "no directive is called includ; did you mean include?");
    }
}
