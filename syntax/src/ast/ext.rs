//! Accessors that the grammar file cannot express.

use smol_str::SmolStr;

use crate::{
    ExpansionMap, SyntaxElement,
    SyntaxKind::{self, *},
    SyntaxNode, SyntaxToken, TextRange,
    ast::{
        AstNode, BaseType, BinaryExpr, Body, CodelProperty, Component, Directive, Exception, Expr,
        HasBody, Ids, IncludePath, Literal, Module, Name, NameRef, Path, PathParam, Port,
        PragmaArg, PrefixExpr, Property, Quantity, Service, State, Struct, Task, TypedParam, Union,
        Wcet,
    },
    fragment::Fragment,
};

macro_rules! have_body {
    ($($node:ident),*) => { $(impl HasBody for $node {})* };
}
have_body!(Module, Component, Exception, Struct, Union, Ids, Task, Port, Service);

impl Name {
    /// The name, after macro expansion; empty in a broken tree.
    pub fn text(&self, map: &ExpansionMap) -> SmolStr {
        self.ident_token().map_or_else(SmolStr::default, |token| map.text(&token))
    }

    /// The range to report for this name: the identifier, or the macro call it comes from.
    pub fn range(&self, map: &ExpansionMap) -> TextRange {
        self.ident_token().map_or_else(|| self.syntax().text_range(), |token| map.range(&token))
    }
}

impl NameRef {
    /// The name, after macro expansion; empty in a broken tree.
    pub fn text(&self, map: &ExpansionMap) -> SmolStr {
        self.ident_token().map_or_else(SmolStr::default, |token| map.text(&token))
    }

    /// The range to report for this name: the identifier, or the macro call it comes from.
    pub fn range(&self, map: &ExpansionMap) -> TextRange {
        self.ident_token().map_or_else(|| self.syntax().text_range(), |token| map.range(&token))
    }
}

impl Path {
    /// Starts with `::`.
    pub fn is_absolute(&self) -> bool {
        significant(self.syntax()).next().is_some_and(|element| element.kind() == COLON2)
    }
}

impl BaseType {
    /// The words of the type, in order: `unsigned long long` has three.
    pub fn words(&self) -> impl Iterator<Item = SyntaxKind> {
        tokens(self.syntax()).map(|token| token.kind()).filter(|kind| kind.is_reserved_word())
    }
}

/// The sort of a literal, with its tokens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LiteralKind {
    /// `TRUE` or `FALSE`.
    Bool(bool),
    /// Decimal, octal or hexadecimal.
    Int(SyntaxToken),
    /// With a dot or an exponent.
    Float(SyntaxToken),
    /// With the suffix `d`.
    Fixed(SyntaxToken),
    /// `'x'`
    Char(SyntaxToken),
    /// Adjacent strings, in order.
    Strings(Vec<SyntaxToken>),
}

impl Literal {
    /// The literal's token; the first of adjacent strings.
    pub fn token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax()).find(|token| token.kind().is_literal())
    }

    /// The sort of the literal. A string without an end counts as a string.
    pub fn kind(&self) -> Option<LiteralKind> {
        let token = self.token()?;
        Some(match token.kind() {
            TRUE_KW => LiteralKind::Bool(true),
            FALSE_KW => LiteralKind::Bool(false),
            INT => LiteralKind::Int(token),
            FLOAT => LiteralKind::Float(token),
            FIXED => LiteralKind::Fixed(token),
            CHAR => LiteralKind::Char(token),
            _ => LiteralKind::Strings(
                tokens(self.syntax())
                    .filter(|token| matches!(token.kind(), STRING | OPEN_STRING))
                    .collect(),
            ),
        })
    }
}

impl PrefixExpr {
    /// `-`, `+` or `~`.
    pub fn op_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax()).find(|token| matches!(token.kind(), MINUS | PLUS | TILDE))
    }
}

impl BinaryExpr {
    /// The operand before the operator.
    pub fn lhs(&self) -> Option<Expr> {
        self.syntax()
            .children_with_tokens()
            .take_while(|element| !is_binary_operator(element.kind()))
            .find_map(|element| Expr::cast(element.into_node()?))
    }

    /// `| ^ & << >> + - * / %`
    pub fn op_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax()).find(|token| is_binary_operator(token.kind()))
    }

    /// The operand after the operator.
    pub fn rhs(&self) -> Option<Expr> {
        self.syntax()
            .children_with_tokens()
            .skip_while(|element| !is_binary_operator(element.kind()))
            .find_map(|element| Expr::cast(element.into_node()?))
    }
}

fn is_binary_operator(kind: SyntaxKind) -> bool {
    matches!(kind, PIPE | CARET | AMP | SHL | SHR | PLUS | MINUS | STAR | SLASH | PERCENT)
}

impl Component {
    /// `interface` rather than `component`.
    pub fn is_interface(&self) -> bool {
        self.interface_token().is_some()
    }
}

impl Service {
    /// The word `attribute`, `function` or `activity`.
    pub fn keyword_token(&self) -> Option<SyntaxToken> {
        keyword(self.syntax())
    }
}

impl Property {
    /// The word that names the property. For codels that is `codel`, also after `async`.
    pub fn keyword_token(&self) -> Option<SyntaxToken> {
        match self {
            Property::CodelProperty(property) => property.codel_token(),
            _ => keyword(self.syntax()),
        }
    }
}

impl CodelProperty {
    /// `async codel`
    pub fn is_async(&self) -> bool {
        self.async_token().is_some()
    }
}

impl Quantity {
    /// `s`, `ms`, `us`, `k` or `M`.
    pub fn unit_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax())
            .find(|token| matches!(token.kind(), S_KW | MS_KW | US_KW | K_KW | M_KW))
    }

    /// The unit directly follows a number literal, without a blank (language reference, D29).
    pub fn is_glued(&self, map: &ExpansionMap) -> bool {
        let Some(unit) = self.unit_token() else {
            return false;
        };
        if let Some(token) = map.virtual_token(&unit) {
            return token.glued;
        }
        unit.prev_token().is_some_and(|token| {
            matches!(token.kind(), INT | FLOAT) && !token.text_range().is_empty()
        })
    }
}

impl Wcet {
    /// Written without the word `wcet`.
    pub fn is_bare(&self) -> bool {
        self.wcet_token().is_none()
    }
}

impl State {
    /// `pause::` in front.
    pub fn is_paused(&self) -> bool {
        self.pause_token().is_some()
    }
}

impl TypedParam {
    /// `in`, `out` or `inout`.
    pub fn dir_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax()).find(|token| matches!(token.kind(), IN_KW | OUT_KW | INOUT_KW))
    }
}

impl PathParam {
    /// `ids`, `local`, `port` or `remote`.
    pub fn source_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax())
            .find(|token| matches!(token.kind(), IDS_KW | LOCAL_KW | PORT_KW | REMOTE_KW))
    }

    /// `in`, `out` or `inout`.
    pub fn dir_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax()).find(|token| matches!(token.kind(), IN_KW | OUT_KW | INOUT_KW))
    }
}

/// The meaning of a directive line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DirectiveKind {
    Include,
    Define,
    Undef,
    If,
    Ifdef,
    Ifndef,
    Elif,
    Else,
    Endif,
    Error,
    Warning,
    Line,
    Pragma,
    /// Anything else, which the preprocessor ignores.
    Unknown,
}

impl Directive {
    /// The word after `#`.
    pub fn keyword_token(&self) -> Option<SyntaxToken> {
        tokens(self.syntax()).find(|token| token.kind() == IDENT || token.kind().is_keyword())
    }

    /// The meaning of the directive. `_Pragma("…")` in the text is a pragma.
    pub fn kind(&self) -> DirectiveKind {
        match self.keyword_token().as_ref().map_or("", |token| token.text()) {
            "include" => DirectiveKind::Include,
            "define" => DirectiveKind::Define,
            "undef" => DirectiveKind::Undef,
            "if" => DirectiveKind::If,
            "ifdef" => DirectiveKind::Ifdef,
            "ifndef" => DirectiveKind::Ifndef,
            "elif" => DirectiveKind::Elif,
            "else" => DirectiveKind::Else,
            "endif" => DirectiveKind::Endif,
            "error" => DirectiveKind::Error,
            "warning" => DirectiveKind::Warning,
            "line" => DirectiveKind::Line,
            "pragma" | "_Pragma" => DirectiveKind::Pragma,
            _ => DirectiveKind::Unknown,
        }
    }
}

impl Body {
    /// The kind of items in this body, according to the declaration it belongs to.
    pub fn fragment(&self) -> Option<Fragment> {
        Some(match self.syntax().parent()?.kind() {
            MODULE => Fragment::Module,
            COMPONENT => Fragment::Component,
            STRUCT | EXCEPTION | IDS => Fragment::Members,
            UNION => Fragment::Cases,
            TASK | PORT | SERVICE => Fragment::Properties,
            _ => return None,
        })
    }
}

impl IncludePath {
    /// The operand as written: `"f"`, `<f>` or a macro.
    pub fn text(&self) -> String {
        self.syntax().text().to_string()
    }
}

impl PragmaArg {
    /// The argument, quotes removed.
    pub fn text(&self) -> String {
        let text = self.syntax().text().to_string();
        match text.strip_prefix('"') {
            Some(rest) => rest.strip_suffix('"').unwrap_or(rest).to_owned(),
            None => text,
        }
    }
}

/// The tokens directly below a node, trivia excluded.
fn tokens(node: &SyntaxNode) -> impl Iterator<Item = SyntaxToken> {
    node.children_with_tokens()
        .filter_map(SyntaxElement::into_token)
        .filter(|token| !token.kind().is_trivia())
}

/// The children of a node that the grammar put there.
fn significant(node: &SyntaxNode) -> impl Iterator<Item = SyntaxElement> {
    node.children_with_tokens().filter(|element| {
        !element.kind().is_trivia() && !matches!(element.kind(), DIRECTIVE | INACTIVE | MACRO_CALL)
    })
}

/// The leading keyword of a declaration.
fn keyword(node: &SyntaxNode) -> Option<SyntaxToken> {
    significant(node)
        .next()
        .and_then(SyntaxElement::into_token)
        .filter(|token| token.kind().is_keyword())
}
