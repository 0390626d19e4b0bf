//! The fixes for findings of the lexer, the preprocessor and the parser.

use dotgen_syntax::{SyntaxError, finding::preprocessing::Preprocessing};

use crate::fixes::{FixSite, TextFix, missing_brace};

/// The fixes for a finding of the lexer or preprocessor.
pub(super) fn preprocessing(preprocessing: &Preprocessing, here: &FixSite<'_>) -> Vec<TextFix> {
    match preprocessing {
        Preprocessing::Stray { .. } | Preprocessing::Control { .. } => vec![here.remove().plain()],
        Preprocessing::Misspelt { meant, .. } => vec![here.replace(meant)],
        Preprocessing::ByteOrderMark => vec![here.remove_as("Remove the byte order mark").plain()],
        _ => Vec::new(),
    }
}

/// The fixes for a finding of the parser.
pub(super) fn parsing(syntax_error: &SyntaxError, here: &FixSite<'_>) -> Vec<TextFix> {
    let fix = match &syntax_error.repair {
        _ if syntax_error.missing.is_some() => missing_brace(here.root, syntax_error),
        Some(repair) => Some(here.repair(repair)),
        None => None,
    };
    fix.into_iter().collect()
}
