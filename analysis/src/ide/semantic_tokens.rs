//! Semantic tokens: colours by the meaning of names.

use std::ops::Range;

use dotgen_syntax::{SyntaxElement, SyntaxKind, SyntaxToken, TextRange, TextSize, WalkEvent};
use rustc_hash::FxHashMap;

use super::{AccessKind, FileView, SemanticToken, TokenModifiers, TokenType, resolve::occurrences};
use crate::{
    elab::DefKind,
    source_map::{bytes, text_range},
};

/// The tokens of a file, or those that touch a range, in text order.
pub(crate) fn semantic_tokens(
    view: &FileView<'_>,
    within: Option<Range<usize>>,
) -> Vec<SemanticToken> {
    let within = within.as_ref().map(text_range);
    let definitions = &view.elaborated().definitions;
    let mut names: FxHashMap<TextRange, (DefKind, AccessKind)> = FxHashMap::default();
    for occurrence in occurrences(view.db, view.unit, view.file) {
        let Some(definition) = definitions.get(occurrence.target) else {
            continue;
        };
        names.entry(occurrence.range).or_insert((definition.kind, occurrence.access));
    }
    let macros = view.pre().macro_uses.iter().filter(|usage| usage.site.is_some());
    let mut tokens = Tokens {
        names,
        macros: macros.map(|definition| definition.range.start()).collect(),
        out: Vec::new(),
    };
    let mut events = view.root().preorder_with_tokens();
    while let Some(event) = events.next() {
        let WalkEvent::Enter(element) = event else {
            continue;
        };
        let outside = within.is_some_and(|range| range.intersect(element.text_range()).is_none());
        match element {
            SyntaxElement::Node(node) if outside => {
                _ = node;
                events.skip_subtree();
            }
            SyntaxElement::Node(node) if node.kind() == SyntaxKind::INACTIVE => {
                tokens.push(node.text_range(), TokenType::Inactive, TokenModifiers::NONE);
                events.skip_subtree();
            }
            SyntaxElement::Token(token) if !outside => tokens.token(&token),
            _ => {}
        }
    }
    tokens.out
}

struct Tokens {
    names: FxHashMap<TextRange, (DefKind, AccessKind)>,
    macros: Vec<TextSize>,
    out: Vec<SemanticToken>,
}

impl Tokens {
    fn push(&mut self, range: TextRange, ty: TokenType, modifiers: TokenModifiers) {
        if !range.is_empty() {
            self.out.push(SemanticToken { range: bytes(range), ty, modifiers });
        }
    }

    fn token(&mut self, token: &SyntaxToken) {
        if token.text_range().is_empty() {
            return;
        }
        if let Some((ty, modifiers)) = self.classify(token) {
            self.push(token.text_range(), ty, modifiers);
        }
    }

    fn classify(&self, token: &SyntaxToken) -> Option<(TokenType, TokenModifiers)> {
        use SyntaxKind as K;
        const NONE: TokenModifiers = TokenModifiers::NONE;
        let kind = token.kind();
        let parent = token.parent().map_or(K::ERROR, |parent| parent.kind());
        if kind.is_comment() {
            return Some((TokenType::Comment, NONE));
        }
        if kind.is_trivia() {
            return None;
        }
        if self.macros.binary_search(&token.text_range().start()).is_ok() {
            return Some((TokenType::Macro, NONE));
        }
        if let Some(&(definition, access)) = self.names.get(&token.text_range()) {
            // `ids { }` is declared by its keyword, and has no other name.
            return Some(match (definition, access) {
                (DefKind::Ids, AccessKind::Declaration) => (TokenType::Keyword, NONE),
                _ => name(definition, access),
            });
        }
        if let Some(found) = directive_token(token, parent) {
            return found;
        }
        Some(match kind {
            K::STRING | K::OPEN_STRING | K::CHAR => (TokenType::String, string_modifiers(token)),
            K::INT | K::FLOAT | K::FIXED => (TokenType::Number, NONE),
            _ if is_base_type(kind) => (TokenType::Type, TokenModifiers::DEFAULT_LIBRARY),
            _ if kind.is_keyword() => (TokenType::Keyword, NONE),
            K::IDENT => return unresolved(token, parent),
            K::PLUS
            | K::MINUS
            | K::STAR
            | K::SLASH
            | K::PERCENT
            | K::CARET
            | K::AMP
            | K::PIPE
            | K::TILDE
            | K::SHL
            | K::SHR
            | K::EQ => (TokenType::Operator, NONE),
            _ => return None,
        })
    }
}

/// Tokens of directives; the outer `None` for others.
fn directive_token(
    token: &SyntaxToken,
    parent: SyntaxKind,
) -> Option<Option<(TokenType, TokenModifiers)>> {
    use SyntaxKind as K;
    const NONE: TokenModifiers = TokenModifiers::NONE;
    let directive = token.parent_ancestors().find(|ancestor| ancestor.kind() == K::DIRECTIVE)?;
    let kind = token.kind();
    Some(match parent {
        K::DIRECTIVE => Some((TokenType::Directive, NONE)),
        K::INCLUDE_PATH | K::PRAGMA_ARG => Some((TokenType::String, NONE)),
        K::NAME => Some((TokenType::Macro, TokenModifiers::DECLARATION)),
        K::NAME_REF => {
            let word = directive.first_child();
            let in_params =
                token.parent_ancestors().any(|ancestor| ancestor.kind() == K::MACRO_PARAMS);
            let is_word = word.is_some_and(|word| word.text_range() == token.text_range());
            let pragma = dotgen_syntax::ast::AstNode::cast(directive)
                .map(|node: dotgen_syntax::ast::Directive| node.kind());
            Some(match pragma {
                _ if in_params => (TokenType::Parameter, TokenModifiers::DECLARATION),
                Some(dotgen_syntax::ast::DirectiveKind::Pragma) if is_word => {
                    (TokenType::Directive, NONE)
                }
                Some(dotgen_syntax::ast::DirectiveKind::Pragma) => (TokenType::Function, NONE),
                _ => (TokenType::Macro, NONE),
            })
        }
        _ => match kind {
            K::STRING | K::OPEN_STRING | K::CHAR => Some((TokenType::String, NONE)),
            K::INT | K::FLOAT | K::FIXED => Some((TokenType::Number, NONE)),
            _ => None,
        },
    })
}

fn name(kind: DefKind, access: AccessKind) -> (TokenType, TokenModifiers) {
    let ty = match kind {
        DefKind::Module => TokenType::Namespace,
        DefKind::Component => TokenType::Class,
        DefKind::Interface => TokenType::Interface,
        DefKind::Typedef | DefKind::Native => TokenType::Type,
        DefKind::Struct | DefKind::Union | DefKind::Exception => TokenType::Struct,
        DefKind::Enum => TokenType::Enum,
        DefKind::Enumerator => TokenType::EnumMember,
        DefKind::Member | DefKind::IdsMember | DefKind::Ids => TokenType::Property,
        DefKind::Const | DefKind::Local => TokenType::Variable,
        DefKind::Task => TokenType::Task,
        DefKind::Port => TokenType::Port,
        DefKind::Attribute | DefKind::Function | DefKind::Activity => TokenType::Method,
        DefKind::Parameter | DefKind::CodelParameter => TokenType::Parameter,
        DefKind::Codel => TokenType::Function,
        DefKind::State => TokenType::Event,
    };
    let mut modifiers = match access {
        AccessKind::Declaration => TokenModifiers::DECLARATION,
        AccessKind::Write | AccessKind::ReadWrite => TokenModifiers::MODIFICATION,
        AccessKind::Mention | AccessKind::Read => TokenModifiers::NONE,
    };
    if matches!(kind, DefKind::Const | DefKind::Enumerator) {
        modifiers = modifiers.with(TokenModifiers::READONLY);
    }
    (ty, modifiers)
}

/// The type of an unresolved name, by its place in the tree.
fn unresolved(token: &SyntaxToken, parent: SyntaxKind) -> Option<(TokenType, TokenModifiers)> {
    use SyntaxKind as K;
    if !matches!(parent, K::NAME | K::NAME_REF) {
        return None;
    }
    let owner = token.parent()?.parent()?;
    let declared = match parent {
        K::NAME => TokenModifiers::DECLARATION,
        _ => TokenModifiers::NONE,
    };
    let ty = match owner.kind() {
        K::MODULE => TokenType::Namespace,
        K::COMPONENT => TokenType::Class,
        K::INTERFACES_PROPERTY => TokenType::Interface,
        K::STRUCT | K::UNION | K::FORWARD_DECL | K::EXCEPTION => TokenType::Struct,
        K::ENUM => TokenType::Enum,
        K::ENUMERATOR => TokenType::EnumMember,
        K::TASK | K::TASK_PROPERTY => TokenType::Task,
        K::PORT => TokenType::Port,
        K::SERVICE | K::SERVICES_PROPERTY => TokenType::Method,
        K::CODEL => TokenType::Function,
        K::STATE => TokenType::Event,
        K::MACRO_CALL => TokenType::Macro,
        K::NATIVE_DECL => TokenType::Type,
        K::PATH => match owner.parent().map(|parent| parent.kind()) {
            Some(K::NAMED_TYPE | K::THROWS_PROPERTY) => TokenType::Type,
            _ => TokenType::Variable,
        },
        _ => TokenType::Variable,
    };
    Some((ty, declared))
}

fn string_modifiers(token: &SyntaxToken) -> TokenModifiers {
    use SyntaxKind as K;
    let owner = token.parent_ancestors().find(|ancestor| !matches!(ancestor.kind(), K::LITERAL));
    let is_doc = owner.is_some_and(|owner| match owner.kind() {
        K::INITIALIZER_DOC => true,
        K::STRING_PROPERTY => owner.first_token().is_some_and(|token| token.kind() == K::DOC_KW),
        _ => false,
    });
    if is_doc { TokenModifiers::DOCUMENTATION } else { TokenModifiers::NONE }
}

fn is_base_type(kind: SyntaxKind) -> bool {
    use SyntaxKind as K;
    matches!(
        kind,
        K::UNSIGNED_KW
            | K::SHORT_KW
            | K::LONG_KW
            | K::FIXED_KW
            | K::FLOAT_KW
            | K::DOUBLE_KW
            | K::CHAR_KW
            | K::STRING_KW
            | K::BOOLEAN_KW
            | K::OCTET_KW
            | K::ANY_KW
            | K::SEQUENCE_KW
            | K::OPTIONAL_KW
    )
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use expect_test::{Expect, expect};

    use super::super::{SemanticToken, TokenModifiers};
    use crate::test_support::Fixture;

    fn dump(text: &str, tokens: &[SemanticToken]) -> String {
        const NAMES: &[(TokenModifiers, &str)] = &[
            (TokenModifiers::DECLARATION, "declaration"),
            (TokenModifiers::READONLY, "readonly"),
            (TokenModifiers::MODIFICATION, "modification"),
            (TokenModifiers::DOCUMENTATION, "documentation"),
            (TokenModifiers::DEFAULT_LIBRARY, "default"),
        ];
        let mut out = String::new();
        let mut end = 0;
        for token in tokens {
            assert!(end <= token.range.start, "{token:?}");
            end = token.range.end;
            write!(out, "{:?} {:?}", &text[token.range.clone()], token.ty).unwrap();
            for (modifier, name) in NAMES {
                if token.modifiers.contains(*modifier) {
                    write!(out, " {name}").unwrap();
                }
            }
            out.push('\n');
        }
        out
    }

    #[track_caller]
    fn check(text: &str, expected: Expect) {
        let fixture = Fixture::new(text);
        let tokens = fixture.analysis().semantic_tokens("/main.gen".into(), None).unwrap();
        expected.assert_eq(&dump(&fixture.text("/main.gen"), &tokens));
    }

    #[test]
    fn a_component() {
        check(
            r#"
// about
component c {
  ids { long v; };
  task t;
  port out long p;
  activity go(in long speed = 2 : "fast") {
    doc "Goes."; task t;
    codel<start> f(in speed, ids out v, port out p) yield ether;
  };
};
"#,
            expect![[r#"
                "// about" Comment
                "component" Keyword
                "c" Class declaration
                "ids" Keyword
                "long" Type default
                "v" Property declaration
                "task" Keyword
                "t" Task declaration
                "port" Keyword
                "out" Keyword
                "long" Type default
                "p" Port declaration
                "activity" Keyword
                "go" Method declaration
                "in" Keyword
                "long" Type default
                "speed" Parameter declaration
                "=" Operator
                "2" Number
                "\"fast\"" String documentation
                "doc" Keyword
                "\"Goes.\"" String documentation
                "task" Keyword
                "t" Task
                "codel" Keyword
                "start" Event declaration
                "f" Function declaration
                "in" Keyword
                "speed" Parameter
                "ids" Keyword
                "out" Keyword
                "v" Property modification
                "port" Keyword
                "out" Keyword
                "p" Port modification
                "yield" Keyword
                "ether" Event declaration
            "#]],
        );
    }

    #[test]
    fn the_preprocessor() {
        check(
            r#"
#include "none.idl"
#define N 3
#define SEQ(x) sequence<x, N>
#if 0
const long hidden = 1;
#endif
typedef long t;
typedef SEQ(t) u;
const long n = N;
#pragma wcet f 3 ms
"#,
            expect![[r##"
                "#" Directive
                "include" Directive
                "\"none.idl\"" String
                "#" Directive
                "define" Directive
                "N" Macro declaration
                "3" Number
                "#" Directive
                "define" Directive
                "SEQ" Macro declaration
                "N" Macro
                "#" Directive
                "if" Directive
                "0" Number
                "const long hidden = 1;\n" Inactive
                "#" Directive
                "endif" Directive
                "typedef" Keyword
                "long" Type default
                "t" Type declaration
                "typedef" Keyword
                "SEQ" Macro
                "t" Type
                "u" Type declaration
                "const" Keyword
                "long" Type default
                "n" Variable declaration readonly
                "=" Operator
                "N" Macro
                "#" Directive
                "pragma" Directive
                "wcet" Directive
                "f" Function
                "3" Number
            "##]],
        );
    }

    #[test]
    fn names_that_mean_nothing() {
        check(
            "typedef nope t; component c { throws gone; codel<a> f(in b.c) yield d; };",
            expect![[r#"
            "typedef" Keyword
            "nope" Type
            "t" Type declaration
            "component" Keyword
            "c" Class declaration
            "throws" Keyword
            "gone" Type
            "codel" Keyword
            "a" Event
            "f" Function declaration
            "in" Keyword
            "b" Variable
            "c" Variable
            "yield" Keyword
            "d" Event
        "#]],
        );
    }

    #[test]
    fn a_range_gives_the_tokens_that_touch_it() {
        let fixture = Fixture::new("const long a = 1;\nconst long b = 2;\nconst long c = 3;\n");
        let tokens = |range| fixture.analysis().semantic_tokens("/main.gen".into(), range).unwrap();
        let all = tokens(None);
        let some = tokens(Some(18..35));
        assert_eq!(some.len(), all.len() / 3);
        assert!(some.iter().all(|token| all.contains(token)));
    }
}
