//! The body of a macro, from the tokens of its `#define`.

use smol_str::SmolStr;

use super::{
    MacroSite,
    definition::{BodyToken, Macro, MacroKind, Role},
};
use crate::{
    directive::{Define, Name},
    finding::preprocessing::Preprocessing,
    kind::SyntaxKind::*,
    lexer::{RawTokens, is_trivia, is_word},
};

/// Maximum number of parameters of a macro (language reference, 2.4).
const MAX_PARAMS: usize = 128;

/// The macro that a `#define` defines, as far as it is valid, and its errors.
pub(crate) fn lower_define(
    text: &str,
    raw: &RawTokens,
    define: &Define,
    file: Option<&SmolStr>,
) -> (Option<Macro>, Vec<Preprocessing>) {
    let mut problems = Vec::new();
    let Some(name) = &define.name else {
        problems.push(Preprocessing::DefineWithoutName);
        return (None, problems);
    };
    if name.text.contains('-') {
        // One of the hyphenated keywords, which the preprocessor does not know.
        problems.push(Preprocessing::Hyphen { name: name.text.clone() });
        return (None, problems);
    }

    let kind = match &define.params {
        None => {
            if define.glued {
                problems.push(Preprocessing::NoBlank { name: name.text.clone() });
            }
            MacroKind::Object
        }
        Some(params) => {
            if !params.well_formed {
                problems.push(Preprocessing::BrokenParameters { name: name.text.clone() });
            } else if params.names.len() > MAX_PARAMS {
                problems.push(Preprocessing::TooManyParameters {
                    name: name.text.clone(),
                    most: MAX_PARAMS,
                });
            }
            let names = &params.names[..params.names.len().min(MAX_PARAMS)];
            for (i, param) in names.iter().enumerate() {
                if names[..i].iter().any(|name| name.text == param.text) {
                    problems.push(Preprocessing::ParameterTwice {
                        name: name.text.clone(),
                        param: param.text.clone(),
                    });
                    break;
                }
            }
            MacroKind::Function {
                params: names.iter().map(|name| name.text.clone()).collect(),
                variadic: params.variadic,
            }
        }
    };
    let body = lower_body(text, raw, define, &kind, name, &mut problems);
    let site = MacroSite { file: file.cloned(), ordinal: define.ordinal };
    (Some(Macro { name: name.text.clone(), kind, body, site }), problems)
}

fn lower_body(
    text: &str,
    raw: &RawTokens,
    define: &Define,
    kind: &MacroKind,
    name: &Name,
    problems: &mut Vec<Preprocessing>,
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
            let param = params.and_then(|node| node.iter().position(|param| *param == token.text));
            if let Some(param) = param {
                token.role = Role::Param(param as u32);
            } else if token.text == "__VA_ARGS__" {
                if variadic {
                    token.role = Role::Param(params.map_or(0, Vec::len) as u32);
                } else if problems.is_empty() {
                    problems.push(Preprocessing::NotVariadic { name: name.text.clone() });
                }
            }
        }
    }

    if params.is_some() {
        body = stringized(body, name, problems);
    }

    let edge = |token: Option<&BodyToken>| token.is_some_and(BodyToken::is_paste);
    if edge(body.first()) || edge(body.last()) {
        if problems.is_empty() {
            problems.push(Preprocessing::PasteAtEdge { name: name.text.clone() });
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

/// The body with each `#` and its parameter as one token.
fn stringized(
    body: Vec<BodyToken>,
    name: &Name,
    problems: &mut Vec<Preprocessing>,
) -> Vec<BodyToken> {
    let mut lowered: Vec<BodyToken> = Vec::with_capacity(body.len());
    let mut hash: Option<BodyToken> = None;
    for mut token in body {
        if let Some(hash) = hash.take() {
            if let Role::Param(param) = token.role {
                token.role = Role::Stringize(param);
                token.spaced = hash.spaced;
            } else if problems.is_empty() {
                problems.push(Preprocessing::Stringize { name: name.text.clone() });
            }
        }
        if token.kind == HASH && token.role == Role::Plain {
            hash = Some(token);
        } else {
            lowered.push(token);
        }
    }
    if hash.is_some() && problems.is_empty() {
        problems.push(Preprocessing::Stringize { name: name.text.clone() });
    }
    lowered
}
