//! Semantic tokens: the legend, and the relative encoding of the protocol.

use dotgen_analysis::ide::{SemanticToken as Token, TokenType};

use super::Lines;
use crate::protocol::types::{
    SemanticToken, SemanticTokenModifier, SemanticTokenType, SemanticTokensLegend,
};

/// Names in the order of [`TokenType`]; standard names if the protocol has one.
const TYPES: [SemanticTokenType; TokenType::Directive as usize + 1] = [
    SemanticTokenType::COMMENT,
    SemanticTokenType::KEYWORD,
    SemanticTokenType::STRING,
    SemanticTokenType::NUMBER,
    SemanticTokenType::OPERATOR,
    SemanticTokenType::MACRO,
    SemanticTokenType::NAMESPACE,
    SemanticTokenType::TYPE,
    SemanticTokenType::STRUCT,
    SemanticTokenType::ENUM,
    SemanticTokenType::ENUM_MEMBER,
    SemanticTokenType::INTERFACE,
    SemanticTokenType::CLASS,
    SemanticTokenType::PROPERTY,
    SemanticTokenType::PARAMETER,
    SemanticTokenType::VARIABLE,
    SemanticTokenType::FUNCTION,
    SemanticTokenType::METHOD,
    SemanticTokenType::EVENT,
    SemanticTokenType::new("task"),
    SemanticTokenType::new("port"),
    SemanticTokenType::new("inactive"),
    SemanticTokenType::new("directive"),
];

/// Names in the order of the bits of `TokenModifiers`.
const MODIFIERS: [SemanticTokenModifier; 7] = [
    SemanticTokenModifier::DECLARATION,
    SemanticTokenModifier::DEFINITION,
    SemanticTokenModifier::READONLY,
    SemanticTokenModifier::MODIFICATION,
    SemanticTokenModifier::ASYNC,
    SemanticTokenModifier::DOCUMENTATION,
    SemanticTokenModifier::DEFAULT_LIBRARY,
];

/// The legend of [`encode`].
pub(crate) fn legend() -> SemanticTokensLegend {
    SemanticTokensLegend { token_types: TYPES.to_vec(), token_modifiers: MODIFIERS.to_vec() }
}

/// Relative tokens. A token with several lines becomes one per line, because few clients accept others.
pub fn encode(tokens: &[Token], lines: &Lines) -> Vec<SemanticToken> {
    let mut encoded = Vec::with_capacity(tokens.len());
    let (mut last_line, mut last_start) = (0, 0);
    for token in tokens {
        let range = lines.range(&token.range);
        for line in range.start.line..=range.end.line {
            let Some(content) = lines.line(line) else {
                break;
            };
            let start = if line == range.start.line { range.start.character } else { 0 };
            let end = if line == range.end.line {
                range.end.character
            } else {
                lines.position(content.end).character
            };
            if start >= end {
                continue;
            }
            if line != last_line {
                last_start = 0;
            }
            encoded.push(SemanticToken {
                delta_line: line - last_line,
                delta_start: start - last_start,
                length: end - start,
                token_type: token.ty as u32,
                token_modifiers_bitset: token.modifiers.0,
            });
            (last_line, last_start) = (line, start);
        }
    }
    encoded
}

#[cfg(test)]
mod tests {
    use dotgen_analysis::ide::TokenModifiers;

    use super::*;
    use crate::protocol::convert::Encoding;

    fn token(range: std::ops::Range<usize>) -> Token {
        Token { range, ty: TokenType::Comment, modifiers: TokenModifiers::NONE }
    }

    fn plain(tokens: &[SemanticToken]) -> Vec<[u32; 3]> {
        let numbers = |token: &SemanticToken| [token.delta_line, token.delta_start, token.length];
        tokens.iter().map(numbers).collect()
    }

    #[test]
    fn a_token_over_several_lines_is_split() {
        let lines = Lines::new("x /* 😀\r\n\r\n b */ y".into(), Encoding::Utf16);
        let end = lines.text().len();
        let encoded = encode(&[token(2..end - 2), token(end - 1..end)], &lines);
        assert_eq!(plain(&encoded), [[0, 2, 5], [2, 0, 5], [0, 6, 1]]);
    }
}
