//! Semantic tokens of scenarios: colours by the meaning of names.

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::{SemanticToken as Token, TokenModifiers, TokenType};
use dotgen_timing::scn::lexer::{Kind, lex};
use dotgen_timing::scn::names::{Names, Target};
use dotgen_timing::scn::words;
use rustc_hash::FxHashMap;

use super::read;
use crate::features::specification::semantic_tokens;
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// The tokens of a whole scenario.
pub(super) fn full(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &SemanticTokensParams,
) -> Answer<Option<SemanticTokensResult>> {
    semantic_tokens::encoded(snapshot, subject, tokens(snapshot, subject)?)
}

/// The tokens of a part of a scenario.
pub(super) fn range(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SemanticTokensRangeParams,
) -> Answer<Option<SemanticTokensRangeResult>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let part = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    let mut tokens = tokens(snapshot, subject)?;
    tokens.retain(|token| touches(&token.range, &part));
    semantic_tokens::encoded(snapshot, subject, tokens)
}

fn tokens(snapshot: &Snapshot, subject: &Subject) -> Cancellable<Vec<Token>> {
    let problem = read(snapshot, &subject.path)?;
    let specs = problem.specs();
    let names = Names::new(&specs);
    let references = names.references(&problem.scenario).into_iter();
    let types = references.map(|reference| (reference.range.start, type_of(&reference.target)));
    let types: FxHashMap<usize, TokenType> = types.collect();
    let text = &problem.text;
    let mut before = None;
    let mut out = Vec::new();
    for token in lex(text) {
        let word = &text[token.range.clone()];
        let ty = match token.kind {
            Kind::LineComment | Kind::BlockComment | Kind::UnclosedComment => {
                Some(TokenType::Comment)
            }
            Kind::Text | Kind::UnclosedText => Some(TokenType::String),
            Kind::Number | Kind::Real => Some(TokenType::Number),
            Kind::Implies
            | Kind::Arrow
            | Kind::AtMost
            | Kind::AtLeast
            | Kind::Below
            | Kind::Above
            | Kind::Equal
            | Kind::Unequal => Some(TokenType::Operator),
            Kind::Name => types.get(&token.range.start).copied().or_else(|| {
                let is_name =
                    token.range == problem.scenario.name_range || before == Some(Kind::Dot);
                (!is_name && words::is_word(word)).then_some(TokenType::Keyword)
            }),
            _ => None,
        };
        if !token.kind.is_trivia() {
            before = Some(token.kind);
        }
        out.extend(ty.map(|ty| Token { range: token.range, ty, modifiers: TokenModifiers::NONE }));
    }
    Ok(out)
}

/// The type of a name, as in specifications.
fn type_of(target: &Target) -> TokenType {
    match target {
        Target::Component(_) => TokenType::Class,
        Target::Task(..) => TokenType::Task,
        Target::Service(..) => TokenType::Method,
        Target::Port(..) | Target::Member(..) => TokenType::Port,
        Target::State(..) => TokenType::Event,
        Target::Codel(..) => TokenType::Function,
        Target::Client(_) | Target::Step(..) => TokenType::Variable,
        Target::Status(_) => TokenType::Keyword,
    }
}
