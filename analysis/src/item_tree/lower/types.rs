//! Types, declarators, expressions and quantities.

use dotgen_syntax::{
    SyntaxKind, SyntaxNode, SyntaxToken,
    ast::{self, AstChildren, AstNode, LiteralKind},
};
use smol_str::SmolStr;

use super::{CollectExact, Lowering};
use crate::item_tree::{
    Declarator, Duration, Expr, ExprKind, Path, Ptr, TypeDecl, TypeDeclKind, TypeRef, TypeRefKind,
};
use crate::model::TypeKind;

impl Lowering<'_> {
    /// A type; if it is missing, `owner` is reported.
    pub(super) fn type_ref(&mut self, ty: Option<ast::TypeSpec>, owner: &SyntaxNode) -> TypeRef {
        let Some(ty) = ty else {
            return TypeRef { kind: TypeRefKind::Missing, ptr: self.node(owner) };
        };
        let node = ty.syntax();
        let ptr = self.node(node);
        let kind = match &ty {
            ast::TypeSpec::BaseType(ty) => base_type(ty).map(TypeRefKind::Base),
            ast::TypeSpec::StringType(ty) => Some(TypeRefKind::String {
                bound: ty.bound().map(|bound| self.expr(Some(bound), node)),
            }),
            ast::TypeSpec::SequenceType(ty) => Some(TypeRefKind::Sequence {
                element: Box::new(self.type_ref(ty.element(), node)),
                bound: ty.bound().map(|bound| self.expr(Some(bound), node)),
            }),
            ast::TypeSpec::OptionalType(ty) => {
                Some(TypeRefKind::Optional { element: Box::new(self.type_ref(ty.element(), node)) })
            }
            ast::TypeSpec::FixedType(_) => Some(TypeRefKind::Fixed),
            ast::TypeSpec::NamedType(ty) => {
                ty.path().and_then(|path| self.path(&path)).map(TypeRefKind::Named)
            }
            ast::TypeSpec::Struct(structure) => {
                let name = self.name(structure.name());
                let members = self.body(structure);
                Some(inline(name, TypeDeclKind::Struct { members }, ptr))
            }
            ast::TypeSpec::Union(union) => {
                let name = self.name(union.name());
                let switch = self.type_ref(union.switch_type(), node);
                let cases = self.body(union);
                Some(inline(name, TypeDeclKind::Union { switch, cases }, ptr))
            }
            ast::TypeSpec::Enum(enumeration) => {
                let name = self.name(enumeration.name());
                let enumerators = enumeration
                    .enumerator_list()
                    .into_iter()
                    .flat_map(|enumerator| enumerator.enumerators())
                    .filter_map(|enumerator| self.name(enumerator.name()))
                    .collect_exact();
                Some(inline(name, TypeDeclKind::Enum { enumerators }, ptr))
            }
        };
        TypeRef { kind: kind.unwrap_or(TypeRefKind::Missing), ptr }
    }

    pub(super) fn declarators(&mut self, all: AstChildren<ast::Declarator>) -> Vec<Declarator> {
        all.filter_map(|child| self.declarator(&child)).collect_exact()
    }

    pub(super) fn declarator(&mut self, declarator: &ast::Declarator) -> Option<Declarator> {
        Some(Declarator {
            name: self.name(declarator.name())?,
            dimensions: declarator
                .dimensions()
                .map(|dimension| self.expr(dimension.expr(), dimension.syntax()))
                .collect_exact(),
        })
    }

    /// A path; `None` if it names nothing.
    pub(super) fn path(&mut self, path: &ast::Path) -> Option<Path> {
        let ptr = self.node(path.syntax());
        let segments = self.names(path.segments());
        (!segments.is_empty()).then(|| Path { absolute: path.is_absolute(), segments, ptr })
    }

    /// An expression; if it is missing, `owner` is reported.
    pub(super) fn expr(&mut self, expr: Option<ast::Expr>, owner: &SyntaxNode) -> Expr {
        let Some(expr) = expr else {
            return Expr { kind: ExprKind::Missing, ptr: self.node(owner) };
        };
        let node = expr.syntax().clone();
        let ptr = self.node(&node);
        let kind = match expr {
            ast::Expr::Literal(literal) => self.literal_kind(&literal),
            ast::Expr::PathExpr(expression) => expression
                .path()
                .and_then(|path| self.path(&path))
                .map_or(ExprKind::Missing, ExprKind::Path),
            ast::Expr::ParenExpr(expression) => {
                ExprKind::Paren(Box::new(self.expr(expression.expr(), &node)))
            }
            ast::Expr::PrefixExpr(expression) => match expression.op_token() {
                Some(token) => ExprKind::Unary {
                    op: token.kind(),
                    op_ptr: self.token(&token),
                    operand: Box::new(self.expr(expression.expr(), &node)),
                },
                None => ExprKind::Missing,
            },
            ast::Expr::BinaryExpr(expression) => {
                let left = Box::new(self.expr(expression.lhs(), &node));
                match expression.op_token() {
                    Some(token) => ExprKind::Binary {
                        op: token.kind(),
                        op_ptr: self.token(&token),
                        left,
                        right: Box::new(self.expr(expression.rhs(), &node)),
                    },
                    None => left.kind,
                }
            }
        };
        Expr { kind, ptr }
    }

    /// A literal where only a literal may stand.
    pub(super) fn literal(&mut self, literal: Option<ast::Literal>, owner: &SyntaxNode) -> Expr {
        self.expr(literal.map(ast::Expr::Literal), owner)
    }

    fn literal_kind(&mut self, literal: &ast::Literal) -> ExprKind {
        match literal.kind() {
            Some(LiteralKind::Bool(value)) => ExprKind::Bool(value),
            Some(LiteralKind::Int(token)) => ExprKind::Int(self.map.text(&token)),
            Some(LiteralKind::Float(token)) => ExprKind::Float(self.map.text(&token)),
            Some(LiteralKind::Fixed(_)) => ExprKind::Fixed,
            Some(LiteralKind::Char(token)) => ExprKind::Char(self.map.text(&token)),
            Some(LiteralKind::Strings(tokens)) => ExprKind::Str(
                tokens
                    .iter()
                    .map(|token| (self.string_text(token), self.token(token)))
                    .collect_exact(),
            ),
            None => ExprKind::Missing,
        }
    }

    /// The spelling of a string, with a missing closing quote added.
    fn string_text(&self, token: &SyntaxToken) -> SmolStr {
        let text = self.map.text(token);
        match token.kind() {
            SyntaxKind::OPEN_STRING => format!("{}\"", text.trim_end_matches('\n')).into(),
            _ => text,
        }
    }

    /// A number with an optional unit.
    pub(super) fn duration(&mut self, quantity: &ast::Quantity) -> Duration {
        let node = quantity.syntax();
        Duration {
            ptr: self.node(node),
            value: self.expr(quantity.expr(), node),
            unit: quantity.unit_token().map(|token| (token.kind(), self.token(&token))),
            glued: quantity.is_glued(self.map),
        }
    }

    pub(super) fn duration_or_missing(
        &mut self,
        quantity: Option<ast::Quantity>,
        owner: &SyntaxNode,
    ) -> Duration {
        match quantity {
            Some(quantity) => self.duration(&quantity),
            None => Duration {
                ptr: self.node(owner),
                value: self.expr(None, owner),
                unit: None,
                glued: false,
            },
        }
    }
}

fn inline(name: Option<crate::item_tree::Name>, kind: TypeDeclKind, ptr: Ptr) -> TypeRefKind {
    TypeRefKind::Inline(Box::new(TypeDecl { name, kind, ptr }))
}

/// `None` for unused reserved words and for errors reported by the grammar.
fn base_type(ty: &ast::BaseType) -> Option<TypeKind> {
    use SyntaxKind as K;
    let words: Vec<SyntaxKind> = ty.words().collect();
    Some(match words.as_slice() {
        [K::BOOLEAN_KW] => TypeKind::Boolean,
        [K::OCTET_KW] => TypeKind::Octet,
        [K::CHAR_KW] => TypeKind::Char,
        [K::ANY_KW] => TypeKind::Any,
        [K::FLOAT_KW] => TypeKind::Float,
        [K::DOUBLE_KW] => TypeKind::Double,
        [K::SHORT_KW] => TypeKind::Short,
        [K::LONG_KW] => TypeKind::Long,
        [K::LONG_KW, K::LONG_KW] => TypeKind::LongLong,
        [K::UNSIGNED_KW, K::SHORT_KW] => TypeKind::UnsignedShort,
        [K::UNSIGNED_KW, K::LONG_KW] => TypeKind::UnsignedLong,
        [K::UNSIGNED_KW, K::LONG_KW, K::LONG_KW] => TypeKind::UnsignedLongLong,
        _ => return None,
    })
}
