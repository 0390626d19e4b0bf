//! From a text to its tree: lexer, preprocessor, grammar ([`crate::parser`]), tree (`sink`). Parsing never
//! fails: the result is a tree that holds the whole text, and errors.

use rowan::GreenNode;

use crate::{
    ExpansionMap, SyntaxNode, TextRange, TextSize,
    ast::{AstNode, SourceFile},
    fragment::Fragment,
    lexer::{self, RawTokens},
    parser::{self, SyntaxError},
    preproc::{MacroEnv, NoIncludes, Preprocessed, preprocess},
    sink,
};

/// The result of parsing one file: always a tree whose text is the text of the file, and the errors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parse {
    /// The tree.
    pub green: GreenNode,
    /// In text order.
    pub errors: Vec<SyntaxError>,
    /// Texts of the tokens that come out of macros.
    pub expansion: ExpansionMap,
    /// Offset from which code and strings seem to be exchanged, because a quote is missing. Syntax errors
    /// beyond it are not in `errors`.
    pub inside_out: Option<TextSize>,
    /// Offset from which errors are not listed, because there are too many.
    pub unlisted: Option<TextSize>,
}

impl Parse {
    /// The ranges that do not parse: the ranges of the errors, and the text beyond the last listed one.
    pub fn broken(&self) -> Vec<TextRange> {
        let mut broken: Vec<TextRange> = self.errors.iter().map(|error| error.range).collect();
        let from = self.inside_out.into_iter().chain(self.unlisted).min();
        let end = self.syntax().text_range().end();
        broken.extend(from.filter(|from| *from < end).map(|from| TextRange::new(from, end)));
        broken
    }

    /// The root of the tree, of kind `SOURCE_FILE`.
    pub fn syntax(&self) -> SyntaxNode {
        SyntaxNode::new_root(self.green.clone())
    }

    /// The root as a typed node.
    pub fn tree(&self) -> SourceFile {
        SourceFile::cast(self.syntax()).expect("every parse makes a SOURCE_FILE")
    }
}

/// Parses one file from its raw tokens and the output of the preprocessor.
///
/// `raw` and `pre` must belong to this `text`. The errors of the preprocessor are not repeated.
pub fn parse(text: &str, raw: &RawTokens, pre: &Preprocessed, fragment: Fragment) -> Parse {
    let said = parser::read(text, raw, pre, fragment);
    let (green, expansion, of_directives) = sink::build(text, raw, pre, said.events);
    let mut errors = said.errors;
    if !of_directives.is_empty() {
        errors.extend(of_directives);
        errors.sort_by_key(|error| error.range.start());
    }
    Parse { green, errors, expansion, inside_out: said.inside_out, unlisted: said.unlisted }
}

/// Parses a text on its own: includes are not followed, and only the standard macros are predefined. For
/// tests and simple tools; the errors of the preprocessor are left out.
pub fn parse_text(text: &str) -> Parse {
    let raw = lexer::lex(text);
    let pre = preprocess(&"".into(), text, &raw, MacroEnv::default(), &mut NoIncludes);
    parse(text, &raw, &pre, Fragment::Specification)
}
