//! The body of a macro, from the tokens of its `#define`.

use smol_str::SmolStr;

use super::{
    MacroSite,
    env::{DefineProblem, Macro, MacroKind},
};
use crate::{
    directive::{Define, Name},
    kind::SyntaxKind::{self, *},
    lexer::{RawTokens, is_trivia, is_word},
};

/// Whether there is a blank before the token `i`.
pub(crate) fn spaced(raw: &RawTokens, i: usize) -> bool {
    let before = (0..i)
        .rev()
        .map(|i| raw.kind(i))
        .find(|&kind| kind != SPLICE);
    before.is_none_or(is_trivia)
}

/// Most parameters a macro may have (language reference, 2.4).
const MAX_PARAMS: usize = 128;

/// One token of the body of a macro.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct BodyToken {
    pub(crate) kind: SyntaxKind,
    /// Without splices.
    pub(crate) text: SmolStr,
    /// A blank stands before it in the body.
    pub(crate) spaced: bool,
    pub(crate) role: Role,
}

/// What a body token does when the macro is expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Role {
    /// Copied.
    Plain,
    /// Replaced by the argument of this parameter; `__VA_ARGS__` comes after the named ones.
    Param(u32),
    /// Replaced by a string of the argument of this parameter.
    Stringize(u32),
    /// Joins its neighbours.
    Paste,
}

impl BodyToken {
    /// A token that is copied.
    pub(crate) fn plain(text: &str, raw: &RawTokens, i: u32) -> BodyToken {
        let i = i as usize;
        BodyToken {
            kind: raw.kind(i),
            text: SmolStr::new(raw.clean_text(text, i)),
            spaced: spaced(raw, i),
            role: Role::Plain,
        }
    }

    pub(crate) fn is_paste(&self) -> bool {
        self.role == Role::Paste
    }
}

/// The macro that a `#define` gives, as far as it can be understood, and what is wrong with it.
pub(crate) fn lower_define(
    text: &str,
    raw: &RawTokens,
    define: &Define,
    file: Option<&SmolStr>,
) -> (Option<Macro>, Vec<DefineProblem>) {
    let mut problems = Vec::new();
    let Some(name) = &define.name else {
        problem(
            &mut problems,
            BAD,
            "`#define` must be followed by the name of a macro",
        );
        return (None, problems);
    };
    if name.text.contains('-') {
        // One of the hyphenated keywords, which the preprocessor does not know.
        problem(
            &mut problems,
            BAD,
            format!("the name of a macro cannot have a hyphen: `{}`", name.text),
        );
        return (None, problems);
    }

    let kind = match &define.params {
        None => {
            if define.glued {
                problem(
                    &mut problems,
                    BAD,
                    format!(
                        "a blank is missing between the macro `{}` and its body",
                        name.text
                    ),
                );
            }
            MacroKind::Object
        }
        Some(params) => {
            if !params.well_formed {
                problem(
                    &mut problems,
                    BAD,
                    format!(
                        "the parameter list of the macro `{}` is broken: expected names separated \
                         by commas, then `)`",
                        name.text
                    ),
                );
            } else if params.names.len() > MAX_PARAMS {
                problem(
                    &mut problems,
                    BAD,
                    format!(
                        "the macro `{}` has more than {MAX_PARAMS} parameters",
                        name.text
                    ),
                );
            }
            let names = &params.names[..params.names.len().min(MAX_PARAMS)];
            for (i, param) in names.iter().enumerate() {
                if names[..i].iter().any(|it| it.text == param.text) {
                    problem(
                        &mut problems,
                        "pp-define-dup-param",
                        format!(
                            "the macro `{}` has two parameters `{}`",
                            name.text, param.text
                        ),
                    );
                    break;
                }
            }
            MacroKind::Function {
                params: names.iter().map(|it| it.text.clone()).collect(),
                variadic: params.variadic,
            }
        }
    };
    let body = lower_body(text, raw, define, &kind, name, &mut problems);
    let site = MacroSite {
        file: file.cloned(),
        ordinal: define.ordinal,
    };
    (
        Some(Macro {
            name: name.text.clone(),
            kind,
            body,
            site,
        }),
        problems,
    )
}

const BAD: &str = "pp-define-bad";

fn problem(problems: &mut Vec<DefineProblem>, code: &'static str, message: impl Into<String>) {
    problems.push(DefineProblem {
        code,
        message: message.into(),
    });
}

fn lower_body(
    text: &str,
    raw: &RawTokens,
    define: &Define,
    kind: &MacroKind,
    name: &Name,
    problems: &mut Vec<DefineProblem>,
) -> Vec<BodyToken> {
    let (params, variadic) = match kind {
        MacroKind::Function { params, variadic } => (Some(params), *variadic),
        _ => (None, false),
    };
    let mut body: Vec<BodyToken> = define
        .body
        .clone()
        .filter(|&i| !is_trivia(raw.kind(i as usize)))
        .map(|i| BodyToken::plain(text, raw, i))
        .collect();
    if let Some(first) = body.first_mut() {
        first.spaced = false;
    }

    for token in &mut body {
        if token.kind == HASH2 {
            token.role = Role::Paste;
        } else if is_word(token.kind, &token.text) {
            let param = params.and_then(|it| it.iter().position(|param| *param == token.text));
            if let Some(param) = param {
                token.role = Role::Param(param as u32);
            } else if token.text == "__VA_ARGS__" {
                if variadic {
                    token.role = Role::Param(params.map_or(0, Vec::len) as u32);
                } else if problems.is_empty() {
                    problem(
                        problems,
                        "pp-va-args",
                        format!(
                            "`__VA_ARGS__` in the macro `{}`, whose parameters do not end in `...`",
                            name.text
                        ),
                    );
                }
            }
        }
    }

    if params.is_some() {
        let mut lowered: Vec<BodyToken> = Vec::with_capacity(body.len());
        let mut hash: Option<BodyToken> = None;
        for mut token in body {
            if let Some(hash) = hash.take() {
                if let Role::Param(param) = token.role {
                    token.role = Role::Stringize(param);
                    token.spaced = hash.spaced;
                } else if problems.is_empty() {
                    problem(
                        problems,
                        "pp-stringize",
                        format!("`#` in the macro `{}` must precede a parameter", name.text),
                    );
                }
            }
            if token.kind == HASH && token.role == Role::Plain {
                hash = Some(token);
            } else {
                lowered.push(token);
            }
        }
        if hash.is_some() && problems.is_empty() {
            problem(
                problems,
                "pp-stringize",
                format!("`#` in the macro `{}` must precede a parameter", name.text),
            );
        }
        body = lowered;
    }

    let edge = |it: Option<&BodyToken>| it.is_some_and(BodyToken::is_paste);
    if edge(body.first()) || edge(body.last()) {
        if problems.is_empty() {
            problem(
                problems,
                BAD,
                format!(
                    "`##` is first or last in the body of the macro `{}`",
                    name.text
                ),
            );
        }
        while edge(body.first()) {
            body.remove(0);
        }
        while edge(body.last()) {
            body.pop();
        }
    }
    body
}
