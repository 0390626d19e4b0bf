//! Services, codels, their parameters and default values.

use dotgen_syntax::{
    SyntaxKind,
    ast::{self, AstNode},
};

use super::{CollectExact, Lowering};
use crate::item_tree::{
    CodelDecl, Designator, Dir, InitValue, Initializer, ParamDecl, ParamSpec, PathStep,
    ServiceDecl, ServiceKind, Source, StateRef, WcetClause,
};

impl Lowering<'_> {
    pub(super) fn service(&mut self, it: &ast::Service) -> ServiceDecl {
        ServiceDecl {
            ptr: self.node(it.syntax()),
            kind: if it.attribute_token().is_some() {
                ServiceKind::Attribute
            } else if it.function_token().is_some() {
                ServiceKind::Function
            } else {
                ServiceKind::Activity
            },
            name: self.name(it.name()),
            params: self.params(it.param_list()),
            properties: self.body(it),
        }
    }

    pub(super) fn codel(&mut self, it: &ast::Codel, is_async: bool) -> CodelDecl {
        CodelDecl {
            ptr: self.node(it.syntax()),
            is_async,
            triggers: it.triggers().map(|it| self.states(it.states())),
            name: self.name(it.name()),
            params: self.params(it.param_list()),
            yields: it.yields().map(|it| self.states(it.states())),
            wcet: it
                .wcets()
                .map(|it| WcetClause {
                    ptr: self.node(it.syntax()),
                    bare: it.is_bare(),
                    duration: it
                        .quantity()
                        .filter(|it| it.expr().is_some())
                        .map(|it| self.duration(&it)),
                })
                .collect_exact(),
        }
    }

    fn states(&mut self, states: ast::AstChildren<ast::State>) -> Vec<StateRef> {
        states
            .filter_map(|it| {
                Some(StateRef {
                    ptr: self.node(it.syntax()),
                    paused: it.is_paused(),
                    name: self.name_ref(it.name_ref())?,
                })
            })
            .collect_exact()
    }

    fn params(&mut self, list: Option<ast::ParamList>) -> Vec<ParamDecl> {
        list.into_iter()
            .flat_map(|it| it.params())
            .filter_map(|it| self.param(&it))
            .collect_exact()
    }

    fn param(&mut self, it: &ast::Param) -> Option<ParamDecl> {
        let ptr = self.node(it.syntax());
        let (dir, spec, init) = match it {
            ast::Param::TypedParam(it) => (
                it.dir_token(),
                ParamSpec::Typed {
                    ty: Box::new(self.type_ref(it.type_spec(), it.syntax())),
                    declarator: it
                        .declarator()
                        .and_then(|it| self.declarator(&it))
                        .map(Box::new),
                },
                it.initializer(),
            ),
            ast::Param::PathParam(it) => {
                let source = it.source_token().and_then(|token| {
                    let source = match token.kind() {
                        SyntaxKind::IDS_KW => Source::Ids,
                        SyntaxKind::LOCAL_KW => Source::Local,
                        SyntaxKind::PORT_KW => Source::Port,
                        SyntaxKind::REMOTE_KW => Source::Remote,
                        _ => return None,
                    };
                    Some((source, self.token(&token)))
                });
                let path: Vec<PathStep> = it
                    .path()
                    .into_iter()
                    .flat_map(|it| it.steps())
                    .filter_map(|it| self.path_step(&it))
                    .collect_exact();
                let rename = it.rename().and_then(|it| self.name(it.name()));
                if path.is_empty() && rename.is_none() {
                    return None;
                }
                let spec = ParamSpec::Path {
                    source,
                    path,
                    rename: rename.map(Box::new),
                };
                (it.dir_token(), spec, it.initializer())
            }
        };
        let dir = match dir?.kind() {
            SyntaxKind::IN_KW => Dir::In,
            SyntaxKind::OUT_KW => Dir::Out,
            _ => Dir::Inout,
        };
        Some(ParamDecl {
            dir,
            spec,
            init: init.map(|it| Box::new(self.initializer(&it))),
            ptr,
        })
    }

    fn path_step(&mut self, it: &ast::PathStep) -> Option<PathStep> {
        Some(match it {
            ast::PathStep::MemberStep(it) => PathStep::Member(self.name_ref(it.name_ref())?),
            ast::PathStep::IndexStep(it) => PathStep::Index(self.expr(it.expr(), it.syntax())),
        })
    }

    fn initializer(&mut self, it: &ast::Initializer) -> Initializer {
        let node = it.syntax();
        Initializer {
            ptr: self.node(node),
            designator: it.designator().and_then(|it| {
                Some(match it {
                    ast::Designator::MemberDesignator(it) => {
                        Designator::Member(self.name_ref(it.name_ref())?)
                    }
                    ast::Designator::IndexDesignator(it) => {
                        Designator::Index(self.expr(it.expr(), it.syntax()))
                    }
                })
            }),
            value: match (it.initializer_list(), it.expr()) {
                (Some(list), _) => Some(InitValue::Compound(
                    list.initializers()
                        .map(|it| self.initializer(&it))
                        .collect_exact(),
                )),
                (None, Some(expr)) => Some(InitValue::Scalar(self.expr(Some(expr), node))),
                (None, None) => None,
            },
            doc: it.doc().map(|it| self.literal(it.text(), it.syntax())),
        }
    }
}
