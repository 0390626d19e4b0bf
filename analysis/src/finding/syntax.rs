//! What mends findings of the lexer, the preprocessor and the parser.

use dotgen_syntax::{
    SyntaxError,
    finding::{parsing::Parsing, preprocessing::Preprocessing},
};

use crate::fixes::{Place, TextFix, missing_brace};

/// What mends a finding of the lexer or preprocessor.
pub(super) fn preprocessing(it: &Preprocessing, here: &Place<'_>) -> Vec<TextFix> {
    match it {
        Preprocessing::Stray { .. } | Preprocessing::Control { .. } => vec![here.remove()],
        Preprocessing::ByteOrderMark => vec![here.remove_as("Remove the byte order mark")],
        _ => Vec::new(),
    }
}

/// What mends a finding of the parser.
pub(super) fn parsing(it: &SyntaxError, here: &Place<'_>) -> Vec<TextFix> {
    let fix = match &it.kind {
        _ if it.missing.is_some() => missing_brace(here.root, it),
        Parsing::NoSemicolon { .. }
        | Parsing::NoSemicolonAtEnd { .. }
        | Parsing::NoSemicolonOrQuote { .. } => here.add_semicolon(),
        Parsing::NoYield { .. } => here.add_yield_list(),
        _ => None,
    };
    fix.into_iter().collect()
}
